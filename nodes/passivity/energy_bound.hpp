// A bound on the wrench by the energy that is there, whatever the handle does within a tick.
#pragma once

#include <string>

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
  /// As every stage, and a remark where the run was later than the bound foresees.
  void report(Report& report) const override;

 private:
  [[nodiscard]] Wrench limit(const Wrench& wanted) const noexcept override;

  /// What is foreseen live: in one loop with the device a missed tick, in a loop of its own one of each.
  static constexpr int ahead_foreseen = 3, held_foreseen = 2;

  std::string name_;
  const bool in_loop_;
  double bound_share_;
};

}  // namespace tactor
