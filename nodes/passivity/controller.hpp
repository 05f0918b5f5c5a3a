// A passivity controller: a damper that acts where the port is about to give more energy than the hand has given.
#pragma once

#include "nodes/passivity/stage.hpp"

namespace tactor {

/// passivity.controller: an observer (see PortEnergy) and a damper in series with the wrench that is wanted.
class PassivityController final : public PassivityStage {
 public:
  struct Params : StageParams {
    double mass = 0;           ///< kg, of the handle
    double inertia = 0;        ///< kg m^2, of the handle
    double damping_share = 0;  ///< of mass / tick
  };
  PassivityController(const Params& params, const NodeContext& context);
  static NodeInfo declare();

 private:
  [[nodiscard]] Wrench limit(const Wrench& wanted) const noexcept override;

  double damper_most_;   // N/m: of the damper's force for the way of a tick
  double turning_most_;  // N m/rad, likewise
};

}  // namespace tactor
