#include "nodes/sink/metrics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "framework/core/between_samples.hpp"
#include "framework/core/signal_metrics.hpp"
#include "framework/core/value_error.hpp"
#include "nodes/sink/felt_metrics.hpp"
#include "nodes/sink/port_passivity.hpp"

namespace tactor {

namespace {

using std::string;

/// What is above it in an error is felt as roughness rather than as a wrong force; the metric's name says it too.
constexpr double rough_hz = 30;

/// How many intervals between results of physics make a rate. The time between two says no rate: live, one that comes a
/// little late is followed by one in time, a few microseconds after it.
constexpr std::size_t rate_intervals = 10;

constexpr Time never{std::numeric_limits<std::int64_t>::max()};

double median(std::vector<double> x) {
  const auto middle = x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2);
  std::nth_element(x.begin(), middle, x.end());
  if (x.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(x.begin(), middle));
}

void add_axes(Report& report, const string& name, const char* unit, const std::vector<double>& time,
              const std::vector<Vec3>& value) {
  for (int axis = 0; axis < 4; ++axis) {
    Series s{name + (axis == 0 ? ".x" : axis == 1 ? ".y" : axis == 2 ? ".z" : ".norm"), unit, time, {}};
    s.value.reserve(value.size());
    for (const Vec3& v : value) s.value.push_back(axis < 3 ? v[axis] : norm(v));
    report.add_series(std::move(s));
  }
}

template <class T, class Of>
void drain(NewMessages<T>& messages, Input<T>& in, Of of) {
  Stamped<T> m;
  while (messages.next(in, m)) of(m);
}

Wrench force_at(std::span<const Stamped<Wrench>> samples, Time t, std::size_t& cursor) {
  return value_between(
      samples, t, cursor, [](const Stamped<Wrench>& s) { return s.stamp.valid; }, &Stamped<Wrench>::value);
}

constexpr const char* too_short = "fewer than three commands come in the judged interval";

std::string without_reference(const MetricUse& use) {
  return use.reference ? "" : "no reference run is made";
}
std::string without_torque(const MetricUse& use) {
  return use.torque ? "" : "the scene is translation-only";
}
std::string without_input(const MetricUse& use, const char* input) {
  return use.is_fed(input) ? "" : string("nothing feeds the input ") + input;
}

/// Declares the metrics of one part of a wrench.
class PartMetrics {
 public:
  /// `name` and `suffix` as the metrics' names have them, `unit` as tables show it.
  PartMetrics(Declare<Metrics>& node, const char* name, string suffix, string unit)
      : node_(node), name_(name), suffix_(std::move(suffix)), unit_(std::move(unit)) {}

  void declare() {
    const string delivered = "delivered." + name_ + ".", reference = "reference." + name_ + ".";
    const string first = unit_ + "/ms", second = unit_ + "/ms^2";
    add(delivered + "rms_d1_" + suffix_ + "_per_ms", first, "RMS first difference", Better::neither, false);
    add(delivered + "rms_d2_" + suffix_ + "_per_ms2", second, "RMS second difference", Better::lower, false);
    add(delivered + "max_step_" + suffix_, unit_, "largest step between two commands", Better::lower, false);
    add(reference + "rms_" + suffix_, unit_, "RMS of the reference", Better::neither, true);
    add(reference + "rms_d1_" + suffix_ + "_per_ms", first, "RMS first difference of the reference", Better::neither,
        true);
    add(reference + "rms_d2_" + suffix_ + "_per_ms2", second, "RMS second difference of the reference", Better::neither,
        true);
    add(reference + "max_step_" + suffix_, unit_, "largest step of the reference between two commands", Better::neither,
        true);
    add(delivered + "rms_d2_excess_" + suffix_ + "_per_ms2", second, "RMS second difference less that of the reference",
        Better::lower, true);
    add(delivered + "rms_error_" + suffix_, unit_, "RMS error against the reference", Better::lower, true);
    add(delivered + "max_error_" + suffix_, unit_, "largest error against the reference", Better::lower, true);
    add(delivered + "error_above_30hz_" + suffix_, unit_, "RMS of the error above 30 Hz", Better::lower, true,
        string(too_short) + ", or commands come at 60 Hz or slower");
    add(delivered + "delay_ms", "ms", "delay behind the reference; positive: late", Better::near_zero, true,
        string(too_short) + ", or the correlation of their changes has no peak");
    add(delivered + "share_beyond_jnd", "1", "share of the time in which the error can be felt", Better::lower, true);
    const string no_loss = string(too_short) + ", or contact is never lost";
    add(delivered + "overshoot_after_loss_" + suffix_, unit_,
        "largest pull towards the surface after contact was lost, beyond the reference's", Better::lower, true,
        no_loss);
    add(delivered + "ghost_after_loss_" + suffix_, unit_,
        "largest push away from the surface late after contact was lost", Better::lower, true, no_loss);

    const string one_step = "one_step." + name_ + ".";
    add_one_step(one_step + "rms_error_" + suffix_, "RMS error of the first step predicted", Better::lower);
    add_one_step(one_step + "rms_error_hold_" + suffix_, "RMS error that a hold would have", Better::neither);

    const string physics = "physics." + name_ + ".";
    const string no_result = "no physics result comes in the judged interval and before the end of the reference run";
    add(physics + "rms_error_" + suffix_, unit_, "RMS error of the physics results at their stamps", Better::lower,
        true, no_result);
    add(physics + "max_error_" + suffix_, unit_, "largest error of the physics results at their stamps", Better::lower,
        true, no_result);
  }

