#include "nodes/effect/impact.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "framework/core/value_error.hpp"
#include "framework/yaml/yaml_values.hpp"

namespace tactor {

namespace {

constexpr double decays = 6;             // after which a sinusoid is over: a four-hundredth is left
constexpr std::size_t most_ticks = 400;  // so that the least squares take milliseconds
constexpr double fade = 0.02;            // s, in which the force that is left at the end goes out
/// A hand behind a grip is a body of its own, as in device.simulated.
constexpr double least_gripped_mass = 1e-3;  // kg
/// Of the device's slew limit; the rest is the incoming force's.
constexpr double slew_share = 0.8;

void refuse_profile(const std::string& what) {
  throw ValueError("profile",
                   "effect.impact: profile: expected times that rise from 0 s, two rows at least, and finite "
                   "accelerations; found " +
                       what);
}

/// The mean of the profile over each tick: straight between its rows, zero behind them.
std::vector<double> profile_means(const Table& profile, double tick) {
  std::vector<double> gained{0};  // m/s a m/s, until each row
  for (std::size_t i = 0; i < profile.rows(); ++i) {
    const double t = profile.at(i, 0), a = profile.at(i, 1);
    if (!std::isfinite(t) || !std::isfinite(a)) refuse_profile("a row that is not finite");
    if (i == 0 && t != 0) refuse_profile("a first time of " + std::to_string(t) + " s");
    if (i == 0) continue;
    const double before = profile.at(i - 1, 0);
    if (!(t > before)) refuse_profile(std::to_string(t) + " s after " + std::to_string(before) + " s");
    gained.push_back(gained.back() + 0.5 * (t - before) * (a + profile.at(i - 1, 1)));
  }
  if (profile.rows() < 2) refuse_profile("one row");
  const auto until = [&](double t) {
    std::size_t i = 0;
    while (i + 1 < profile.rows() && profile.at(i + 1, 0) <= t) ++i;
    if (i + 1 == profile.rows()) return gained.back();
    const double h = t - profile.at(i, 0), a = profile.at(i, 1);
    const double slope = (profile.at(i + 1, 1) - a) / (profile.at(i + 1, 0) - profile.at(i, 0));
    return gained[i] + a * h + 0.5 * slope * h * h;
  };
  const double length = profile.at(profile.rows() - 1, 0);
  const auto ticks = std::min(most_ticks, static_cast<std::size_t>(std::ceil(length / tick)) + 1);
  std::vector<double> means(ticks);
  for (std::size_t n = 0; n < ticks; ++n) {
    const double begin = static_cast<double>(n) * tick;
    means[n] = (until(begin + tick) - until(begin)) / tick;
  }
  return means;
}

std::vector<double> wanted_means(const Impact::Params& p) {
  const double tick = 1 / p.rate;
  if (p.profile.rows() > 0) return profile_means(p.profile, tick);
  const double length = decays * p.decay.seconds();
  const auto ticks = std::min(most_ticks, static_cast<std::size_t>(std::ceil(length / tick)) + 1);
  return decaying_sinusoid(p.amplitude, p.frequency, p.decay.seconds(), tick, ticks);
}

AccelerationMatch match_of(const Impact::Params& p) {
  if ((p.grip_stiffness > 0 || p.grip_damping > 0) && p.hand_mass < least_gripped_mass) {
    throw ValueError("hand_mass", "effect.impact: hand_mass is too small for a grip: expected at least " +
                                      number_text(least_gripped_mass) +
                                      " kg where grip_stiffness or grip_damping is above 0, found " +
                                      number_text(p.hand_mass) +
                                      " kg; give it more, or make the grip rigid with both 0");
  }
  return match_acceleration(p, 1 / p.rate, wanted_means(p), p.effort,
                            static_cast<std::size_t>(std::ceil(fade * p.rate)));
}

RealOptions of_device(std::string doc, std::string unit, double otherwise, double min, double max) {
  return {.doc = std::move(doc),
          .unit = std::move(unit),
          .default_value = otherwise,
          .min = min,
          .max = max,
          .as_in = Role::device};
}

/// The model of the device that is inverted.
Declare<Impact>& declare_model(Declare<Impact>& d) {
  using Params = Impact::Params;
  return d.real<double>("mass", &Params::mass, of_device("mass of the handle", "kg", 0.1, 0.001, 100))
      .real<double>("damping", &Params::damping, of_device("viscous friction of the handle", "N s/m", 0.2, 0, 1000))
      .real<double>("hand_mass", &Params::hand_mass, of_device("mass of the hand", "kg", 0.55, 0, 100))
      .real<double>("hand_damping", &Params::hand_damping, of_device("damping of the hand", "N s/m", 6.5, 0, 1e4))
      .real<double>("hand_stiffness", &Params::hand_stiffness, of_device("stiffness of the hand", "N/m", 135, 0, 1e6))
      .real<double>("grip_stiffness", &Params::grip_stiffness,
                    of_device("stiffness between handle and hand; 0, with grip_damping 0: rigid", "N/m", 0, 0, 1e6))
      .real<double>("grip_damping", &Params::grip_damping,
                    of_device("damping between handle and hand", "N s/m", 0, 0, 1e4))
      .real<double>("amplifier_bandwidth", &Params::amplifier_bandwidth,
                    of_device("bandwidth of the amplifiers; 0 for none", "Hz", 0, 0, 1e5))
      .real<double>("mode_frequency", &Params::mode_frequency,
                    of_device("frequency of the vibration of handle against motors; 0 for none", "Hz", 0, 0, 1e4))
      .real<double>("mode_damping", &Params::mode_damping,
                    of_device("damping ratio of that vibration", "1", 0.05, 0, 10))
      .real<double>("motor_share", &Params::motor_share,
                    of_device("share of the mass on the motor side", "1", 0.5, 0.01, 0.99));
}

}  // namespace

NodeInfo Impact::declare() {
  Declare<Impact> d("effect.impact", "Adds a short vibration when contact begins, scaled by the speed of the impact.");
  d.details(
      "A wall rendered as a spring feels like foam, because its force begins at zero. People recognise a hard object "
      "by the vibration of the first milliseconds, so the node plays this vibration back open-loop. When contact "
      "begins, the handle gets the additional acceleration v a(t) away from the surface. v is its speed of approach "
      "along the surface's force, at the time of the sample that led to the contact, and\na(t) = amplitude exp(-t / "
      "decay) sin(2 pi frequency t), or the rows of `profile`, in m/s^2 per m/s of impact.\nThe node computes the "
      "forces for it by inverting a model of the device, tick by tick, by least squares. The model has masses, grip, "
      "damper and spring of the hand, amplifier and mode of vibration. It takes the values of the graph's device if "
      "that has such parameters. `impact.match_error` tells what share of the acceleration such a device misses. "
      "Friction and delays are not inverted. The vibration lasts six decays, or 400 ticks at most. Then the force that "
      "the hand still takes fades out in 20 ms.\nThe input `contact` tells when contact begins. Without that input, "
      "contact begins when the incoming force does; then the weight and the inertia of a displayed tool count as "
      "contact too.\nPut the node between interpolation and device. After Kuchenbecker, Fiene, Niemeyer, Improving "
      "contact realism through event-based haptic feedback (2006), and Fiene, Kuchenbecker, Shaping Event-Based Haptic "
      "Transients (2007).");
  declare_stage(d)
      .real("amplitude", &Params::amplitude,
            {.doc = "amplitude of the acceleration, in m/s^2 per m/s of impact",
             .unit = "1/s",
             .default_value = 30,
             .min = 0,
             .max = 1e5})
      .real("frequency", &Params::frequency,
            {.doc = "frequency of the vibration", .unit = "Hz", .default_value = 100, .min = 1, .max = 1e4})
      .real("decay", &Params::decay,
            {.doc = "time after which 1/e of the vibration is left",
             .unit = "s",
             .default_value = 0.01,
             .min = 1e-4,
             .max = 0.5})
      .table("profile", &Params::profile, {{"t", "s", {}}, {"a", "1/s", {}}}, false,
             "an acceleration in place of the sinusoid, in m/s^2 per m/s of impact, linear between its rows")
      .real("threshold", &Params::threshold,
            {.doc = "without the input `contact`: contact begins when the force is larger",
             .unit = "N",
             .default_value = 0.05,
             .min = 0,
             .max = 10})
      .real("quiet", &Params::quiet,
            {.doc = "time without contact that must pass before another vibration",
             .unit = "s",
             .default_value = 0.05,
             .min = 0,
             .max = 10})
      .real("least_speed", &Params::least_speed,
            {.doc = "slower impacts make no vibration", .unit = "m/s", .default_value = 0.02, .min = 0, .max = 10})
      .real("effort", &Params::effort,
            {.doc = "weight of the force in the least squares. A larger weight gives a weaker vibration at frequencies "
                    "that the device hardly follows",
             .default_value = 0.02,
             .min = 1e-6,
             .max = 10})
      .real("force_slew", &Params::force_slew,
            {.doc = "fastest change of the device's force; a vibration takes four fifths of it at most",
             .unit = "N/s",
             .default_value = 2000,
             .min = 0,
             .above_min = true,
             .as_in = Role::device});
  declare_model(d)
      .haptic_rate(&Params::rate, {.doc = "ticks per second"})
      .metric("impact.events", "1", "vibrations that were begun", Better::neither, &Impact::events_)
      .metric("impact.limited_events", "1", "vibrations that were made smaller for `force_max` or `force_slew`",
              Better::lower, &Impact::limited_events_)
      .metric("impact.limited_ticks", "1", "ticks at which the sum was cut at `force_max`", Better::lower,
              &Impact::limited_ticks_)
      .metric("impact.peak_N", "N", "largest force that was added", Better::neither, &Impact::largest_)
      .metric("impact.match_error", "1", "RMS of the acceleration that the linear device misses, of that wanted",
              Better::lower, [](const Impact& self) { return self.match_.error; });
  d.unread_when({"amplitude", "frequency", "decay"}, [](const Params& p, const ParamUse&) {
    return std::string(p.profile.rows() > 0 ? "profile is given" : "");
  });
  return d.info();
}

Impact::Impact(const Params& params, const NodeContext&)
    : threshold_(params.threshold),
      least_speed_(params.least_speed),
      force_max_(params.force_max),
      force_slew_(params.force_slew),
      tick_(Duration::from_rate(params.rate)),
      stage_(tick_),
      onset_(params.quiet),
      match_(match_of(params)) {
  double before = 0;
  for (const double f : match_.force) {
    peak_ = std::max(peak_, std::abs(f));
    steepest_ = std::max(steepest_, std::abs(f - before));
    before = f;
  }
  steepest_ = std::max(steepest_, std::abs(before));
}

/// `displayed`: N, of the force that comes in.
void Impact::begin(Time now, const Touch& touch, double displayed) {
  const double size = norm(touch.force_W);
  const Vec3 v_WD = speeds_.by(touch.at);
  if (!(size > 0) || !is_finite(v_WD)) return;
  const Vec3 n = touch.force_W / size;
  double speed = -dot(v_WD, n);
  if (!(speed >= least_speed_)) return;
  const auto free = std::find_if(voices_.begin(), voices_.end(), [](const Voice& v) { return !v.sounds; });
  if (free == voices_.end()) return;
  const double room = std::max(0.0, force_max_ - displayed), step_room = slew_share * force_slew_ * tick_.seconds();
  if (speed * peak_ > room || speed * steepest_ > step_room) {
    ++limited_events_;
    speed = std::min({speed, room / peak_, step_room / steepest_});
  }
  // From the next tick on: whether a device shows a segment's begin or its end at a tick, none of it is lost.
  *free = {speed * n, now + tick_, -1, true};
  ++events_;
}

/// What is added `later` ticks from now.
Vec3 Impact::sum(int later) const {
  Vec3 total;
  for (const Voice& voice : voices_) {
    const std::int64_t tick = voice.tick + later;
    if (!voice.sounds || tick < 0 || tick >= std::ssize(match_.force)) continue;
    total += match_.force[static_cast<std::size_t>(tick)] * voice.along_W;
  }
  return total;
}

void Impact::step(StepContext& context) {
  const Time now = context.now();
  speeds_.take(device);
  if (!stage_.take(base)) return;
  if (!stage_.is_usable(now)) return stage_.pass_on(segment);
  const Vec3 force = stage_.force(now);
  const Touch touch = touch_of(contact, device, force, threshold_);
  if (onset_.begins(now, touch.touches)) begin(now, touch, norm(force));
  for (Voice& voice : voices_) {
    // By the time that has passed, for a loop may miss ticks.
    voice.tick = std::llround((now - voice.begun).seconds() / tick_.seconds());
    voice.sounds = voice.sounds && voice.tick < std::ssize(match_.force);
  }
  const bool any = std::any_of(voices_.begin(), voices_.end(), [](const Voice& v) { return v.sounds; });
  if (!any) return stage_.pass_on(segment);
  const Vec3 added = sum(0);
  largest_ = std::max(largest_, norm(added));
  const bool limited = stage_.add(now, added, sum(1), force_max_, segment);
  if (stage_.is_first_of_tick(now) && limited) ++limited_ticks_;
}

}  // namespace tactor
