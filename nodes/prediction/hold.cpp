#include "nodes/prediction/hold.hpp"

namespace tactor {

NodeInfo HoldPredictor::declare() {
  Declare<HoldPredictor> node("prediction.hold", "Expects that the force stays as it is.");
  node.details(
      "F_{t+1|t} = F_t for force and torque. The baseline: what a device does that repeats the last physics force. A "
      "sample that is not finite is replaced by the last good one.");
  return declare_predictor(node).info();
}

}  // namespace tactor
