#include "nodes/passivity/waves.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "framework/core/segment.hpp"
#include "framework/core/tool_weight.hpp"
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
                      "Couples the handle to the tool by a line of wave variables that is passive at any delay.");
  node.details(
      "Use it in place of a coupling if there is a delay. A damper of the wave impedance b ties the handle to a point "
      "that the returning wave moves. Another damper ties the tool to a point that the outgoing wave moves. v_out = v "
      "- F / b leaves at each tick, computed from the commanded force and the displacement that the encoder showed; "
      "physics gets it as its handle. For each result, 2 p_WT - p_WD returns. It is played over the result's period by "
      "F = b (v_in - v), with the energy that results have brought, so the port never gives more energy than went into "
      "the line. The tool's weight does not go through the line: it is added at the handle. At rest the handle feels a "
      "spring of b / D in series with the contact, where D is half the time from the handle to physics and back. In "
      "free motion it feels a mass of b D. The dynamics must have mass (not dynamics.quasistatic) and start_at_device: "
      "true. It carries forces and no torques.");
  const Queue every{QueuePolicy::drop_oldest, 64};
  return node.realtime_safe()
      .input("device", &Waves::device, {.doc = "every sample of the handle", .trigger = Trigger::yes, .queue = every})
      .input("commanded", &Waves::commanded,
             {.doc = "the wrench that the device commands; the outgoing wave is computed from it", .queue = every})
      .input("state", &Waves::state,
             {.doc = "tool and outgoing wave at one instant; the returning wave is computed from them"})
      .output("wave", &Waves::wave, "the outgoing wave, for physics to take as its handle")
      .output("parameters", &Waves::parameters, "the damper between the outgoing wave and the tool, sent at the start")
      .kind("parameters", "damper")
      .output("force", &Waves::force, "force on the far end of the line, the mean of a result's period")
      .output("segment", &Waves::segment, "the force at the next tick, held")
      .real("impedance", &Params::impedance,
            {.doc = "wave impedance b. Choose the stiffness wanted at rest times half the time to physics and back; at "
                    "most a quarter of mass * rate",
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
            {.doc = "time constant with which the overdue part of the returning wave is played",
             .unit = "s",
             .default_value = 0.05,
             .min = 1e-3,
             .max = 10})
      .real("period_min", &Params::period_min,
            {.doc = "results closer in time than this are averaged. The mean removes what circles in the line faster "
                    "than the handle's damper can follow",
             .unit = "s",
             .default_value = 0.01,
             .min = 1e-3,
             .max = 1})
      .haptic_rate(&Params::rate, {.doc = "ticks per second"})
      .role(Role::coupling)
      .metric("waves.cut_share", "1", "share of the ticks in which the returning wave had too little energy",
              Better::lower,
              [](const Waves& self) {
                return static_cast<double>(self.cut_) / static_cast<double>(std::max<std::uint64_t>(self.ticks_, 1));
              })
      .metric("waves.lag_rms_m", "m", "RMS of what of the returning wave had come and not been played", Better::lower,
              [](const Waves& self) {
                return std::sqrt(self.lag_sum_ / static_cast<double>(std::max<std::uint64_t>(self.ticks_, 1)));
              })
      .metric("waves.energy_out_J", "J", "energy of the waves that left", Better::neither,
              [](const Waves& self) { return self.end_.energy_out(); })
      .metric("waves.energy_played_J", "J", "energy of the waves that were played", Better::neither,
              [](const Waves& self) { return self.end_.energy_played(); })
      .info();
}

Waves::Waves(const Params& params, const NodeContext& context)
    : params_(params),
      tick_(Duration::from_rate(params.rate)),
      period_min_(Duration::from_seconds(params.period_min)),
      weight_W_(tool_weight(*context.scene)),
      end_(params.impedance, tick_.seconds(), params.catch_up) {
  check(params, context);
}

