#include "nodes/dynamics/dynamics_node.hpp"

#include <algorithm>

#include "framework/core/check.hpp"
#include "framework/core/handle_between.hpp"
#include "framework/core/handle_gate.hpp"
#include "framework/core/value_error.hpp"
#include "nodes/physics/mechanics/energy.hpp"
#include "nodes/physics/mechanics/scene_model.hpp"

namespace tactor {

namespace {

SystemModel model_with(const InertialParams& params, SystemModel model) {
  model.iterations = params.iterations;
  model.stick_velocity = params.stick_velocity;
  model.integrator = params.integrator;
  return model;
}

}  // namespace

DynamicsNode::DynamicsNode(std::string type, const InertialParams& params, bool massless, const NodeContext& context)
    : type_(std::move(type)),
      params_(params),
      massless_(massless),
      solver_(model_with(params, scene_model(type_, *context.scene, context.notes))),
      substep_(params.substep) {
  if (params.substep_tolerance > 0 && params.min_substep > params.substep) {
    throw ValueError("min_substep", type_ + ": min_substep (" + std::to_string(params.min_substep) +
                                        " s) is above substep (" + std::to_string(params.substep) +
                                        " s); lower min_substep or raise substep");
  }
  refuse_deformable(*context.scene, type_ + " moves", "dynamics.deformable");
  for (const std::size_t i : context.scene->moving()) {
    bodies_.X_WB[static_cast<std::size_t>(bodies_.count++)] = context.scene->bodies[i].X_WB;
  }
}

void DynamicsNode::step(StepContext& context) {
  const Stamped<CouplingParameters>* message = coupling.latest();
  if (message == nullptr) return;
  CouplingParameters spring = message->value;
  if (spring.massless != 0 && !massless_) {
    throw RunError(type_ +
                   " needs a tool with mass, and the coupling has a massless tool; use dynamics.quasistatic, or a "
                   "coupling with a damper");
  }
  if (!begun_ && !params_.start_at_device && spring.k_t == 0 && spring.b_t > 0) {
    throw RunError(type_ +
                   ": start_at_device is false, and the coupling is a damper without a spring (a line of waves). It "
                   "never pulls the tool to the handle, so the scene would be felt in the wrong place; set "
                   "start_at_device: true, or use a coupling with a spring");
  }
  if (massless_) spring.massless = 1;
  bodies_.massless = spring.massless;
  const Stamped<ContactSet>* set = contacts.connected() ? contacts.latest() : nullptr;
  ContactPlanes planes;
  if (set != nullptr) planes = contact_planes(set->value);
  Time until = context.now();
  if (set != nullptr && params_.advance_to == DynamicsParams::AdvanceTo::contacts) {
    until = std::min(until, set->stamp.valid);
  }

  bool moved = false;
  Stamped<DeviceState> sample;
  while (handle_.next(device, until, sample)) {
    if (begun_) {
      // What has changed since the last sub-step is the contact set.
      if (!moved) observe(spring, planes, used_.value, 0);
      advance(sample, spring, planes);
    } else {
      begin(sample);
      // The query was made before the tool had its place.
      if (params_.start_at_device) planes = {};
      energy_ = system_energy(solver_.model(), spring, used_.value, planes, bodies_).total();
    }
    moved = true;
  }
  if (!moved) return;
  state.send(used_.stamp.valid, {.X_WT = bodies_.X_WB[0],
                                 .V_WT = bodies_.V_WB[0],
                                 .X_WD = used_.value.X_WD,
                                 .V_WD = used_.value.V_WD,
                                 .contact_T_W = last_.contact_T_W,
                                 .contacts = last_.touching,
                                 .damped = last_.outcome == StepOutcome::converged ? 0 : 1});
  bodies.send(used_.stamp.valid, bodies_);
  if (expected.wanted()) send_expected(spring, planes);
}

/// Where the bodies are by the newest sample of the handle, which moves steadily until there; where they are now, if
/// that sample is of no use. The bodies themselves stay where the contacts' time has them.
void DynamicsNode::send_expected(const CouplingParameters& spring, const ContactPlanes& planes) {
  constexpr double most_steps = 8;
  Stamped<DeviceState> newest = *device.latest();
  if (newest.stamp.valid <= used_.stamp.valid || !is_usable(newest.value)) newest = used_;
  newest.value.X_WD.R = normalized(newest.value.X_WD.R);
  BodyStates ahead = bodies_;
  const double interval = (newest.stamp.valid - used_.stamp.valid).seconds();
  if (interval > 0) {
    const double steps = std::clamp(std::ceil(interval / params_.substep), 1.0, most_steps);
    DeviceState from = used_.value;
    for (double k = 1; k <= steps; ++k) {
      const DeviceState to = handle_between(used_.value, newest.value, k / steps, rotates());
      solver_.advance(spring, from, to, planes, interval / steps, ahead);
      from = to;
    }
  }
  expected.send(newest.stamp.valid, ahead);
}

void DynamicsNode::begin(const Stamped<DeviceState>& sample) {
  begun_ = true;
  used_ = sample;
  if (!params_.start_at_device) return;
  bodies_.X_WB[0].p = sample.value.X_WD.p;
  if (rotates()) bodies_.X_WB[0].R = sample.value.X_WD.R;
}

void DynamicsNode::advance(const Stamped<DeviceState>& sample, const CouplingParameters& spring,
                           const ContactPlanes& planes) {
  const double interval = (sample.stamp.valid - used_.stamp.valid).seconds();
  const double tolerance = params_.substep_tolerance;
  DeviceState from = used_.value;
  double done = 0, error = 0;
  while (interval > 0 && done < 1) {
    // The small allowance keeps an interval of exactly n sub-steps at n.
    const double count = std::max(1.0, std::ceil((1 - done) * interval / substep_ - 1e-6));
    const double next = count == 1 ? 1 : done + (1 - done) / count;
    const double h = (next - done) * interval;
    const DeviceState to = handle_between(used_.value, sample.value, next, rotates());
    const BodyStates before = bodies_;
    const double estimate = sub_step(spring, planes, from, to, h);
    if (tolerance > 0) {
      if (estimate > tolerance && h > params_.min_substep * (1 + 1e-6)) {
        bodies_ = before;
        // The error goes with this power of the sub-step; a little less spares a second try.
        const double power = params_.integrator == Integrator::midpoint ? 3 : 2;
        const double share = 0.9 * std::pow(tolerance / estimate, 1 / power);
        substep_ = std::max(params_.min_substep, h * std::clamp(share, 0.1, 0.8));
        continue;
      }
      if (estimate < 0.25 * tolerance) substep_ = std::min(params_.substep, std::max(substep_, 1.5 * h));
    }
    last_ = tried_;
    ++counts_.steps;
    if (last_.outcome == StepOutcome::damped) ++counts_.damped;
    if (last_.outcome == StepOutcome::stopped) ++counts_.stopped;
    counts_.left_out += last_.left_out;
    error += estimate;
    observe(spring, planes, to, last_.work);
    from = to;
    done = next;
  }
  ++samples_;
  error_sum_ += error;
  error_max_ = std::max(error_max_, error);
  used_ = sample;
}

/// Takes one sub-step; returns the estimate of its error where one is asked for, else 0, m.
double DynamicsNode::sub_step(const CouplingParameters& spring, const ContactPlanes& planes, const DeviceState& from,
                              const DeviceState& to, double h) {
  const bool estimated = params_.error_estimate || params_.substep_tolerance > 0;
  if (!estimated) {
    tried_ = solver_.advance(spring, from, to, planes, h, bodies_);
    return 0;
  }
  BodyStates halves = bodies_;
  const DeviceState middle = handle_between(from, to, 0.5, rotates());
  solver_.advance(spring, from, middle, planes, h / 2, halves);
  solver_.advance(spring, middle, to, planes, h / 2, halves);
  tried_ = solver_.advance(spring, from, to, planes, h, bodies_);
  const double of_difference = params_.integrator == Integrator::midpoint ? 4.0 / 3 : 2;
  return of_difference * norm(bodies_.X_WB[0].p - halves.X_WB[0].p);
}

void DynamicsNode::observe(const CouplingParameters& spring, const ContactPlanes& planes, const DeviceState& handle,
                           double work) {
  const SystemModel& model = solver_.model();
  const Energy now = system_energy(model, spring, handle, planes, bodies_);
  observer_.observe(now.total() - energy_, work, now.kinetic + now.spring + now.contact);
  energy_ = now.total() - observer_.dissipate(params_.dissipate_above, now.kinetic, bodies_);
}

std::optional<double> DynamicsNode::position_error_max() const {
  const bool is_estimated = params_.error_estimate || params_.substep_tolerance > 0;
  return is_estimated ? std::optional(error_max_) : std::nullopt;
}

std::optional<double> DynamicsNode::position_error_mean() const {
  const double mean = samples_ > 0 ? error_sum_ / static_cast<double>(samples_) : 0.0;
  return position_error_max() ? std::optional(mean) : std::nullopt;
}

}  // namespace tactor
