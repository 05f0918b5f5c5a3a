#include "nodes/passivity/waves.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "framework/core/segment.hpp"
#include "framework/core/value_error.hpp"

namespace tactor {

namespace {

/// A damper that acts some ticks late on a mass m is stable up to this share of m / tick.
constexpr double damping_share = 0.25;

void check(const Waves::Params& params, const NodeContext& context) {
  if (context.torque) {
    throw InputError(
        "passivity.waves carries forces and no torques, and the tool of this scene turns: expected motion: translation "
        "for every body that moves; passivity.energy_bound and passivity.controller bound torques too");
  }
  const double most = damping_share * params.mass * params.rate;
  if (params.impedance <= most) return;
  std::ostringstream text;
  text << "impedance is too high for the handle: expected at most a quarter of mass * rate, " << most << " N s/m for "
       << params.mass << " kg at " << params.rate << " Hz, found " << params.impedance << " N s/m";
  throw ValueError("impedance", text.str());
}

}  // namespace

NodeInfo Waves::declare() {
  Declare<Waves> node("passivity.waves",
                      "Couples the handle to the tool by a line of wave variables, passive whatever it delays.");
  node.details(
      "In place of a coupling where there is a delay. A damper of the wave impedance b ties the handle to a place that "
      "moves as the returning wave says, another ties the tool to a place that moves as the outgoing wave says. "
      "v_out = v - F / b leaves with each tick, made of the force that was commanded and of the way that the encoder "
      "showed; physics gets it as its handle. What returns for a result is 2 p_WT - p_WD. It is played over the "
      "result's period by F = b (v_in - v), from the energy that results have brought, so that the port never gives "
      "more energy than went into the line. At rest the handle feels a spring of b / D, with D half the time from the "
      "handle to physics and back, in series with the contact; moved freely it feels a mass of b D. Its dynamics needs "
      "mass: not dynamics.quasistatic. Forces only, no torques.");
  const Queue every{QueuePolicy::drop_oldest, 64};
  return node.realtime_safe()
      .input("device", &Waves::device, {.doc = "every sample of the handle", .trigger = Trigger::yes, .queue = every})
      .input("commanded", &Waves::commanded,
             {.doc = "what the device commands: the wave that leaves is made of this force", .queue = every})
      .input("state", &Waves::state, {.doc = "tool and outgoing wave at one instant: the wave that returns"})
      .output("wave", &Waves::wave, "the outgoing wave, for physics to take as its handle")
      .output("parameters", &Waves::parameters, "the damper between that and the tool: at the start")
      .kind("parameters", "damper")
      .output("force", &Waves::force, "force on the far end of the line, the mean of a result's period")
      .output("segment", &Waves::segment, "the force at the next tick, held")
      .real("impedance", &Params::impedance,
            {.doc = "wave impedance b: the stiffness wanted at rest times half the time to physics and back; at most a "
                    "quarter of mass * rate",
             .unit = "N s/m",
             .default_value = 20,
             .min = 0,
             .max = 1e4,
             .above_min = true})
      .real("mass", &Params::mass,
            {.doc = "mass of the handle",
             .unit = "kg",
             .default_value = 0.1,
             .min = 0,
             .max = 100,
             .above_min = true,
             .as_in = Role::device})
      .real("catch_up", &Params::catch_up,
            {.doc = "time constant by which the returning wave is played that is due and has not been played",
             .unit = "s",
             .default_value = 0.05,
             .min = 1e-3,
             .max = 10})
      .real("period_min", &Params::period_min,
            {.doc = "results that come closer are put together: their mean takes out what circles in the line faster "
                    "than the handle's damper can follow",
             .unit = "s",
             .default_value = 0.01,
             .min = 1e-3,
             .max = 1})
      .haptic_rate(&Params::rate, {.doc = "ticks a second"})
      .role(Role::coupling)
      .metric("waves.cut_share", "1", "share of the ticks in which the returning wave had too little energy",
              Better::lower)
      .metric("waves.lag_rms_m", "m", "RMS of what of the returning wave had come and not been played", Better::lower)
      .metric("waves.energy_out_J", "J", "energy of the waves that left", Better::neither)
      .metric("waves.energy_played_J", "J", "energy of the waves that were played", Better::neither)
      .info();
}

Waves::Waves(const Params& params, const NodeContext& context)
    : params_(params),
      tick_(Duration::from_rate(params.rate)),
      period_min_(Duration::from_seconds(params.period_min)),
      end_(params.impedance, tick_.seconds(), params.catch_up) {
  check(params, context);
  const Body* tool = context.scene->tool();
  if (tool != nullptr) weight_W_ = tool->mass * context.scene->gravity_W;
}

void Waves::start(StepContext& context) {
  // Physics does not limit what acts on its tool: the largest force is the device's matter.
  constexpr double no_limit = 1e6;
  parameters.send(context.now(), {.b_t = params_.impedance, .force_max = no_limit, .torque_max = no_limit});
}

void Waves::take_sample(const Stamped<DeviceState>& sample) {
  const Vec3& p = sample.value.X_WD.p;
  if (samples_.started()) {
    end_.advance(sample.stamp.valid, p - samples_.newest().value.X_WD.p, held_);
    return;
  }
  end_.start(sample.stamp.valid, p);
  begin_ = sent_ = p;
  sent_at_ = sample.stamp.valid;
}

/// One a step, however many samples it took: the mean of several takes energy away, and adds none.
void Waves::send_wave() {
  const Time at = samples_.newest().stamp.valid;
  DeviceState out = samples_.newest().value;
  out.X_WD.p = end_.outgoing();
  out.V_WD = {};
  const double dt = (at - sent_at_).seconds();
  if (dt > 0) out.V_WD.v = (1 / dt) * (end_.outgoing() - sent_);
  if (dt > 0 || !has_sent_) wave.send(at, out);
  has_sent_ = true;
  sent_ = end_.outgoing();
  sent_at_ = at;
}

void Waves::take_result(Time now) {
  Stamped<PhysicsState> result;
  while (new_results_.next(state, result)) {
    const PhysicsState& s = result.value;
    if (!is_finite(s.X_WT.p) || !is_finite(s.X_WD.p)) continue;
    // The places of a later result have all that went before.
    if (result.stamp.valid < end_.result().at + period_min_) continue;
    // What the tool's weight has given on its way comes back beside what left.
    const double by_weight = dot(weight_W_, s.X_WT.p - begin_);
    force.send(result.stamp.valid, {end_.arrive({result.stamp.valid, s.X_WT.p, s.X_WD.p}, now, by_weight), {}});
    has_result_ = true;
  }
}

void Waves::step(StepContext& context) {
  samples_.take(
      device, commanded, [this](const Wrench& wrench) { held_ = wrench.force; },
      [this](const Stamped<DeviceState>& sample) { take_sample(sample); });
  if (!samples_.started()) return;
  send_wave();
  take_result(context.now());
  if (!has_result_) return;
  // The device ticks next a tick after its newest sample, or after now where it is late.
  const Time next = std::max(samples_.newest().stamp.valid, context.now() - tick_) + tick_;
  const Vec3 wanted = end_.force(next, samples_.newest().value.V_WD.v, held_);
  ++ticks_;
  if (end_.was_cut()) ++cut_;
  const Vec3 lag = end_.arrived() - end_.incoming();
  lag_sum_ += dot(lag, lag);
  segment.send(end_.result().at, constant_segment(next, {wanted, {}}));
}

void Waves::report(Report& report) const {
  const auto ticks = static_cast<double>(std::max<std::uint64_t>(ticks_, 1));
  report.set("waves.cut_share", static_cast<double>(cut_) / ticks);
  report.set("waves.lag_rms_m", std::sqrt(lag_sum_ / ticks));
  report.set("waves.energy_out_J", end_.energy_out());
  report.set("waves.energy_played_J", end_.energy_played());
}

}  // namespace tactor
