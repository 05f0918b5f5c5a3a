// A grid of distances with trilinear interpolation and nothing else, to show what that is worth.
#pragma once

#include "bench/collision/contender.hpp"

namespace tactor::bench {

/// Exact signed distances at the corners of `cells` cells along the longest side of each body's box, as float; between
/// them trilinear interpolation and its gradient. Samples are culled by bounding spheres.
std::unique_ptr<Contender> make_trilinear(const Pair& pair, int cells);

}  // namespace tactor::bench
