// The scenes of the benchmark. Each gives its metrics as JSON.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace tactor::bench {

struct SceneOptions {
  std::filesystem::path meshes;  ///< where the build put them
  int samples = 7000;            ///< of a trajectory
  bool cold = true;              ///< measure with swept caches too
  bool grids = true;             ///< measure grids of several resolutions
};

/// Two bunnies of 20,990 triangles, pressed and slid; then the same for grids of several resolutions.
nlohmann::ordered_json bunny_scene(const SceneOptions& options);

/// A peg in a plate with a hole, 356 triangles in all, and what its samples miss.
nlohmann::ordered_json peg_scene(const SceneOptions& options);

/// The closest point of a duck to a point that moves beside it, and far from it.
nlohmann::ordered_json duck_scene(const SceneOptions& options);

/// Bunnies of about 5,000 to 300,000 triangles.
nlohmann::ordered_json growth_scene(const SceneOptions& options);

/// The whole physics step of two bunnies on that path, and its parts.
nlohmann::ordered_json physics_scene(const SceneOptions& options);

/// A step of dynamics by the number of contacts.
nlohmann::ordered_json dynamics_scene(const SceneOptions& options);

/// How long the cells of each mesh take to build, to build and keep, and to load.
nlohmann::ordered_json build_scene(const SceneOptions& options);

}  // namespace tactor::bench
