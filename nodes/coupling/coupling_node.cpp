#include "nodes/coupling/coupling_node.hpp"

#include <algorithm>
#include <cmath>

#include "nodes/physics/mechanics/coupling_wrench.hpp"
#include "nodes/physics/mesh/body_mesh.hpp"

namespace tactor {

namespace {

/// In which parameters that are set are reached. As long as a device takes to engage.
constexpr Duration change_time{100'000'000};

CouplingParameters between(const CouplingParameters& from, const CouplingParameters& to, double share) {
  const auto mixed = [share](double a, double b) { return a + share * (b - a); };
  return {.k_t = mixed(from.k_t, to.k_t),
          .b_t = mixed(from.b_t, to.b_t),
          .k_r = mixed(from.k_r, to.k_r),
          .b_r = mixed(from.b_r, to.b_r),
          .force_max = mixed(from.force_max, to.force_max),
          .torque_max = mixed(from.torque_max, to.torque_max),
          .massless = to.massless};
}

}  // namespace

double damping_of(double k, double m, double zeta) {
  return 2 * zeta * std::sqrt(k * m);
}

void CouplingNode::start(StepContext& context) {
  parameters.send(context.now(), parameters_);
}

CoupledTool coupled_tool(const char* type, const NodeContext& context) {
  const Body* tool = context.scene->tool();
  if (tool == nullptr) throw InputError(std::string(type) + " needs a moving body in the scene");
  return {tool->mass, context.torque ? body_inertia(*tool, context.notes).trace() / 3 : 0, context.torque};
}

void CouplingNode::go_to(const CouplingParameters& target) {
  from_ = parameters_;
  target_ = target;
  changing_ = true;
  changing_since_.reset();
}

void CouplingNode::go_on(Time now) {
  if (!changing_since_) changing_since_ = now;
  const Duration gone = now - *changing_since_;
  changing_ = gone < change_time;
  parameters_ = changing_ ? between(from_, target_, gone.seconds() / change_time.seconds()) : target_;
  parameters.send(now, parameters_);
}

void CouplingNode::step(StepContext& context) {
  if (changing_) go_on(context.now());
  const Stamped<PhysicsState>* message = state.latest();
  if (message == nullptr) return;
  force.send(message->stamp.valid, coupling_wrench(parameters_, message->value, torque_));
}

}  // namespace tactor