 private:
  void add(string name, string unit, string doc, Better better, bool needs_reference, string missing = too_short) {
    const bool is_torque = name_ == "torque";
    node_.metric(std::move(name), std::move(unit), std::move(doc), better)
        .missing_where(std::move(missing))
        .left_out_when([is_torque, needs_reference](const Metrics::Params&, const MetricUse& use) {
          string why = is_torque ? without_torque(use) : string();
          return !why.empty() || !needs_reference ? why : without_reference(use);
        });
  }
  void add_one_step(string name, string doc, Better better) {
    const bool is_torque = name_ == "torque";
    node_.metric(std::move(name), unit_, std::move(doc), better)
        .missing_where("no physics result comes after a forecast in the judged interval")
        .left_out_when([is_torque](const Metrics::Params&, const MetricUse& use) {
          string why = is_torque ? without_torque(use) : string();
          return why.empty() ? without_input(use, "forecast") : why;
        });
  }

  Declare<Metrics>& node_;
  string name_, suffix_, unit_;
};

void declare_parameters(Declare<Metrics>& node) {
  using Params = Metrics::Params;
  node.real("settle", &Params::settle,
            {.doc = "time at the start that the metrics leave out", .unit = "s", .default_value = 0.2, .min = 0})
      .real("jnd_force", &Params::jnd_force,
            {.doc = "the smallest force that is felt on the arm", .unit = "N", .default_value = 0.04, .min = 0})
      .real("jnd_torque", &Params::jnd_torque,
            {.doc = "the smallest torque felt: 0.04 N at 50 mm", .unit = "N m", .default_value = 0.002, .min = 0})
      .real("jnd_fraction", &Params::jnd_fraction,
            {.doc = "smallest relative change that is felt", .default_value = 0.07, .min = 0, .max = 1})
      .real("mass", &Params::handle_mass,
            {.doc = "mass of the device's handle, which decides how much force makes it vibrate",
             .unit = "kg",
             .default_value = 0.1,
             .min = 0.001,
             .max = 100,
             .as_in = Role::device})
      .real("max_delay", &Params::max_delay,
            {.doc = "largest delay that is searched for", .unit = "s", .default_value = 0.1, .min = 0, .max = 10})
      .real("loss_force", &Params::loss_force,
            {.doc = "contact is lost when the reference force falls below this",
             .unit = "N",
             .default_value = 0.2,
             .min = 0})
      .real("loss_torque", &Params::loss_torque,
            {.doc = "contact is lost when the reference torque falls below this",
             .unit = "N m",
             .default_value = 0.01,
             .min = 0})
      .real("loss_window", &Params::loss_window,
            {.doc = "time after a loss of contact in which overshoot and ghost force are measured",
             .unit = "s",
             .default_value = 0.2,
             .min = 0})
      .real("rest", &Params::rest,
            {.doc =
                 "time at the end of the run in which the tool should be at rest, for stability.*; 0: it need not rest",
             .unit = "s",
             .default_value = 0,
             .min = 0})
      .real("rest_peak_to_peak", &Params::rest_peak_to_peak,
            {.doc = "peak-to-peak amplitude that the tool may have at rest; more counts as a limit cycle. The tremor "
                    "of a trajectory is included",
             .unit = "m",
             .default_value = 1e-4,
             .min = 0})
      .real("encoder_step", &Params::encoder_step,
            {.doc = "step of the device's position encoders, for port.energy_allowed_J",
             .unit = "m",
             .default_value = 1e-5,
             .min = 0,
             .max = 1e-2,
             .as_in = Role::device})
      .real("encoder_step_angle", &Params::encoder_step_angle,
            {.doc = "step of its angle encoders",
             .unit = "rad",
             .default_value = 1e-4,
             .min = 0,
             .max = 0.1,
             .as_in = Role::device})
      .boolean("tool_weight", &Params::tool_weight, true,
               "true if the method displays the tool's weight, whose part of port.energy_generated_J then counts as "
               "the hand's own; false for a proxy and for a force field")
      .formerly("rest_peak_to_peak", "rest_swing")
      .formerly("mass", "handle_mass");
}

void declare_metrics(Declare<Metrics>& node) {
  PartMetrics(node, "force", "N", "N").declare();
  PartMetrics(node, "torque", "Nm", "N m").declare();
  declare_felt_metrics(node);
  const char* const never_cold =
      "all nodes are warm from the start or one never is, nothing comes before, or the whole run is judged";
  node.metric("judged.from_s", "s", "when the judged interval begins", Better::neither)
      .metric("judged.duration_s", "s", "how long it is", Better::neither)
      .missing_where("no command comes after its begin")
      .metric("cold_start.delivered.force.rms_error_N", "N",
              "RMS error against the reference from `settle` until all nodes are warm", Better::lower)
      .missing_where(never_cold)
      .left_out_when([](const Metrics::Params&, const MetricUse& use) { return without_reference(use); })
      .metric("cold_start.one_step.force.rms_error_N", "N",
              "RMS error of the first step predicted from `settle` until all nodes are warm", Better::lower)
      .missing_where(never_cold)
      .left_out_when([](const Metrics::Params&, const MetricUse& use) { return without_input(use, "forecast"); });
  const char* const no_rate = "fewer than two physics results come, or none in the judged interval";
  node.metric("physics.steps", "1", "physics results", Better::neither)
      .metric("physics.rate_hz_min", "Hz", "lowest rate of the physics over ten intervals", Better::neither)
      .missing_where(no_rate)
      .metric("physics.rate_hz_max", "Hz", "highest rate of the physics over ten intervals", Better::neither)
      .missing_where(no_rate)
      .metric("physics.rate_hz_median", "Hz", "median rate of the physics over ten intervals", Better::neither)
      .missing_where(no_rate);
  const auto without_state = [](const Metrics::Params&, const MetricUse& use) { return without_input(use, "state"); };
  const char* const no_state = "no state comes in the judged interval";
  node.metric("contacts.max", "1", "most contacts that carried force", Better::neither)
      .missing_where(no_state)
      .left_out_when(without_state)
      .metric("contacts.median", "1", "median number of contacts that carried force", Better::neither)
      .missing_where(no_state)
      .left_out_when(without_state);
  const auto unwatched = [](const Metrics::Params&, const MetricUse& use) {
    return use.is_fed("state") ? string() : without_input(use, "device");
  };
  const auto without_rest = [unwatched](const Metrics::Params& params, const MetricUse& use) {
    return params.rest.ns == 0 ? string("rest is 0") : unwatched(params, use);
  };
  const char* const unseen = "fewer than two samples of handle and tool come";
  node.metric("stability.verdict", "1", "0 stable, 1 limit cycle, 3 energy from nowhere, 4 not finite", Better::lower)
      .missing_where(unseen)
      .left_out_when(unwatched)
      .metric("stability.peak_energy_J", "J", "most energy that the tool had at a time", Better::neither)
      .missing_where(unseen)
      .left_out_when(unwatched)
      .metric("stability.passivity_violation_J", "J", "most energy that the hand got beyond what it had given",
              Better::lower)
      .missing_where(unseen)
      .left_out_when(unwatched)
      .metric("stability.oscillation_amplitude_m", "m", "amplitude of the tool's oscillation over `rest`",
              Better::lower)
      .missing_where(unseen)
      .left_out_when(without_rest)
      .metric("stability.oscillation_frequency_Hz", "Hz", "frequency of the tool's oscillation over `rest`",
              Better::neither)
      .missing_where(unseen)
      .left_out_when(without_rest);
  const auto no_port = [](const Metrics::Params&, const MetricUse& use) {
    return use.is_fed("truth") ? string() : without_input(use, "device");
  };
  const char* const few = "fewer than two samples of the handle come";
  node.metric("stability.passive", "1", "1: port.energy_generated_J is within port.energy_allowed_J, 0: it is not",
              Better::higher)
      .missing_where(few)
      .left_out_when(no_port)
      .metric("port.energy_generated_J", "J", "most net energy that the motors had given to handle and hand",
              Better::lower)
      .missing_where(few)
      .left_out_when(no_port)
      .metric("port.energy_allowed_J", "J", "what one encoder step at the largest force and one tick can bring",
              Better::neither)
      .missing_where(few)
      .left_out_when(no_port);
}

}  // namespace

