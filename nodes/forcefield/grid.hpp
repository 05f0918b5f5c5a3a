// forcefield.grid: forces stored where they were felt, displayed where the device is.
#pragma once

#include "framework/node/new_messages.hpp"
#include "nodes/forcefield/force_grid.hpp"
#include "nodes/prediction/device_track.hpp"

namespace tactor {

/// Stores each physics force at the position the device had at the force's stamp, and at its own rate displays what the
/// grid has at the device's newest position (force_grid.hpp has the equations); where nothing is known, the newest
/// physics force. After F. Mazzella, K. Montgomery, J.-C. Latombe, "The Forcegrid: A Buffer Structure for Haptic
/// Interaction with Virtual Elastic Objects", 2002; the update and the extrapolation are this project's own. For
/// fixed scenes and tools that keep their orientation. Forces in N, positions in m, both in W. A segment is stamped
/// valid as the newest force that was stored, so that a physics which has died is seen.
/// Throws InputError as check_static_scene does, and where `reach` is more than three cells.
class GridForceField final : public Node {
 public:
  struct Params {
    double cell = 0, reach = 0;  ///< m
    double forgetting = 0;
    std::int64_t nodes = 0;
    double force_max = 0;  ///< N
    double rate = 0;       ///< Hz
  };
  GridForceField(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;

  Input<DeviceState> device;
  Input<Wrench> force;
  Output<ForceSegment> segment;

 private:
  void take(const Stamped<Wrench>& sample);

  double force_max_;  // N
  ForceGrid grid_;
  DeviceTrack track_;
  NewMessages<Wrench> samples_;
  Stamped<Wrench> newest_;
  bool any_ = false;
  std::int64_t rejected_ = 0;
  std::int64_t stored_ticks_ = 0, extrapolated_ticks_ = 0, held_ticks_ = 0;
};

}  // namespace tactor
