#include "nodes/passivity/port_energy.hpp"

#include <algorithm>
#include <cmath>

namespace tactor {

namespace {

double one_norm(const Vec3& a) {
  return std::abs(a.x) + std::abs(a.y) + std::abs(a.z);
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

void PortEnergy::hold(const Stamped<Wrench>& wrench) {
  const Wrench change = wrench.value - held_;
  energy_ -= 0.5 * options_.pessimism *
             (options_.step * one_norm(change.force) + options_.step_angle * one_norm(change.torque));
  held_ = wrench.value;
  if (!options_.torque) held_.torque = {};
  const Wrench counted = held();
  acting_.hold(wrench.stamp.valid, counted);
  of_rounding_ =
      std::max(of_rounding_, options_.step * norm(counted.force) + options_.step_angle * norm(counted.torque));
}

void PortEnergy::take_state(const Stamped<DeviceState>& state) {
  if (started()) {
    const Pose& X = state.value.X_WD;
    const Pose& before = samples_.newest().value.X_WD;
    SmallMotion way{X.p - before.p, {}};
    if (options_.torque) way.r = to_rotation_vector(X.R * inverse(before.R));
    const double dt = (state.stamp.valid - at()).seconds();
    energy_ += options_.damping * (dot(way.x, way.x) + options_.lever * options_.lever * dot(way.r, way.r)) / dt;
    const ActingWrench::Leg leg = acting_.leg(at(), state.stamp.valid);
    const double given = work(leg.mean, way);
    energy_ -= options_.acceleration * (leg.uneven_force + leg.uneven_torque / options_.lever);
    energy_ = std::min(energy_ - given, most());
    of_tick_ = std::max(of_tick_, std::abs(given));
    least_ = std::min(least_, energy_);
    mean_velocity_ = {(1 / dt) * way.x, (1 / dt) * way.r};
    mean_over_ = dt;
  }
  velocity_ = state.value.V_WD;
  if (!options_.torque) velocity_.w = {};
}

void PortEnergy::take(Input<DeviceState>& device, Input<Wrench>& commanded) {
  samples_.take(
      device, commanded, [this](const Stamped<Wrench>& wrench) { hold(wrench); },
      [this](const Stamped<DeviceState>& state) { take_state(state); });
}

}  // namespace tactor
