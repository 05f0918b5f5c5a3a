// The project's own queries, as contenders.
#pragma once

#include "bench/collision/contender.hpp"
#include "nodes/collision/cell_distance.hpp"

namespace tactor::bench {

/// Samples of either body below `margin` (m) from the other, by SampleTree over CellDistance.
std::unique_ptr<Contender> make_cells(const Pair& pair, double margin, const CellOptions& options = {});

/// The same over ExactDistance.
std::unique_ptr<Contender> make_exact(const Pair& pair);

/// The same over distances at the corners of `cells` cells along the longest side of each body's box, with trilinear
/// interpolation between them and nothing else, to show what that is worth.
std::unique_ptr<Contender> make_trilinear(const Pair& pair, int cells);

/// The least that a query in this form can take: for each sample that the reference found inside the other body, its
/// distance and normal from the face that the reference found nearest. Nothing is searched for.
std::unique_ptr<Contender> make_floor(const Pair& pair);

}  // namespace tactor::bench
