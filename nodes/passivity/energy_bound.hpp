// A bound on the wrench by the energy that is there, whatever the handle does within a tick.
#pragma once

#include "nodes/passivity/stage.hpp"

namespace tactor {

/// passivity.energy_bound: scales the wrench down so that the energy of the next tick cannot exceed what is there.
class EnergyBound final : public PassivityStage {
 public:
  struct Params : StageParams {
    double device_damping = 0;  ///< N s/m
    double bound_share = 0;     ///< of the strict bound
  };
  EnergyBound(const Params& params, const NodeContext& context);
  static NodeInfo declare();

 private:
  [[nodiscard]] Wrench limit(const Wrench& wanted) const noexcept override;

  double bound_share_;
};

}  // namespace tactor
