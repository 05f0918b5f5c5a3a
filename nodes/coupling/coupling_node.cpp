#include "nodes/coupling/coupling_node.hpp"

#include "nodes/physics/mechanics/coupling_wrench.hpp"

namespace tactor {

double damping_of(double k, double m, double zeta) {
  return 2 * zeta * std::sqrt(k * m);
}

void CouplingNode::start(StepContext& context) {
  parameters.send(context.now(), parameters_);
}

void CouplingNode::step(StepContext&) {
  const Stamped<PhysicsState>* message = state.latest();
  if (message == nullptr) return;
  force.send(message->stamp.valid, coupling_wrench(parameters_, message->value, torque_));
}

}  // namespace tactor
