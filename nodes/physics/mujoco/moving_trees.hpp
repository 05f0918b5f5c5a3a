// The parts of a model that move apart from each other.
#pragma once

#include <mujoco/mujoco.h>

#include <span>
#include <string>
#include <vector>

#include "nodes/physics/engine/coupled_engine.hpp"

namespace tactor {

/// The trees of a model, numbered from 0. A tree is a child of the world with all that hangs on it, if any of that can
/// move. Trees that an equality joins, or that `<exclude>` names together, are one. Tree 0 has the tool. It also has
/// the trees of tendons, and of actuators that drive no joint, so these always move.
class MovingTrees {
 public:
  /// Number of the body that takes the place of all that stands, in a model that moves some trees alone.
  static constexpr int carrier = 1;

  /// `whole`: the model, which outlives this. `tool`: its body on the coupling.
  MovingTrees(const mjModel& whole, int tool);

  [[nodiscard]] int count() const { return static_cast<int>(geoms_.size()); }
  /// Why all trees have to move; empty where some may stand.
  [[nodiscard]] const std::string& why_whole() const { return why_whole_; }
  /// The tree of a body; -1 for one that never moves.
  [[nodiscard]] int of_body(int body) const { return of_body_[static_cast<std::size_t>(body)]; }
  /// Whether the body stands because its tree does.
  [[nodiscard]] bool stands(int body, Trees moving) const;
  /// Whether a tree stands.
  [[nodiscard]] bool any_stands(Trees moving) const;
  /// Bodies of the model that moves these trees alone, the world among them.
  [[nodiscard]] int bodies(Trees moving) const;
  /// s, of a step with these trees moving from `placed` on, by the model that SteppedEngine::step_cost tells.
  [[nodiscard]] double step_cost(const mjData& placed, Trees moving) const;

  /// The trees to move, as SteppedEngine::near_trees tells. `placed`: with positions and velocities of all bodies and
  /// geoms. `most_bodies`: of the model that moves them alone.
  [[nodiscard]] Trees near(const mjData& placed, const TreeSearch& search, int most_bodies) const;

 private:
  [[nodiscard]] std::vector<int> joined_roots(const mjModel& m, int tool);
  [[nodiscard]] double gap(const mjData& placed, int a, int b) const;
  [[nodiscard]] double gap(const mjData& placed, std::span<const int> first, std::span<const int> second) const;
  [[nodiscard]] int pairs_of(const mjData& placed, int tree, Trees counted) const;
  [[nodiscard]] double speed(const mjData& placed, std::span<const int> geoms) const;

  const mjModel* whole_;
  std::vector<int> of_body_;
  std::vector<std::vector<int>> geoms_;  // by tree
  std::vector<int> bodies_, dofs_;       // by tree, how many
  std::vector<int> of_tool_;             // geoms of the tool and of all that hangs on it
  int fixed_bodies_ = 0;                 // the world among them
  std::string why_whole_;
};

}  // namespace tactor
