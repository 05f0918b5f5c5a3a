// coupling.static: a spring alone, with a massless tool in balance.
#pragma once

#include "framework/node/info.hpp"
#include "nodes/coupling/coupling_node.hpp"

namespace tactor {

/// The spring k_t (N/m), k_r (N m/rad) without damper; the tool has no inertia and no weight and rests where spring and
/// contacts balance.
class StaticCoupling final : public CouplingNode {
 public:
  struct Params : CouplingLimits {
    double k_t = 0;
    double k_r = 0;
  };
  StaticCoupling(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void tune(const Params& params);

 private:
  bool torque_;
};

}  // namespace tactor