NodeInfo Metrics::declare() {
  const Queue every{QueuePolicy::drop_oldest, 64};
  Declare<Metrics> node("sink.metrics", "Measures error, delay and smoothness of the delivered force.");
  node.sink()
      .details(
          "delivered.* compares `commanded` with the physics force of the reference run at the same time. It has the "
          "RMS and the largest error, and the RMS of the error above 30 Hz (Butterworth of fourth order forwards and "
          "backwards, so without a shift). The delay is the lag at which the changes of the two within 20 ms correlate "
          "best; positive means late, and it is left out if there is none. Smoothness is the RMS of the first and "
          "second difference, the second also as the excess over the reference's, and the largest step. The share of "
          "time in which the error can be felt has two forms: share_beyond_jnd has one floor and one fraction, "
          "share_beyond_weber a curve that grows at low forces. The vibration of the error is compared with what a "
          "hand on the handle feels, in thirds of an octave (docs/results/thresholds.md). After contact is lost, if it "
          "ever is, the overshoot is the largest force towards the surface beyond the reference's own, and the ghost "
          "is the force that still pushes away from it late in the window.\none_step.* compares the predicted force "
          "with the next physics force, and has the error of a hold.\nphysics.* tells how often `force` comes, counted "
          "over ten intervals in a row (over all if there are fewer), and its error at its own stamp against the "
          "reference at that time, which contains no delay.\ncontacts.* counts contacts that carried "
          "force.\nstability.* is about the energy where hand and device meet, and about the tool at rest. "
          "passivity_violation is the most energy that the hand has got from the device beyond what it had given and "
          "what the tool's weight gave. peak_energy is the most energy that the tool had at a time: kinetic energy, "
          "and the energy of its height if it was above its start. oscillation is the amplitude (half of the way there "
          "and back; a drift in one direction does not count) and the frequency of the tool over `rest`. The verdict "
          "is 0 stable, 1 limit cycle (more than `rest_peak_to_peak` there and back), 3 energy from nowhere (over 10 % "
          "of what came in and 1 uJ), 4 not finite. Only the tool counts, no other moving body; a massless tool counts "
          "with the weight that the scene gives it. stability.passive is the strict form of stable. It holds if at no "
          "time the motors had given more net energy at the port (commanded wrench by the displacement of the handle, "
          "less the weight's part) than max |F| D + max |F . dx|, where D is a step of the encoder and dx the "
          "displacement of a tick. The displacement is the handle's true one if `truth` is connected. Without a "
          "reference, the metrics that need one are left out.")
      .input("commanded", &Metrics::commanded,
             {.doc = "the wrench that the device should display, at its rate",
              .trigger = Trigger::yes,
              .queue = every,
              .judged = true})
      .input("force", &Metrics::force,
             {.doc = "the physics force; the reference run's is the truth",
              .trigger = Trigger::yes,
              .queue = every,
              .reference = true})
      .input("forecast", &Metrics::forecast,
             {.doc = "what was predicted", .trigger = Trigger::yes, .required = false, .queue = every})
      .input("state", &Metrics::state,
             {.doc = "for the contacts", .trigger = Trigger::yes, .required = false, .queue = every})
      .input("device", &Metrics::device,
             {.doc = "for the displacement", .trigger = Trigger::yes, .required = false, .queue = every})
      .input("truth", &Metrics::true_device,
             {.doc = "the true state of the handle, for the energy of the port; without this input, `device` is used",
              .trigger = Trigger::yes,
              .required = false,
              .queue = every});
  declare_parameters(node);
  declare_metrics(node);
  return node.info();
}

