#include "nodes/prediction/hold.hpp"

namespace tactor {

NodeInfo HoldPredictor::declare() {
  Declare<HoldPredictor> node("prediction.hold", "Predicts that the force stays as it is.");
  node.details(
      "F_{t+1|t} = F_t for force and torque. It is the baseline: a device that repeats the last physics force. A "
      "sample that is not finite is replaced by the last good one.");
  return declare_predictor(node).info();
}

}  // namespace tactor
