#include "nodes/physics/mechanics/rigid_step.hpp"

#include <algorithm>
#include <cmath>

#include "framework/core/check.hpp"
#include "framework/core/handle_between.hpp"
#include "nodes/physics/mechanics/energy.hpp"

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

/// The tool in the middle of a step.
BodyStates halfway(const BodyStates& start, const BodyStates& end) {
  BodyStates middle = start;
  const Pose &X0 = start.X_WB[0], &X1 = end.X_WB[0];
  const Twist &V0 = start.V_WB[0], &V1 = end.V_WB[0];
  middle.X_WB[0] = {0.5 * (X0.p + X1.p), from_rotation_vector(0.5 * to_rotation_vector(X1.R * inverse(X0.R))) * X0.R};
  middle.V_WB[0] = {0.5 * (V0.v + V1.v), 0.5 * (V0.w + V1.w)};
  return middle;
}

}  // namespace

RigidStep::RigidStep(const SystemModel& model, int patch_nodes) : model_(model) {
  TACTOR_DEMAND(patch_nodes <= most_patch_nodes);
  const auto dofs = static_cast<std::size_t>(6 * model.count + 3 * patch_nodes);
  if (patch_nodes > 0) matrix_.resize(dofs * dofs);
}

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

template <Integrator integrator>
StepResult RigidStep::solve_by(const CouplingParameters& coupling, const DeviceState& device,
                               const ContactPlanes& contacts, double h, BodyStates& bodies) {
  if (model_.count > 1) return solve<Eigen::Dynamic, integrator>(coupling, device, contacts, h, bodies);
  if (model_.body[0].rotates) return solve<6, integrator>(coupling, device, contacts, h, bodies);
  return solve<3, integrator>(coupling, device, contacts, h, bodies);
}

