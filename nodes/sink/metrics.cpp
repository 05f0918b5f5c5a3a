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

/// Of a run until stopped.
constexpr Duration newest_kept{60'000'000'000};

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

}  // namespace

Metrics::Metrics(const Params& params, const NodeContext& context)
    : params_(params), torque_(context.torque), whole_(context.duration != until_stopped) {
  if (params.rest > context.duration && context.duration.ns > 0) {
    throw ValueError("rest", "rest: expected at most the duration, " + std::to_string(context.duration.seconds()) +
                                 " s, found " + std::to_string(params.rest.seconds()) + " s");
  }
  if (const Body* tool = context.scene->tool()) mass_ = tool->mass;
  gravity_W_ = context.scene->gravity_W;
  // Room for ten minutes of a 1 kHz device and 250 Hz physics; longer runs and faster ones make the vectors grow.
  const Duration longest = whole_ ? context.duration : newest_kept * 2;
  const auto ms = static_cast<std::size_t>(std::clamp(longest.milliseconds(), 0.0, 6e5)) + 64;
  commands_.reserve(ms);
  positions_.reserve(ms);
  forces_.reserve(ms / 4);
  forecasts_.reserve(ms / 4);
  contacts_.reserve(ms / 4);
  tools_.reserve(ms / 4);
}

void Metrics::step(StepContext& context) {
  drain(new_commanded_, commanded, [this](const auto& m) { commands_.push_back(m); });
  drain(new_force_, force, [this](const auto& m) {
    forces_.push_back(m);
    ++physics_steps_;
  });
  drain(new_forecast_, forecast, [this](const auto& m) { forecasts_.push_back(m); });
  drain(new_state_, state, [this](const auto& m) {
    contacts_.push_back({m.stamp.produced, m.stamp.valid, m.value.contacts});
    tools_.push_back({m.stamp.valid, m.value.X_WT.p, m.value.V_WT.v});
  });
  drain(new_device_, device, [this](const auto& m) { positions_.push_back({m.stamp.valid, m.value.X_WD}); });
  drain(new_truth_, true_device, [this](const auto& m) { true_positions_.push_back({m.stamp.valid, m.value.X_WD}); });
  if (!whole_ && context.now() - kept_from_ >= newest_kept * 2) forget(context.now());
}

void Metrics::forget(Time now) {
  kept_from_ = now - newest_kept;
  const auto take_out = [this](auto& samples, auto valid_of) {
    const auto old = [&](const auto& sample) { return valid_of(sample) < kept_from_; };
    samples.erase(samples.begin(), std::find_if_not(samples.begin(), samples.end(), old));
  };
  const auto stamped = [](const auto& sample) { return sample.stamp.valid; };
  const auto plain = [](const auto& sample) { return sample.valid; };
  take_out(commands_, stamped);
  take_out(forces_, stamped);
  take_out(forecasts_, stamped);
  take_out(contacts_, plain);
  take_out(tools_, plain);
  take_out(positions_, plain);
  take_out(true_positions_, plain);
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
  // Energy is a balance from the start on.
  if (!whole_) return;
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
  return std::max(report.judged_from() + params_.settle, kept_from_);
}

void Metrics::report_interval(Report& report) const {
  const Time from = begin_of(report);
  report.set("judged.from_s", from.seconds());
  if (commands_.empty() || commands_.back().stamp.valid <= from) return;
  report.set("judged.duration_s", (commands_.back().stamp.valid - from).seconds());
}

void Metrics::report_cold_start(Report& report) const {
  if (!whole_) return;
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
  report.set("physics.steps", static_cast<double>(physics_steps_));
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
  // With a delay another wrench than the commanded one was in force.
  const bool in_force = params_.delay_in == 0 && params_.delay_out == 0;
  if (in_force) report.set("stability.passive", found->passive() ? 1.0 : 0.0);
  report.set("port.energy_generated_J", found->generated_J);
  report.set("port.energy_allowed_J", found->allowed_J);
}

}  // namespace tactor
