// The reference: inside or outside, then the closest point, for every sample of either body, by CGAL alone.
#pragma once

#include "bench/collision/contender.hpp"

namespace tactor::bench {

/// Each sample within the other body's bounding box is asked for its side by exact predicates, and where it is inside
/// for its closest point. Nothing of the project's own code is in it.
std::unique_ptr<Contender> make_cgal_exact(const Pair& pair);

}  // namespace tactor::bench
