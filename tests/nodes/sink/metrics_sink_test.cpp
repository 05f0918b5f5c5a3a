// The sink on constructed streams: every metric it reports is known beforehand.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <string>

#include "nodes/sink/metrics.hpp"
#include "tests/support/force_stream.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(metrics_sink_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr double pi = std::numbers::pi;
constexpr double delay_ms = 8;
constexpr int run_ms = 3000;

Wrench truth(double ms) {
  return {{std::sin(2 * pi * 1e-3 * ms), 2, 0}, {0, 0.1 * std::cos(2 * pi * 1e-3 * ms), 0}};
}

Metrics::Params params() {
  Metrics::Params p;
  p.settle = Duration::from_seconds(0.5);
  p.jnd_force = 0.04;
  p.jnd_torque = 0.002;
  p.jnd_fraction = 0.07;
  p.max_delay = Duration::from_seconds(0.1);
  p.loss_force = 0.2;
  p.loss_torque = 0.01;
  p.loss_window = Duration::from_seconds(0.2);
  return p;
}

// Physics every 10 ms, visible 10 ms later; predictions that are 0.03 N off; the truth shown `delay_ms` late.
void run(Metrics& sink) {
  const Queue queue{QueuePolicy::drop_oldest, 64};
  sink.commanded.configure(queue);
  sink.force.configure(queue);
  sink.forecast.configure(queue);
  sink.state.configure(queue);
  sink.device.configure(queue);
  for (int ms = 0; ms < run_ms; ++ms) {
    const Stamp now = stamp_ms(ms, static_cast<std::uint64_t>(ms));
    Wrench shown = truth(ms - delay_ms);
    sink.commanded.push(now, &shown);
    DeviceState device;
    device.X_WD.p = {1, 1e-3 * ms, 0};
    sink.device.push(now, &device);
    if (ms % 10 == 0) {
      const Stamp late{now.valid, now.valid + Duration{10'000'000}, static_cast<std::uint64_t>(ms)};
      const Wrench force = truth(ms);
      sink.force.push(late, &force);
      Forecast f{force, {truth(ms + 10)}, 0.01};
      f.predicted_D_W[0].force.z += 0.03;
      sink.forecast.push(late, &f);
      PhysicsState state;
      state.contacts = ms < 2000 ? 4 : 7;
      sink.state.push(late, &state);
    }
    StepContext c(now.produced);
    sink.step(c);
  }
}

void set_reference(Metrics& sink) {
  std::vector<Stamp> stamps;
  std::vector<Wrench> values;
  for (int i = 0; i < 10 * run_ms; ++i) {
    stamps.push_back(stamp_ms(0.1 * i));
    values.push_back(truth(0.1 * i));
  }
  sink.force.set_reference(stamps, std::as_bytes(std::span(values)));
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_truth_shown_late_is_told_with_its_delay_and_error) {
  Metrics sink(params(), context());
  run(sink);
  set_reference(sink);
  const Report report = report_of(sink);
  auto f = metrics_of(report);
  BOOST_TEST(std::abs(f["delivered.force.delay_ms"] - delay_ms) < 0.1);
  // Two sines of amplitude 1 apart by d differ by 2 sin(pi d) in amplitude; the torque's amplitude is 0.1.
  const double amplitude = 2 * std::sin(pi * 1e-3 * delay_ms);
  BOOST_TEST(std::abs(f["delivered.force.rms_error_N"] - amplitude / std::sqrt(2.0)) < 1e-4);
  BOOST_TEST(std::abs(f["delivered.force.max_error_N"] - amplitude) < 1e-4);
  BOOST_TEST(std::abs(f["delivered.torque.rms_error_Nm"] - 0.1 * amplitude / std::sqrt(2.0)) < 1e-5);
  BOOST_TEST(std::abs(f["delivered.torque.delay_ms"] - delay_ms) < 0.1);
  // The reference is at least 2 N, so that 7 % of it is 0.14 N, and no error is larger.
  BOOST_TEST(f["delivered.force.share_beyond_jnd"] == 0.0);
  const double chord = 2 * std::sin(pi * 1e-3) / std::sqrt(2.0);
  BOOST_TEST(std::abs(f["delivered.force.rms_d1_N_per_ms"] - chord) < 1e-6);
  BOOST_TEST(std::abs(f["reference.force.rms_d1_N_per_ms"] - chord) < 1e-6);
  BOOST_TEST(std::abs(f["delivered.force.rms_d2_excess_N_per_ms2"]) < 1e-7);
  // The force is never lost.
  BOOST_TEST(!f.contains("delivered.force.overshoot_after_loss_N"));
  // The error is a wave of 1 Hz, of which the filter leaves (1 / 30)^8.
  BOOST_TEST(f["delivered.force.error_above_30hz_N"] < 1e-3);
  // Physics is right at the time it stands for, however late it comes.
  BOOST_TEST(f["physics.force.rms_error_N"] < 1e-12);
  BOOST_TEST(f["physics.torque.rms_error_Nm"] < 1e-12);
}

