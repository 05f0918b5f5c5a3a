#include "nodes/forcefield/grid.hpp"

#include "framework/core/segment.hpp"
#include "framework/core/value_error.hpp"
#include "nodes/forcefield/supported_scene.hpp"
#include "nodes/prediction/sample_gate.hpp"

namespace tactor {

namespace {

constexpr const char* grid_type = "forcefield.grid";

ForceGrid::Options checked(const GridForceField::Params& params, const NodeContext& context) {
  check_static_scene(grid_type, *context.scene);
  if (params.reach > ForceGrid::most_reach_cells * params.cell * (1 + 1e-9)) {
    throw ValueError("reach", std::string(grid_type) + ": reach (" + std::to_string(params.reach) +
                                  " m) is more than " + std::to_string(ForceGrid::most_reach_cells) + " cells of " +
                                  std::to_string(params.cell) + " m; lower reach or raise cell");
  }
  return {.cell = params.cell, .reach = params.reach, .forgetting = params.forgetting, .nodes = params.nodes};
}

}  // namespace

NodeInfo GridForceField::declare() {
  Declare<GridForceField> d(grid_type,
                            "Stores forces on a grid where they were felt, and interpolates at the device's position.");
  d.details(
      "Each physics force is stored at the position that the device had at the force's stamp. The field is F(p) = sum "
      "w_i F_i, trilinear between grid nodes. A sample corrects the corners of its cell by F_i += forgetting min(1, "
      "w_i / sum w_j^2) (F - F_i). At its own rate the node displays F at the device's newest position. Nodes that "
      "were never stored are extrapolated from stored ones within `reach`, weighted by 1 / distance^2. If there are "
      "none, the newest physics force is held. The grid's storage is fixed: when a set of 8 nodes is full, the one "
      "stored longest ago is forgotten and counted. It is a baseline for translation-only tools in fixed scenes in "
      "which a place is visited again. Forces that depend on speed or path (damping, friction) are displayed as they "
      "last were.\nAfter Mazzella, Montgomery, Latombe, The Forcegrid: A Buffer Structure for Haptic Interaction with "
      "Virtual Elastic Objects (2002). The update is this project's own; the extrapolation is Shepard's (1968).");
  declare_device_track(d);
  d.realtime_safe()
      .input("force", &GridForceField::force,
             {.doc = "the physics force on the device", .queue = {QueuePolicy::drop_oldest, 64}})
      .output("segment", &GridForceField::segment, "the force at the device's position, held for a tick")
      .real("cell", &Params::cell,
            {.doc = "distance between grid nodes", .unit = "m", .default_value = 0.002, .min = 1e-6, .max = 0.1})
      .real("reach", &Params::reach,
            {.doc = "largest distance from a stored node at which others are extrapolated; three cells at most",
             .unit = "m",
             .default_value = 0.004,
             .min = 0,
             .max = 0.3})
      .real("forgetting", &Params::forgetting,
            {.doc = "share of a node's old force that is forgotten when a new force is felt at it",
             .default_value = 1,
             .min = 0,
             .max = 1,
             .above_min = true})
      .integer(
          "nodes", &Params::nodes,
          {.doc = "number of grid nodes that there is room for, at 40 bytes each; rounded up to 8 times a power of two",
           .default_value = 65536,
           .min = 8,
           .max = std::int64_t{1} << 24})
      .real("force_max", &Params::force_max,
            {.doc = "the device's largest force; longer stored and displayed forces are shortened to it",
             .unit = "N",
             .default_value = 8,
             .min = 0,
             .above_min = true})
      .haptic_rate(&Params::rate, {.doc = "ticks per second"})
      .role(Role::force_field)
      .metric("forcefield.nodes_stored", "1", "grid nodes that were stored", Better::neither,
              [](const GridForceField& self) { return self.grid_.stored(); })
      .metric("forcefield.nodes_evicted", "1", "grid nodes that had to make room for others", Better::lower,
              [](const GridForceField& self) { return self.grid_.evicted(); })
      .metric("forcefield.memory_bytes", "byte", "memory of the grid", Better::lower,
              [](const GridForceField& self) { return self.grid_.memory_bytes(); })
      .metric("forcefield.stored_ticks", "1", "ticks at which all nodes around the device were stored", Better::higher,
              &GridForceField::stored_ticks_)
      .metric("forcefield.extrapolated_ticks", "1", "ticks at which some nodes around the device were extrapolated",
              Better::lower, &GridForceField::extrapolated_ticks_)
      .metric("forcefield.held_ticks", "1", "ticks that held the newest physics force", Better::lower,
              &GridForceField::held_ticks_)
      .metric("forcefield.rejected_samples", "1", "forces that could not be stored", Better::lower,
              &GridForceField::rejected_);
  return d.info();
}

GridForceField::GridForceField(const Params& params, const NodeContext& context)
    : force_max_(params.force_max), grid_(checked(params, context)) {}

void GridForceField::take(const Stamped<Wrench>& sample) {
  Pose X_WD;
  const Vec3& felt = sample.value.force;
  if (!is_usable(felt) || !track_.at(sample.stamp.valid, X_WD) || !grid_.store(X_WD.p, limited(felt, force_max_))) {
    ++rejected_;
    return;
  }
  if (!any_ || sample.stamp.valid > newest_.stamp.valid) newest_ = sample;
  any_ = true;
}

void GridForceField::step(StepContext& context) {
  track_.read(device);
  Stamped<Wrench> sample;
  while (samples_.next(force, sample)) take(sample);
  Pose X_WD;
  if (!any_ || !track_.at(context.now(), X_WD)) return;
  const ForceGrid::Look look = grid_.look(X_WD.p, newest_.value.force);
  switch (look.known) {
    case ForceGrid::Known::stored:
      ++stored_ticks_;
      break;
    case ForceGrid::Known::extrapolated:
      ++extrapolated_ticks_;
      break;
    case ForceGrid::Known::nothing:
      ++held_ticks_;
      break;
  }
  segment.send(newest_.stamp.valid, constant_segment(context.now(), {limited(look.force, force_max_), {}}));
}

}  // namespace tactor
