// A model in which some trees move and the rest stands, made anew without memory of the heap.
#pragma once

#include <mujoco/mujoco.h>

#include <cstddef>
#include <vector>

#include "nodes/physics/mujoco/model_file.hpp"
#include "nodes/physics/mujoco/moving_trees.hpp"

namespace tactor {

/// The whole state of a scene, and a model that moves some of its trees. All bodies of still trees become one body
/// without a joint, the carrier, which holds their geoms where the state has them, as geoms of the world. So the model
/// has only the degrees of freedom of the trees that move, and no contact between two that stand. MuJoCo takes it for a
/// model that was read from a file.
///
/// The arrays of the model have room for the whole one, so another choice of trees copies rows and numbers them anew.
/// Sensors, cameras, lights and keyframes are left out, since no motion depends on them.
class PartialScene {
 public:
  /// `whole` outlives this. `tool`: its body on the coupling; `begun`: the data with which it begins, for controls and
  /// mocap bodies.
  PartialScene(const mjModel& whole, int tool, const mjData& begun);

  [[nodiscard]] const MovingTrees& trees() const { return trees_; }
  /// The positions, velocities and so on of the whole scene.
  [[nodiscard]] EngineNumbers numbers() const;
  /// Takes such numbers, of the right sizes, and places all bodies.
  void place(const EngineNumbers& numbers);
  /// With all bodies where `place` has put them.
  [[nodiscard]] const mjData& placed() const { return *placed_; }

  /// Makes `model` move these trees from where `place` has put them, and gives `data` their state. `model` is a copy of
  /// the whole one, or what an earlier call made of it, and `data` is of such a copy.
  void set(Trees moving, mjModel& model, mjData& data);
  /// Takes the state of the trees that move from `data`.
  void take(const mjData& data);
  /// Of a body that moves, in the model that `set` made.
  [[nodiscard]] int body(int whole_body) const { return new_body_[static_cast<std::size_t>(whole_body)]; }

 private:
  using Rows = std::vector<int>;  // of the whole model, in the order of the other one
  /// One array of the model.
  struct Column {
    std::size_t offset;  // of its pointer in mjModel
    std::size_t bytes;   // of a row
    const Rows* rows;
  };

  void list_columns();
  void list_rows(Trees moving);
  void list_body(int body, int as);
  void number_bodies(mjModel& model, bool has_carrier) const;
  void number_joints(mjModel& model) const;
  void number_joins(mjModel& model, Trees moving) const;
  void place_still(mjModel& model, Trees moving) const;

  const mjModel* whole_;
  MovingTrees trees_;
  DataPointer placed_;
  std::vector<double> acceleration_, control_;
  Trees moving_ = 0;  // of the last `set`; 0: none
  std::vector<Column> columns_;
  Rows bodies_, joints_, dofs_, coordinates_, geoms_, sites_, actuators_, activations_;
  Rows new_body_, new_joint_, new_dof_, new_geom_, new_site_;  // by number in the whole model; -1: not there
};

}  // namespace tactor
