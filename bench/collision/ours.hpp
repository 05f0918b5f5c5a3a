// The project's own queries, as contenders.
#pragma once

#include <filesystem>
#include <optional>

#include "bench/collision/contender.hpp"
#include "nodes/physics/geometry/cell_distance.hpp"

namespace tactor::bench {

/// Samples of either body below `margin` (m) from the other, by SampleTree over CellDistance.
std::unique_ptr<Contender> make_tactor(const Pair& pair, double margin, const CellOptions& options = {});

/// The files of a pair's meshes, as a scene names them.
struct MeshFiles {
  std::filesystem::path fixed, tool;
};

/// The whole query of collision.sdf, into a ContactSet, with its default parameters but for the margin and the spacing
/// of samples that are given (m).
std::unique_ptr<Contender> make_sdf_node(const Pair& pair, const MeshFiles& files, std::optional<double> margin = {},
                                         std::optional<double> spacing = {});

/// As make_tactor over ExactDistance.
std::unique_ptr<Contender> make_exact(const Pair& pair);

/// The same over distances at the corners of `cells` cells along the longest side of each body's box, with trilinear
/// interpolation between them and nothing else, to show what that is worth.
std::unique_ptr<Contender> make_trilinear(const Pair& pair, int cells);

/// The least that a query in this form can take: for each sample that the reference found inside the other body, its
/// distance and normal from the face that the reference found nearest. Nothing is searched for.
std::unique_ptr<Contender> make_floor(const Pair& pair);

}  // namespace tactor::bench
