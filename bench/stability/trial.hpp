// A scene as a cell sees it: bodies, coupling, hand, contact query, and when the tool is to rest where.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "bench/stability/cell.hpp"
#include "bench/stability/hand.hpp"
#include "framework/core/scene.hpp"

namespace tactor::bench {

/// The contacts of the moving bodies where they are, for any stiffness: those of a Trial come from it.
using Query = std::function<void(const BodyStates& bodies, ContactSet& set)>;

/// A stretch in which hand and tool are to stand still.
using Rest = StabilityRest;

/// What a cell runs.
struct Trial {
  Scene scene;
  CouplingParameters coupling;
  HandPath hand;
  Query query;
  std::vector<Rest> rests;
  double lever = 0;                ///< m, the arm at which a turn counts as a swing; 0 where nothing turns
  double peak_to_peak_max = 1e-6;  ///< m
};

/// A scene that is run for many cells.
struct TrialScene {
  std::string name;   ///< for files and tables
  std::string title;  ///< a line of prose
  std::vector<double> contact_stiffness, mass, rate, coupling_stiffness;
  std::function<Trial(const Cell&)> make;
  std::vector<std::string> contenders = {};  ///< by name; none: all

  [[nodiscard]] std::vector<Cell> cells() const;
};

/// Damping of one surface in contact, N s/m: the default of Material.
inline const double contact_damping = Material{}.damping;

/// The scenes. Meshes are read from `meshes`, and small ones written into `scratch`.
std::vector<TrialScene> trial_scenes(const std::filesystem::path& meshes, const std::filesystem::path& scratch);

}  // namespace tactor::bench
