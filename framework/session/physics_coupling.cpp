#include "framework/session/physics_coupling.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <string>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

/// With four digits.
std::string rounded_text(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 4).ptr;
  return {text.data(), end};
}

void check_positive(const std::string& name, const std::string& unit, double value) {
  if (std::isfinite(value) && value > 0) return;
  throw InputError(name + ": expected a number above 0 " + unit + ", found " + rounded_text(value));
}

/// The longest step of a force that is held over it: where h^2 k + 2 h b = 4 m.
double longest_step(double k, double b, double m) {
  return k > 0 ? (std::sqrt(b * b + 4 * k * m) - b) / k : 2 * m / b;
}

/// `m`: of translation the mass, of rotation the inertia; `name` is its letter.
void check_stable(const std::string& motion, const std::string& name, double k, double b, double m, double h) {
  const double bound = (h * h * k + 2 * h * b) / m;
  if (bound < 4) return;
  throw InputError(
      "wrench: the coupling's " + motion + " is too stiff for an explicit force: h^2 k/" + name + " + 2 h b/" + name +
      " is " + rounded_text(bound) + " and must be below 4, with k = " + rounded_text(k) + ", b = " + rounded_text(b) +
      ", " + name + " = " + rounded_text(m) + " and h = " + rounded_text(h) + " s. Take steps shorter than " +
      rounded_text(longest_step(k, b, m)) + " s, or give the engine the spring itself (implicit_spring, erp_cfm)");
}

double erp(double k, double b, double h) {
  return k > 0 ? h * k / (h * k + b) : 0;
}

/// On the tool, without limits.
Wrench spring_and_damper(const CouplingParameters& coupling, const DeviceState& handle, const Pose& X_WT,
                         const Twist& V_WT, bool turns) {
  Wrench wrench{coupling.k_t * (handle.X_WD.p - X_WT.p) + coupling.b_t * (handle.V_WD.v - V_WT.v), {}};
  if (turns) {
    wrench.torque =
        coupling.k_r * to_rotation_vector(handle.X_WD.R * inverse(X_WT.R)) + coupling.b_r * (handle.V_WD.w - V_WT.w);
  }
  return wrench;
}

double cfm(double k, double b, double h) {
  const double sum = h * k + b;
  return sum > 0 ? 1 / sum : std::numeric_limits<double>::infinity();
}

}  // namespace

ImplicitSpring implicit_spring(const CouplingParameters& coupling, double h) {
  if (!std::isfinite(h) || h < 0) throw InputError("h: expected a step of 0 s or more, found " + rounded_text(h));
  return {coupling.k_t, coupling.b_t + h * coupling.k_t, coupling.k_r, coupling.b_r + h * coupling.k_r};
}

ErpCfm erp_cfm(const CouplingParameters& coupling, double h) {
  check_positive("h", "s", h);
  return {erp(coupling.k_t, coupling.b_t, h), cfm(coupling.k_t, coupling.b_t, h), erp(coupling.k_r, coupling.b_r, h),
          cfm(coupling.k_r, coupling.b_r, h)};
}

Wrench explicit_wrench(const CouplingParameters& coupling, const DeviceState& handle, const ExplicitTool& tool,
                       double h) {
  check_positive("h", "s", h);
  check_positive("mass", "kg", tool.mass);
  check_stable("translation", "m", coupling.k_t, coupling.b_t, tool.mass, h);
  const bool turns = tool.inertia != 0;
  if (turns) {
    check_positive("inertia", "kg m^2", tool.inertia);
    check_stable("rotation", "I", coupling.k_r, coupling.b_r, tool.inertia, h);
  }
  const Wrench wrench = spring_and_damper(coupling, handle, tool.X_WT, tool.V_WT, turns);
  if (!is_finite(wrench)) {
    throw InputError("wrench: the tool's pose and velocity are not finite; the program's physics has lost it");
  }
  return wrench;
}

Wrench wrench_on_device(const CouplingParameters& coupling, const DeviceState& handle, const Pose& X_WT,
                        const Twist& V_WT, bool turns) {
  const Wrench on_tool = spring_and_damper(coupling, handle, X_WT, V_WT, turns);
  return {limited(-on_tool.force, coupling.force_max), limited(-on_tool.torque, coupling.torque_max)};
}

}  // namespace tactor