void Waves::start(StepContext& context) {
  // Physics does not limit what acts on its tool: the largest force is the device's matter.
  constexpr double no_limit = 1e6;
  parameters.send(context.now(), {.b_t = params_.impedance, .force_max = no_limit, .torque_max = no_limit});
}

void Waves::take_sample(const Stamped<DeviceState>& sample) {
  const Vec3& p = sample.value.X_WD.p;
  if (samples_.started()) {
    const Stamped<DeviceState>& before = samples_.newest();
    const Duration over = sample.stamp.valid - before.stamp.valid;
    // A device lets go of a command that it has not renewed: its mean over the time counts.
    const double acted = over > tick_ * held_ticks ? (tick_ * held_ticks).seconds() / over.seconds() : 1;
    end_.advance(sample.stamp.valid, p - before.value.X_WD.p, acted * held_);
    return;
  }
  end_.start(sample.stamp.valid, p);
  sent_ = p;
  begin_ = sent_at_ = sample.stamp.valid;
}

/// m, by which the far end's handle has gone on by then to hold the tool against its weight.
Vec3 Waves::hoist(Time at) const {
  return (-(at - begin_).seconds() / params_.impedance) * weight_W_;
}

/// One a step, however many samples it took: the mean of several takes energy away, and adds none.
void Waves::send_wave() {
  const Time at = samples_.newest().stamp.valid;
  DeviceState out = samples_.newest().value;
  out.X_WD.p = end_.outgoing() + hoist(at);
  out.V_WD = {};
  const double dt = (at - sent_at_).seconds();
  if (dt > 0) out.V_WD.v = (1 / dt) * (out.X_WD.p - sent_);
  if (dt > 0 || !has_sent_) wave.send(at, out);
  has_sent_ = true;
  sent_ = out.X_WD.p;
  sent_at_ = at;
}

void Waves::take_result(Time now) {
  Stamped<PhysicsState> result;
  while (new_results_.next(state, result)) {
    const PhysicsState& s = result.value;
    if (!is_finite(s.X_WT.p) || !is_finite(s.X_WD.p)) continue;
    // The places of a later result have all that went before.
    if (result.stamp.valid < end_.result().at + period_min_) continue;
    const Time at = result.stamp.valid;
    force.send(at, {end_.arrive({at, s.X_WT.p, s.X_WD.p - hoist(at)}, now) + weight_W_, {}});
    has_result_ = true;
  }
}

/// N, of a force that is commanded: what goes into the line.
Vec3 Waves::without_weight(const Vec3& f) const {
  return f == Vec3{} ? f : f - weight_W_;
}

void Waves::send_force(Time now) {
  const Stamped<DeviceState>& newest = samples_.newest();
  const int ahead = ticks_ahead(newest.stamp.valid, now, tick_);
  const Time next = newest.stamp.valid + tick_ * ahead;
  Vec3 wanted;
  if (ahead < most_ahead) {
    std::array<Vec3, most_ahead> acting;
    acting[0] = held_;
    for (int i = 1; i < ahead; ++i) {
      const Vec3* sent = forces_.at(newest.stamp.valid + tick_ * i);
      acting[static_cast<std::size_t>(i)] = sent == nullptr ? held_ : *sent;
    }
    wanted = end_.force({acting.data(), static_cast<std::size_t>(ahead)}, newest.value.V_WD.v) + weight_W_;
    if (end_.was_cut()) ++cut_;
  }
  ++ticks_;
  const Vec3 lag = end_.arrived() - end_.incoming();
  lag_sum_ += dot(lag, lag);
  forces_.send(next, without_weight(wanted));
  segment.send(end_.result().at, constant_segment(next, {wanted, {}}));
}

void Waves::step(StepContext& context) {
  samples_.take(
      device, commanded, [this](const Wrench& wrench) { held_ = without_weight(wrench.force); },
      [this](const Stamped<DeviceState>& sample) { take_sample(sample); });
  if (!samples_.started()) return;
  send_wave();
  take_result(context.now());
  if (has_result_) send_force(context.now());
}

}  // namespace tactor
