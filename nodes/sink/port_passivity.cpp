#include "nodes/sink/port_passivity.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactor {

std::optional<PortPassivity> port_passivity(const RunSignals& signals, double step, double step_angle) {
  if (signals.handle.size() < 2) return std::nullopt;
  const Vec3 weight_W = signals.mass * signals.gravity_W;
  PortPassivity found;
  double net = 0, force = 0, torque = 0, tick = 0;
  std::size_t next = 0;
  Wrench held;
  for (std::size_t i = 0; i + 1 < signals.handle.size(); ++i) {
    const HandleSample& from = signals.handle[i];
    const HandleSample& to = signals.handle[i + 1];
    for (; next < signals.commanded.size() && signals.commanded[next].stamp.valid <= from.valid; ++next) {
      held = signals.commanded[next].value;
    }
    const Vec3 way = to.X_WD.p - from.X_WD.p;
    double given = dot(held.force, way);
    if (signals.torque) given += dot(held.torque, to_rotation_vector(to.X_WD.R * inverse(from.X_WD.R)));
    if (!std::isfinite(given)) {
      constexpr double nan = std::numeric_limits<double>::quiet_NaN();
      return PortPassivity{nan, nan};
    }
    const bool nothing = held.force == Vec3{} && held.torque == Vec3{};
    net += nothing ? 0.0 : given - dot(weight_W, way);
    found.generated_J = std::max(found.generated_J, net);
    tick = std::max(tick, std::abs(given));
    force = std::max(force, norm(held.force));
    torque = std::max(torque, signals.torque ? norm(held.torque) : 0.0);
  }
  found.allowed_J = force * step + torque * step_angle + tick;
  return found;
}

}  // namespace tactor
