#include "nodes/physics/mechanics/rigid_step.hpp"

#include <algorithm>
#include <cmath>

#include "framework/core/check.hpp"
#include "nodes/physics/mechanics/energy.hpp"
#include "nodes/physics/mechanics/handle.hpp"

namespace tactor {

namespace {

constexpr double most_turn = 0.3;  // rad, in one step
constexpr int most_halvings = 6;

bool finite(const BodyStates& bodies, int count) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const Pose& X = bodies.X_WB[i];
    const Twist& V = bodies.V_WB[i];
    if (!is_finite(X.p) || !is_finite(V.v) || !is_finite(V.w) || !is_finite(Vec3{X.R.x, X.R.y, X.R.z}) ||
        !std::isfinite(X.R.w)) {
      return false;
    }
  }
  return true;
}

}  // namespace

StepResult RigidStep::advance(const CouplingParameters& coupling, const DeviceState& before, const DeviceState& device,
                              const ContactPlanes& contacts, double h, BodyStates& bodies) {
  return advance(coupling, before, device, contacts, h, most_halvings, bodies);
}

StepResult RigidStep::advance(const CouplingParameters& coupling, const DeviceState& before, const DeviceState& device,
                              const ContactPlanes& contacts, double h, int halvings, BodyStates& bodies) {
  const BodyStates start = bodies;
  const StepResult whole = advance_once(coupling, before, device, contacts, h, bodies);
  if (whole.turn <= most_turn || halvings == 0) return whole;
  bodies = start;
  const DeviceState middle = handle_between(before, device, 0.5, model_.body[0].rotates);
  const StepResult first = advance(coupling, before, middle, contacts, h / 2, halvings - 1, bodies);
  StepResult second = advance(coupling, middle, device, contacts, h / 2, halvings - 1, bodies);
  second.outcome = std::max(first.outcome, second.outcome);
  second.touching = std::max(first.touching, second.touching);
  second.left_out = std::max(first.left_out, second.left_out);
  second.work += first.work;
  second.contact_T_W = 0.5 * (first.contact_T_W + second.contact_T_W);
  second.iterations += first.iterations;
  second.turn += first.turn;
  return second;
}

StepResult RigidStep::advance_once(const CouplingParameters& coupling, const DeviceState& before,
                                   const DeviceState& device, const ContactPlanes& contacts, double h,
                                   BodyStates& bodies) {
  TACTOR_ASSERT(contacts.planes.size() <= planes_.size() && contacts.pairs.size() == contacts.planes.size());
  const BodyStates start = bodies;
  StepResult result;
  if (model_.count > 1) {
    result = solve<Eigen::Dynamic>(coupling, device, contacts, h, bodies);
  } else {
    result = model_.body[0].rotates ? solve<6>(coupling, device, contacts, h, bodies)
                                    : solve<3>(coupling, device, contacts, h, bodies);
  }
  bool stop = result.outcome == StepOutcome::stopped || !finite(bodies, model_.count) || !is_finite(result.contact_T_W);
  if (!stop && result.outcome == StepOutcome::damped) {
    const double had = system_energy(model_, coupling, before, contacts, start).total() +
                       handle_work(model_, coupling, before, device, bodies);
    // A comparison with NaN is false.
    stop = !(system_energy(model_, coupling, device, contacts, bodies).total() <= had);
  }
  if (stop) {
    bodies = start;
    for (Twist& V : bodies.V_WB) V = {};
    result = {.outcome = StepOutcome::stopped, .left_out = result.left_out, .iterations = result.iterations};
  }
  result.work = handle_work(model_, coupling, before, device, bodies);
  return result;
}

}  // namespace tactor