BOOST_AUTO_TEST_CASE(errors_of_physics_and_fast_ones_are_told_apart) {
  // The truth, but for 0.3 N turning about x at 100 Hz in what is shown, and 0.05 N too much in physics.
  Metrics sink(params(), context());
  const Queue queue{QueuePolicy::drop_oldest, 64};
  sink.commanded.configure(queue);
  sink.force.configure(queue);
  for (int ms = 0; ms < run_ms; ++ms) {
    const double angle = 2 * pi * 0.1 * ms;
    const Wrench shown = truth(ms) + Wrench{{0, 0.3 * std::cos(angle), 0.3 * std::sin(angle)}, {}};
    sink.commanded.push(stamp_ms(ms, static_cast<std::uint64_t>(ms)), &shown);
    if (ms % 10 == 0) {
      const Wrench force = truth(ms) + Wrench{{0.03, 0, 0.04}, {0, 0, 0.002}};
      sink.force.push(stamp_ms(ms, static_cast<std::uint64_t>(ms)), &force);
    }
    StepContext c(stamp_ms(ms).produced);
    sink.step(c);
  }
  set_reference(sink);
  const Report report = report_of(sink);
  auto f = metrics_of(report);
  const double kept = 1 / (1 + std::pow(std::tan(pi * 0.03) / std::tan(pi * 0.1), 8));
  BOOST_TEST(std::abs(f["delivered.force.error_above_30hz_N"] - 0.3 * kept) < 2e-3);
  BOOST_TEST(std::abs(f["delivered.force.rms_error_N"] - 0.3) < 1e-3);
  BOOST_TEST(std::abs(f["physics.force.rms_error_N"] - 0.05) < 1e-12);
  BOOST_TEST(std::abs(f["physics.torque.rms_error_Nm"] - 0.002) < 1e-12);
}

BOOST_AUTO_TEST_CASE(one_step_errors_are_against_the_next_physics_force) {
  Metrics sink(params(), context());
  run(sink);
  const Report report = report_of(sink);
  auto f = metrics_of(report);
  BOOST_TEST(std::abs(f["one_step.force.rms_error_N"] - 0.03) < 1e-12);
  BOOST_TEST(std::abs(f["one_step.force.rms_error_hold_N"] - std::sqrt(2.0) * std::sin(pi * 0.01)) < 2e-4);
  BOOST_TEST(f["one_step.torque.rms_error_Nm"] < 1e-12);
}

BOOST_AUTO_TEST_CASE(physics_and_contacts_are_told_from_their_streams) {
  Metrics sink(params(), context());
  run(sink);
  const Report report = report_of(sink);
  auto f = metrics_of(report);
  BOOST_TEST(f["physics.steps"] == 300.0);
  for (const char* name : {"physics.rate_hz_min", "physics.rate_hz_median", "physics.rate_hz_max"}) {
    BOOST_TEST(std::abs(f[name] - 100) < 1e-9);
  }
  BOOST_TEST(f["contacts.max"] == 7.0);
  BOOST_TEST(f["contacts.median"] == 4.0);
}

