// How many threads the system's BLAS uses.
#pragma once

namespace tactor {

/// Sets OpenBLAS and BLIS to one thread, for this process. Other libraries, the reference BLAS among them, have no
/// threads that this could set.
void use_one_blas_thread();

}  // namespace tactor