Metrics::Metrics(const Params& params, const NodeContext& context) : params_(params), torque_(context.torque) {
  if (params.rest > context.duration && context.duration.ns > 0) {
    throw ValueError("rest", "rest: expected at most the duration, " + std::to_string(context.duration.seconds()) +
                                 " s, found " + std::to_string(params.rest.seconds()) + " s");
  }
  if (const Body* tool = context.scene->tool()) mass_ = tool->mass;
  gravity_W_ = context.scene->gravity_W;
  // Room for ten minutes of a 1 kHz device and 250 Hz physics; longer runs and faster ones make the vectors grow.
  const auto ms = static_cast<std::size_t>(std::clamp(context.duration.milliseconds(), 0.0, 6e5)) + 64;
  commands_.reserve(ms);
  positions_.reserve(ms);
  forces_.reserve(ms / 4);
  forecasts_.reserve(ms / 4);
  contacts_.reserve(ms / 4);
  tools_.reserve(ms / 4);
}

void Metrics::step(StepContext&) {
  drain(new_commanded_, commanded, [this](const auto& m) { commands_.push_back(m); });
  drain(new_force_, force, [this](const auto& m) { forces_.push_back(m); });
  drain(new_forecast_, forecast, [this](const auto& m) { forecasts_.push_back(m); });
  drain(new_state_, state, [this](const auto& m) {
    contacts_.push_back({m.stamp.produced, m.stamp.valid, m.value.contacts});
    tools_.push_back({m.stamp.valid, m.value.X_WT.p, m.value.V_WT.v});
  });
  drain(new_device_, device, [this](const auto& m) { positions_.push_back({m.stamp.valid, m.value.X_WD}); });
  drain(new_truth_, true_device, [this](const auto& m) { true_positions_.push_back({m.stamp.valid, m.value.X_WD}); });
}