StepResult RigidStep::advance_once(const CouplingParameters& coupling, const DeviceState& before,
                                   const DeviceState& device, const ContactPlanes& contacts, double h,
                                   BodyStates& bodies) {
  TACTOR_ASSERT(contacts.planes.size() <= planes_.size() && contacts.pairs.size() == contacts.planes.size());
  const BodyStates start = bodies;
  if (model_.integrator == Integrator::midpoint && coupling.massless == 0) {
    const DeviceState middle = handle_between(before, device, 0.5, model_.body[0].rotates);
    StepResult result = solve_by<Integrator::midpoint>(coupling, middle, contacts, h / 2, bodies);
    if (result.outcome == StepOutcome::converged && finite(bodies, model_.count) && is_finite(result.contact_T_W)) {
      // The mean force over the half way, twice.
      result.work = 2 * handle_work(model_, coupling, before, middle, halfway(start, bodies));
      return result;
    }
    bodies = start;
  }
  StepResult result = solve_by<Integrator::implicit_euler>(coupling, device, contacts, h, bodies);
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

/// The forces of a plane at that distance, in a step that is solved over h seconds.
void RigidStep::set_law(Plane& p, const Contact& c, double distance, bool massless, double h) {
  const double k = c.stiffness * c.weight;
  p.push = -k * distance;
  p.spring = h * k;
  p.damping = massless ? 0 : c.damping * c.weight;
  p.friction = c.friction;
  p.bound = p.inertia = p.creep = p.lift = p.carried = 0;
  p.coned = false;
  p.lifted = p.lifted_before = p.told_before = p.lifted_below = 0;
  if (c.creep > 0 && c.weight > 0) p.creep = c.creep / c.weight;
  if (massless) return;
  if (distance < 0) {
    p.lift = c.lift * c.friction * p.damping;
    p.inertia = c.inertia * c.weight / h;
    p.damping += p.inertia;
  } else if (c.inertia > 0) {
    p.damping = 0;
  }
}

/// The usable planes as the step over h seconds sees them. `ahead`: where the bodies are at the middle of the step that
/// the levers are for; null: where they are.
std::span<RigidStep::Plane> RigidStep::prepare_planes(const BodyStates& bodies, const BodyStates* ahead, bool massless,
                                                      const ContactPlanes& contacts, double h, const SoftPatch* patch) {
  const BodyStates& at = ahead != nullptr ? *ahead : bodies;
  std::size_t count = 0;
  for (std::size_t i = 0; i < contacts.planes.size(); ++i) {
    if (!usable(contacts, i, model_.count)) continue;
    const Contact& c = contacts.planes[i];
    const PlaneNow now = plane_now(contacts, i, at.X_WB);
    const double distance = ahead == nullptr ? now.distance : plane_now(contacts, i, bodies.X_WB).distance;
    Plane& p = planes_[count++];
    p.body = contacts.pairs[i].body;
    p.other = contacts.pairs[i].other;
    p.r_body = now.p_W - at.X_WB[static_cast<std::size_t>(p.body)].p;
    if (p.other >= 0) p.r_other = now.p_W - at.X_WB[static_cast<std::size_t>(p.other)].p;
    p.n = now.n_W;
    set_law(p, c, distance, massless, h);
  }
  if (patch != nullptr) count = add_soft_planes(at, bodies, massless, *patch, h, count);
  return std::span(planes_).first(count);
}

/// Adds the usable contacts with the patch, with levers for the bodies at `at`; returns how many planes there are then.
std::size_t RigidStep::add_soft_planes(const BodyStates& at, const BodyStates& bodies, bool massless,
                                       const SoftPatch& patch, double h, std::size_t count) {
  for (const SoftContact& soft : patch.contacts) {
    const Contact& c = soft.contact;
    if (soft.body >= model_.count || count == planes_.size() || !is_finite(c.p_TC) || !is_finite(c.n_W) ||
        !std::isfinite(c.distance)) {
      continue;
    }
    Plane& p = planes_[count++];
    p.body = std::max(soft.body, ContactPair::fixed);
    p.other = Plane::on_patch;
    p.node = soft.node;
    p.share = soft.share;
    p.n = c.n_W;
    p.r_body = {};
    // From where the contact was found to the start of the step.
    Vec3 moved;
    if (p.body >= 0) {
      const auto body = static_cast<std::size_t>(p.body);
      p.r_body = transform(at.X_WB[body], c.p_TC) - at.X_WB[body].p;
      moved = transform(bodies.X_WB[body], c.p_TC) - transform(patch.query_X_WB[body], c.p_TC);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      if (soft.node[i] < 0) continue;
      const auto node = static_cast<std::size_t>(soft.node[i]);
      moved -= soft.share[i] * (patch.p_W[node] - patch.query_p_W[node]);
    }
    set_law(p, c, c.distance + dot(c.n_W, moved), massless, h);
  }
  return count;
}

StepResult RigidStep::advance(const SoftPatch& patch, const CouplingParameters& coupling, const DeviceState& before,
                              const DeviceState& device, const ContactPlanes& contacts, double h, BodyStates& bodies,
                              SoftPatchMotion motion) {
  TACTOR_ASSERT(patch.p_W.size() <= most_patch_nodes && contacts.planes.size() <= ContactSet::capacity);
  const BodyStates start = bodies;
  StepResult result;
  if (model_.integrator == Integrator::midpoint && coupling.massless == 0) {
    const DeviceState middle = handle_between(before, device, 0.5, model_.body[0].rotates);
    result = solve<Eigen::Dynamic, Integrator::midpoint, most_patch_nodes>(coupling, middle, contacts, h / 2, bodies,
                                                                           &patch, &motion);
    result.work = 2 * handle_work(model_, coupling, before, middle, halfway(start, bodies));
  } else {
    result = solve<Eigen::Dynamic, Integrator::implicit_euler, most_patch_nodes>(coupling, device, contacts, h, bodies,
                                                                                 &patch, &motion);
    result.work = handle_work(model_, coupling, before, device, bodies);
  }
  if (result.outcome == StepOutcome::converged && finite(bodies, model_.count) && is_finite(result.contact_T_W) &&
      motion.velocity.allFinite() && motion.force.allFinite()) {
    return result;
  }
  bodies = start;
  for (Twist& V : bodies.V_WB) V = {};
  motion.velocity.setZero();
  motion.force.setZero();
  result = {.outcome = StepOutcome::stopped, .left_out = result.left_out, .iterations = result.iterations};
  result.work = handle_work(model_, coupling, before, device, bodies);
  return result;
}

}  // namespace tactor