BOOST_AUTO_TEST_CASE(a_result_of_physics_that_comes_late_makes_no_rate_that_physics_never_had) {
  Metrics sink(params(), context());
  sink.force.configure({QueuePolicy::drop_oldest, 64});
  for (int ms = 0; ms < run_ms; ++ms) {
    // Every millisecond, but every seventh 0.95 ms late, so that the next one follows after 0.05 ms.
    const Stamp valid = stamp_ms(ms, static_cast<std::uint64_t>(ms));
    const Stamp stamp{valid.valid, valid.valid + Duration{ms % 7 == 0 ? 950'000 : 0}, valid.sequence};
    const Wrench force = truth(ms);
    sink.force.push(stamp, &force);
    StepContext c(stamp.produced);
    sink.step(c);
  }
  const Report report = report_of(sink);
  auto f = metrics_of(report);
  // Ten intervals take 10 ms, or 0.95 ms less or more.
  BOOST_TEST(std::abs(f["physics.rate_hz_min"] - 10 / 10.95e-3) < 1e-6);
  BOOST_TEST(std::abs(f["physics.rate_hz_median"] - 1000) < 1e-6);
  BOOST_TEST(std::abs(f["physics.rate_hz_max"] - 10 / 9.05e-3) < 1e-6);
}

BOOST_AUTO_TEST_CASE(without_a_reference_only_what_is_known_is_told) {
  Metrics sink(params(), context());
  run(sink);
  const Report report = report_of(sink);
  auto f = metrics_of(report);
  BOOST_TEST(f.contains("delivered.force.rms_d1_N_per_ms"));
  for (const auto& [name, value] : f) {
    BOOST_TEST((name.find("error") == std::string::npos || name.starts_with("one_step")), name << " " << value);
    BOOST_TEST(!name.starts_with("reference"));
  }
  BOOST_TEST(!f.contains("delivered.force.delay_ms"));
}

BOOST_AUTO_TEST_CASE(series_have_one_time_for_each_value) {
  Metrics sink(params(), context());
  run(sink);
  set_reference(sink);
  const Report report = report_of(sink);
  std::map<std::string, const Series*> series;
  for (const Series& s : report.series()) {
    BOOST_TEST(s.time.size() == s.value.size());
    series[s.name] = &s;
  }
  for (const char* name : {"commanded.x", "commanded.norm", "reference.z", "physics.z", "displacement", "contacts",
                           "physics_rate", "one_step_error"}) {
    BOOST_TEST(series.contains(name), name);
  }
  BOOST_TEST(std::abs(series["displacement"]->value.back() - 1e-3 * (run_ms - 1)) < 1e-9);
  // Physics forces stand at the time they arrived.
  BOOST_TEST(std::abs(series["physics.z"]->time.front() - 0.010) < 1e-12);
}

BOOST_AUTO_TEST_CASE(no_torque_is_told_in_a_translation_only_scene) {
  Metrics sink(params(), context(false));
  run(sink);
  set_reference(sink);
  const Report report = report_of(sink);
  for (const auto& [name, value] : report.metrics()) {
    BOOST_TEST(name.find("torque") == std::string::npos, name << " " << value);
  }
}

BOOST_AUTO_TEST_CASE(a_run_until_stopped_keeps_as_much_after_ten_minutes_as_after_two) {
  // Commands and states at 100 Hz, physics at 10 Hz. Samples go in blocks of a minute, so that the newest two stay.
  const Queue queue{QueuePolicy::drop_oldest, 64};
  for (const int minutes : {2, 10}) {
    NodeContext endless = context();
    endless.duration = until_stopped;
    Metrics sink(params(), endless);
    sink.commanded.configure(queue);
    sink.force.configure(queue);
    sink.state.configure(queue);
    sink.device.configure(queue);
    for (int i = 0; i < 6000 * minutes; ++i) {
      const Stamp now = stamp_ms(10 * i, static_cast<std::uint64_t>(i));
      const Wrench shown = truth(10 * i);
      const DeviceState device{};
      sink.commanded.push(now, &shown);
      sink.device.push(now, &device);
      if (i % 10 == 0) {
        const PhysicsState state{};
        sink.force.push(now, &shown);
        sink.state.push(now, &state);
      }
      StepContext c(now.produced);
      sink.step(c);
    }
    const Report report = report_of(sink);
    std::map<std::string, std::size_t> kept;
    for (const Series& s : report.series()) kept[s.name] = s.time.size();
    BOOST_TEST(kept["commanded.norm"] == 12000U);
    BOOST_TEST(kept["displacement"] == 12000U);
    BOOST_TEST(kept["physics.x"] == 1200U);
    BOOST_TEST(kept["contacts"] == 1200U);
    auto f = metrics_of(report);
    BOOST_TEST(f["physics.steps"] == 600.0 * minutes);
    BOOST_TEST(f["judged.from_s"] == std::max(0.5, 60.0 * (minutes - 2)), boost::test_tools::tolerance(1e-12));
    // An energy of which the begin is not known is not told.
    for (const auto& [name, value] : f)
      BOOST_TEST((!name.starts_with("stability.") && !name.starts_with("port.")), name);
  }
}

BOOST_AUTO_TEST_CASE(a_run_that_never_began_reports_nothing_wrong) {
  Metrics sink(params(), context());
  const Report report = report_of(sink);
  BOOST_TEST(metrics_of(report)["physics.steps"] == 0.0);
}

BOOST_AUTO_TEST_SUITE_END()