void Metrics::report(Report& report) const {
  report_interval(report);
  report_cold_start(report);
  report_delivered(report, force_part());
  if (torque_) report_delivered(report, torque_part());
  report_one_step(report, force_part(), true);
  if (torque_) report_one_step(report, torque_part(), false);
  report_physics(report);
  report_physics_error(report, force_part());
  if (torque_) report_physics_error(report, torque_part());
  report_contacts(report);
  report_displacement(report);
  report_stability(report);
  report_port(report);
}

Metrics::Delivered Metrics::delivered(const Part& part, Time from, Time until) const {
  const auto truth = force.reference();
  Delivered found;
  std::size_t cursor = 0;
  for (const Stamped<Wrench>& c : commands_) {
    const Time t = c.stamp.valid;
    if (t < from) continue;
    if (t >= until || (!truth.empty() && t > truth.back().stamp.valid)) break;
    found.time.push_back(t.seconds());
    found.shown.push_back(c.value.*part.member);
    if (!truth.empty()) found.wanted.push_back(force_at(truth, t, cursor).*part.member);
  }
  return found;
}

void Metrics::report_delivered(Report& report, const Part& part) const {
  const auto [time, shown, wanted] = delivered(part, Time{}, never);
  const auto settled =
      static_cast<std::size_t>(std::lower_bound(time.begin(), time.end(), begin_of(report).seconds()) - time.begin());
  // The series of a force keep the short names; those of a torque say what they are.
  const string prefix = string(part.name) == "force" ? "" : "torque.";
  const char* unit = prefix.empty() ? "N" : "N m";
  add_axes(report, prefix + "commanded", unit, time, shown);
  if (!wanted.empty()) add_axes(report, prefix + "reference", unit, time, wanted);
  if (time.size() < settled + 3) return;

  const double step = (time.back() - time[settled]) / static_cast<double>(time.size() - settled - 1);
  const double step_ms = 1e3 * step;
  const std::span<const Vec3> x = std::span(shown).subspan(settled);
  const string delivered = string("delivered.") + part.name + ".";
  const string N = part.unit;
  const Smoothness mine = smoothness(x, step_ms);
  report.set(delivered + "rms_d1_" + N + "_per_ms", mine.rms_d1);
  report.set(delivered + "rms_d2_" + N + "_per_ms2", mine.rms_d2);
  report.set(delivered + "max_step_" + N, mine.max_step);
  if (wanted.empty()) return;

  const std::span<const Vec3> r = std::span(wanted).subspan(settled);
  const Smoothness ideal = smoothness(r, step_ms);
  const string reference = string("reference.") + part.name + ".";
  report.set(reference + "rms_" + N, rms(r));
  report.set(reference + "rms_d1_" + N + "_per_ms", ideal.rms_d1);
  report.set(reference + "rms_d2_" + N + "_per_ms2", ideal.rms_d2);
  report.set(reference + "max_step_" + N, ideal.max_step);
  report.set(delivered + "rms_d2_excess_" + N + "_per_ms2", mine.rms_d2 - ideal.rms_d2);
  report.set(delivered + "rms_error_" + N, rms_error(x, r));
  report.set(delivered + "max_error_" + N, max_error(x, r));
  if (step < 1 / (2 * rough_hz)) {
    std::vector<Vec3> error(x.begin(), x.end());
    for (std::size_t i = 0; i < error.size(); ++i) error[i] -= r[i];
    report.set(delivered + "error_above_30hz_" + N, rms_above(error, rough_hz, 1 / step));
  }
  const std::int64_t change = std::max(1LL, std::llround(delay_change_time_s / step));
  if (const auto lag = delay_of_changes(x, r, std::llround(params_.max_delay.seconds() / step), change)) {
    report.set(delivered + "delay_ms", *lag * step_ms);
  }
  report.set(delivered + "share_beyond_jnd", share_beyond(x, r, part.jnd, params_.jnd_fraction));
  if (prefix.empty()) report_felt(report, x, r, 1 / step, params_.handle_mass);
  if (const auto loss = after_loss(x, r, part.loss, std::llround(params_.loss_window.seconds() / step))) {
    report.set(delivered + "overshoot_after_loss_" + N, loss->overshoot);
    report.set(delivered + "ghost_after_loss_" + N, loss->ghost);
  }
}

