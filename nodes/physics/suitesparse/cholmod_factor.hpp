// Cholesky factors by CHOLMOD.
#pragma once

#include <memory>

#include "nodes/physics/deformable/sparse_factor.hpp"

namespace tactor {

/// By CHOLMOD (Chen, Davis, Hager and Rajamanickam, TOMS 2008), with the nodes ordered by minimum degree, or by nested
/// dissection (METIS) where they are many. Where an order has to be found, two threads must not do so at once: METIS
/// draws from the C library's random numbers, which it seeds anew each time.
std::unique_ptr<SparseFactor> make_simplicial_factor();
/// The BLAS is set to one thread: OpenBLAS and BLIS by their own functions; others are taken as they are.
std::unique_ptr<SparseFactor> make_supernodal_factor();

}  // namespace tactor
