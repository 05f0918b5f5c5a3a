#include "nodes/coupling/adaptive.hpp"

#include <algorithm>

#include "framework/core/value_error.hpp"
#include "nodes/coupling/declare_coupling.hpp"

namespace tactor {

namespace {

void check_bounds(const char* low_name, double low, const char* high_name, double high) {
  if (low > high) {
    throw ValueError(low_name, std::string("coupling.adaptive: ") + low_name + " (" + std::to_string(low) +
                                   ") is above " + high_name + " (" + std::to_string(high) + "); lower " + low_name +
                                   " or raise " + high_name);
  }
}

CouplingParameters parameters_for(const AdaptiveCoupling::Params& p, const CoupledTool& tool) {
  check_bounds("k_min", p.k_min, "k_device", p.k_device);
  check_bounds("k_r_min", p.k_r_min, "k_r_device", p.k_r_device);
  CouplingParameters parameters{.force_max = p.force_max, .torque_max = p.torque_max};
  parameters.k_t = std::clamp(p.k_0 * std::pow(tool.mass / p.m_0, p.a), p.k_min, p.k_device);
  parameters.b_t = damping_of(parameters.k_t, tool.mass, p.zeta);
  if (tool.torque) {
    parameters.k_r = std::clamp(p.k_r0 * std::pow(tool.inertia / p.I_0, p.a), p.k_r_min, p.k_r_device);
    parameters.b_r = damping_of(parameters.k_r, tool.inertia, p.zeta);
  }
  return parameters;
}

/// Tells where a limit takes the place of what `k_0` or `k_r0` asks for.
void note_limits(const AdaptiveCoupling::Params& p, const CoupledTool& tool, const NodeContext& context) {
  const auto note = [&](const char* name, const char* unit, double asked, const char* low_name, double low,
                        const char* high_name, double high) {
    if (asked >= low && asked <= high) return;
    const bool above = asked > high;
    const char* by = above ? high_name : low_name;
    context.note_limit(name, by,
                       "node " + context.name + ": " + name + " asks for " + std::to_string(asked) + " " + unit +
                           " at the tool's mass, and " + by + " holds it at " + std::to_string(above ? high : low));
  };
  note("k_0", "N/m", p.k_0 * std::pow(tool.mass / p.m_0, p.a), "k_min", p.k_min, "k_device", p.k_device);
  if (!tool.torque) return;
  note("k_r0", "N m/rad", p.k_r0 * std::pow(tool.inertia / p.I_0, p.a), "k_r_min", p.k_r_min, "k_r_device",
       p.k_r_device);
}

}  // namespace

AdaptiveCoupling::AdaptiveCoupling(const Params& params, const NodeContext& context)
    : AdaptiveCoupling(params, coupled_tool("coupling.adaptive", context)) {
  note_limits(params, tool_, context);
}

AdaptiveCoupling::AdaptiveCoupling(const Params& params, const CoupledTool& tool)
    : CouplingNode(parameters_for(params, tool), tool.torque), tool_(tool) {}

void AdaptiveCoupling::tune(const Params& params) {
  go_to(parameters_for(params, tool_));
}

NodeInfo AdaptiveCoupling::declare() {
  Declare<AdaptiveCoupling> d("coupling.adaptive", "A spring whose stiffness follows the tool's mass and inertia.");
  d.details(
      "k_t = clamp(k_0 (m/m_0)^a, k_min, k_device), b_t = 2 zeta sqrt(k_t m). Rotation follows the same equations with "
      "the mean principal inertia. Hou and Sourina (2013) adapt the spring to the mass in this way; they do not print "
      "their functions, so these are this project's own. The sag under gravity grows as m^(1-a).");
  const auto positive = [](std::string doc, std::string unit, double value) {
    return RealOptions{
        .doc = std::move(doc), .unit = std::move(unit), .default_value = value, .min = 0, .above_min = true};
  };
  d.real("k_0", &Params::k_0, positive("stiffness at the mass m_0", "N/m", 500));
  d.real("m_0", &Params::m_0, positive("mass at which the stiffness is k_0", "kg", 0.1));
  d.real("a", &Params::a,
         {.doc = "exponent; 0: a fixed spring, 1: a sag that does not depend on the mass",
          .default_value = 0.5,
          .min = 0,
          .max = 1});
  d.real("k_min", &Params::k_min, positive("smallest stiffness", "N/m", 100));
  d.real("k_device", &Params::k_device, positive("largest stiffness the device renders stably", "N/m", 1000));
  d.real("k_r0", &Params::k_r0, positive("rotational stiffness at the inertia I_0, per rad", "N m/rad", 1));
  d.real("I_0", &Params::I_0, positive("mean inertia at which the stiffness is k_r0", "kg m^2", 1e-4));
  d.real("k_r_min", &Params::k_r_min, positive("smallest rotational stiffness, per rad", "N m/rad", 0.05));
  d.real("k_r_device", &Params::k_r_device,
         positive("largest rotational stiffness the device renders stably, per rad", "N m/rad", 4));
  d.real("zeta", &Params::zeta, {.doc = "damping ratio; 1 is critical", .default_value = 1, .min = 0, .max = 10});
  declare_coupling(d);
  d.tunable({"k_0", "m_0", "a", "k_min", "k_device", "k_r0", "I_0", "k_r_min", "k_r_device", "zeta", "force_max",
             "torque_max"});
  return d.info();
}

}  // namespace tactor