Metrics::OneStep Metrics::one_step(const Part& part, Time from, Time until) const {
  OneStep errors;
  std::size_t next = 0;
  for (const Stamped<Forecast>& f : forecasts_) {
    while (next < forces_.size() && forces_[next].stamp.valid <= f.stamp.valid) ++next;
    if (next == forces_.size()) break;
    if (f.stamp.valid < from || f.stamp.valid >= until) continue;
    const Vec3 actual = forces_[next].value.*part.member;
    errors.time.push_back(forces_[next].stamp.valid.seconds());
    errors.predicted.push_back(norm(f.value.predicted_D_W.front().*part.member - actual));
    errors.held.push_back(norm(f.value.current_D_W.*part.member - actual));
  }
  return errors;
}

void Metrics::report_one_step(Report& report, const Part& part, bool series) const {
  OneStep errors = one_step(part, begin_of(report), never);
  if (errors.predicted.empty()) return;
  const string one_step = string("one_step.") + part.name + ".";
  report.set(one_step + "rms_error_" + part.unit, rms(errors.predicted));
  report.set(one_step + "rms_error_hold_" + part.unit, rms(errors.held));
  if (series) report.add_series({"one_step_error", "N", std::move(errors.time), std::move(errors.predicted)});
}

Time Metrics::begin_of(const Report& report) const {
  return report.judged_from() + params_.settle;
}

void Metrics::report_interval(Report& report) const {
  const Time from = begin_of(report);
  report.set("judged.from_s", from.seconds());
  if (commands_.empty() || commands_.back().stamp.valid <= from) return;
  report.set("judged.duration_s", (commands_.back().stamp.valid - from).seconds());
}

void Metrics::report_cold_start(Report& report) const {
  const Time from = Time{} + params_.settle;
  const Time until = report.judged_from();
  const OneStep errors = one_step(force_part(), from, until);
  if (!errors.predicted.empty()) report.set("cold_start.one_step.force.rms_error_N", rms(errors.predicted));
  const Delivered cold = delivered(force_part(), from, until);
  if (!cold.wanted.empty()) report.set("cold_start.delivered.force.rms_error_N", rms_error(cold.shown, cold.wanted));
}

