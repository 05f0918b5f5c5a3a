// The project's own queries, as contenders.
#pragma once

#include "bench/collision/contender.hpp"

namespace tactor::bench {

/// Samples of either body below `margin` (m) from the other, by SampleTree over ExactDistance.
std::unique_ptr<Contender> make_sample_tree(const Pair& pair, double margin);

/// The least that a query in this form can take: for each sample that the reference found inside the other body, its
/// distance and normal from the face that the reference found nearest. Nothing is searched for.
std::unique_ptr<Contender> make_floor(const Pair& pair);

}  // namespace tactor::bench
