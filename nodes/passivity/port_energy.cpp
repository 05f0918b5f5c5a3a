#include "nodes/passivity/port_energy.hpp"

#include <algorithm>
#include <cmath>

namespace tactor {

namespace {

double one_norm(const Vec3& a) {
  return std::abs(a.x) + std::abs(a.y) + std::abs(a.z);
}

bool is_finite_state(const DeviceState& s) {
  const Quat& R = s.X_WD.R;
  return is_finite(s.X_WD.p) && is_finite(s.V_WD.v) && is_finite(s.V_WD.w) && std::isfinite(R.w + R.x + R.y + R.z);
}

}  // namespace

Wrench PortEnergy::without_weight(const Wrench& wrench) const {
  const bool nothing = wrench.force == Vec3{} && wrench.torque == Vec3{};
  return nothing ? wrench : Wrench{wrench.force - options_.weight_W, wrench.torque};
}

double PortEnergy::most() const {
  const double turning = dot(held_.torque, held_.torque) / (options_.lever * options_.lever);
  return options_.kept + (dot(held_.force, held_.force) + turning) / (2 * options_.stiffness);
}

void PortEnergy::hold(const Wrench& wrench) {
  if (!is_finite(wrench)) return;
  const Wrench change = wrench - held_;
  energy_ -= 0.5 * options_.pessimism *
             (options_.step * one_norm(change.force) + options_.step_angle * one_norm(change.torque));
  held_ = wrench;
  if (!options_.torque) held_.torque = {};
  const Wrench counted = held();
  of_rounding_ =
      std::max(of_rounding_, options_.step * norm(counted.force) + options_.step_angle * norm(counted.torque));
}

void PortEnergy::take_state(const Stamped<DeviceState>& state) {
  if (!is_finite_state(state.value) || (started_ && state.stamp.valid <= at_)) return;
  const Pose& X = state.value.X_WD;
  if (started_) {
    SmallMotion way{X.p - X_WD_.p, {}};
    if (options_.torque) way.r = to_rotation_vector(X.R * inverse(X_WD_.R));
    const double dt = (state.stamp.valid - at_).seconds();
    energy_ += options_.damping * (dot(way.x, way.x) + options_.lever * options_.lever * dot(way.r, way.r)) / dt;
    const double given = work(held(), way);
    energy_ = std::min(energy_ - given, most());
    of_tick_ = std::max(of_tick_, std::abs(given));
    least_ = std::min(least_, energy_);
    mean_velocity_ = {(1 / dt) * way.x, (1 / dt) * way.r};
    mean_over_ = dt;
  }
  started_ = true;
  at_ = state.stamp.valid;
  X_WD_ = X;
  velocity_ = state.value.V_WD;
  if (!options_.torque) velocity_.w = {};
}

void PortEnergy::take(Input<DeviceState>& device, Input<Wrench>& commanded) {
  // A command of the time of a state is held from that state on.
  const auto hold_until = [&](const Time* end) {
    for (;;) {
      if (!has_next_) has_next_ = new_commands_.next(commanded, next_);
      if (!has_next_ || (end != nullptr && next_.stamp.valid >= *end)) return;
      hold(next_.value);
      has_next_ = false;
    }
  };
  Stamped<DeviceState> state;
  while (new_states_.next(device, state)) {
    hold_until(&state.stamp.valid);
    take_state(state);
  }
  hold_until(nullptr);
}

}  // namespace tactor
