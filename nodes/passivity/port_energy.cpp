#include "nodes/passivity/port_energy.hpp"

#include <algorithm>
#include <cmath>

#include "nodes/passivity/on_its_way.hpp"

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

void PortEnergy::hold(const Wrench& wrench) {
  const Wrench change = wrench - held_;
  energy_ -= 0.5 * options_.pessimism *
             (options_.step * one_norm(change.force) + options_.step_angle * one_norm(change.torque));
  held_ = wrench;
  if (!options_.torque) held_.torque = {};
  const Wrench counted = held();
  of_rounding_ =
      std::max(of_rounding_, options_.step * norm(counted.force) + options_.step_angle * norm(counted.torque));
}

/// J, that the held wrench has given over the way of the last `dt` s.
double PortEnergy::given(const SmallMotion& way, double dt) const {
  constexpr double late = 2.5;  // ticks
  const double tick = options_.tick.seconds();
  if (tick == 0 || dt <= late * tick) return work(held(), way);
  const double acted = held_ticks * tick;
  const double farther = options_.acceleration * acted * 0.5 * (acted + mean_over_);
  const Wrench wrench = held();
  return work(wrench, {acted * mean_velocity_.v, acted * mean_velocity_.w}) +
         std::hypot(norm(wrench.force), norm(wrench.torque) / options_.lever) * farther;
}

void PortEnergy::take_state(const Stamped<DeviceState>& state) {
  if (started()) {
    const Pose& X = state.value.X_WD;
    const Pose& before = samples_.newest().value.X_WD;
    SmallMotion way{X.p - before.p, {}};
    if (options_.torque) way.r = to_rotation_vector(X.R * inverse(before.R));
    const double dt = (state.stamp.valid - at()).seconds();
    energy_ += options_.damping * (dot(way.x, way.x) + options_.lever * options_.lever * dot(way.r, way.r)) / dt;
    const double gave = given(way, dt);
    energy_ = std::min(energy_ - gave, most());
    of_tick_ = std::max(of_tick_, std::abs(gave));
    least_ = std::min(least_, energy_);
    mean_velocity_ = {(1 / dt) * way.x, (1 / dt) * way.r};
    mean_over_ = dt;
  }
  velocity_ = state.value.V_WD;
  if (!options_.torque) velocity_.w = {};
}

void PortEnergy::take(Input<DeviceState>& device, Input<Wrench>& commanded) {
  samples_.take(
      device, commanded, [this](const Wrench& wrench) { hold(wrench); },
      [this](const Stamped<DeviceState>& state) { take_state(state); });
}

}  // namespace tactor