void Metrics::report_physics(Report& report) const {
  std::array<Series, 3> axes{Series{"physics.x", "N", {}, {}}, {"physics.y", "N", {}, {}}, {"physics.z", "N", {}, {}}};
  Series rate{"physics_rate", "Hz", {}, {}};
  std::vector<double> settled_rates;
  for (std::size_t i = 0; i < forces_.size(); ++i) {
    const Stamp& stamp = forces_[i].stamp;
    for (int axis = 0; axis < 3; ++axis) {
      axes[static_cast<std::size_t>(axis)].time.push_back(stamp.produced.seconds());
      axes[static_cast<std::size_t>(axis)].value.push_back(forces_[i].value.force[axis]);
    }
    const std::size_t intervals = std::min(rate_intervals, forces_.size() - 1);
    if (intervals == 0 || i < intervals) continue;
    // By arrival: what a force is valid for is rounded to samples of the device.
    const double time = (stamp.produced - forces_[i - intervals].stamp.produced).seconds();
    if (time <= 0) continue;
    rate.time.push_back(stamp.produced.seconds());
    rate.value.push_back(static_cast<double>(intervals) / time);
    if (stamp.valid >= begin_of(report)) settled_rates.push_back(rate.value.back());
  }
  report.set("physics.steps", static_cast<double>(forces_.size()));
  if (!settled_rates.empty()) {
    const auto [low, high] = std::minmax_element(settled_rates.begin(), settled_rates.end());
    report.set("physics.rate_hz_min", *low);
    report.set("physics.rate_hz_max", *high);
    report.set("physics.rate_hz_median", median(settled_rates));
  }
  for (Series& axis : axes) report.add_series(std::move(axis));
  report.add_series(std::move(rate));
}

void Metrics::report_physics_error(Report& report, const Part& part) const {
  const auto truth = force.reference();
  if (truth.empty()) return;
  std::vector<double> errors;
  std::size_t cursor = 0;
  Time before;
  for (const Stamped<Wrench>& f : forces_) {
    const Time t = f.stamp.valid;
    // A stamp may come twice; one that goes back would be looked up wrongly.
    if (t < begin_of(report) || t > truth.back().stamp.valid || t < before) continue;
    before = t;
    errors.push_back(norm(f.value.*part.member - force_at(truth, t, cursor).*part.member));
  }
  if (errors.empty()) return;
  report.set(string("physics.") + part.name + ".rms_error_" + part.unit, rms(errors));
  report.set(string("physics.") + part.name + ".max_error_" + part.unit,
             *std::max_element(errors.begin(), errors.end()));
}

void Metrics::report_contacts(Report& report) const {
  if (contacts_.empty()) return;
  Series count{"contacts", "1", {}, {}};
  std::vector<double> settled;
  for (const Contacts& c : contacts_) {
    count.time.push_back(c.produced.seconds());
    count.value.push_back(c.count);
    if (c.valid >= begin_of(report)) settled.push_back(c.count);
  }
  if (!settled.empty()) {
    report.set("contacts.max", *std::max_element(settled.begin(), settled.end()));
    report.set("contacts.median", median(settled));
  }
  report.add_series(std::move(count));
}

void Metrics::report_displacement(Report& report) const {
  if (positions_.empty()) return;
  Series displacement{"displacement", "m", {}, {}};
  for (const HandleSample& p : positions_) {
    displacement.time.push_back(p.valid.seconds());
    displacement.value.push_back(norm(p.X_WD.p - positions_.front().X_WD.p));
  }
  report.add_series(std::move(displacement));
}

void Metrics::report_stability(Report& report) const {
  const RunSignals signals{commands_, positions_, tools_, mass_, gravity_W_, torque_};
  const auto found = run_stability(signals, params_.rest, params_.rest_peak_to_peak);
  if (!found) return;
  report.set("stability.verdict", static_cast<double>(found->verdict));
  report.set("stability.peak_energy_J", found->peak_energy_J);
  report.set("stability.passivity_violation_J", found->generated_J);
  if (params_.rest.ns == 0) return;
  report.set("stability.oscillation_amplitude_m", found->amplitude_m);
  report.set("stability.oscillation_frequency_Hz", found->frequency_Hz);
}

void Metrics::report_port(Report& report) const {
  const auto& handle = true_device.connected() ? true_positions_ : positions_;
  const double mass = params_.tool_weight ? mass_ : 0;
  const RunSignals signals{commands_, handle, {}, mass, gravity_W_, torque_};
  const auto found = port_passivity(signals, params_.encoder_step, params_.encoder_step_angle);
  if (!found) return;
  report.set("stability.passive", found->passive() ? 1.0 : 0.0);
  report.set("port.energy_generated_J", found->generated_J);
  report.set("port.energy_allowed_J", found->allowed_J);
}

}  // namespace tactor
