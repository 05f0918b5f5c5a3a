#include "nodes/coupling/law.hpp"

#include "nodes/physics/mechanics/coupling_wrench.hpp"

namespace tactor {

double damping_of(double k, double m, double zeta) {
  return 2 * zeta * std::sqrt(k * m);
}

void CouplingNode::start(StepContext& context) {
  law.send(context.now(), law_);
}

void CouplingNode::step(StepContext&) {
  const Stamped<PhysicsState>* message = state.latest();
  if (message == nullptr) return;
  force.send(message->stamp.valid, coupling_wrench(law_, message->value, torque_));
}

}  // namespace tactor
