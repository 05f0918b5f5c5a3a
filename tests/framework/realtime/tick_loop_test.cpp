// By a clock that the test drives: which ticks are called, which are missed, and what happens when the clock jumps.
#include "framework/realtime/tick_loop.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <vector>

BOOST_AUTO_TEST_SUITE(tick_loop_test)

using namespace tactor;

namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr Instant origin{5'000'000'000'000};

/// Time passes where the test says so, and in sleep.
class FakeClock {
 public:
  [[nodiscard]] Instant now() const { return now_; }
  void sleep_until(Instant t) {
    ++sleeps;
    // What a thread would really wait, whatever the clock shows afterwards.
    slept.ns += std::max<std::int64_t>(0, (t - now_).ns);
    now_ = std::max(now_, t);
    if (after_sleep) after_sleep(*this);
  }
  void advance(std::int64_t ns) { now_.ns += ns; }

  int sleeps = 0;
  Duration slept;
  std::function<void(FakeClock&)> after_sleep;

 private:
  Instant now_ = origin;
};

/// Runs at `rate` for `calls` calls of `body(call, clock)` and keeps which ticks they were, and when.
struct Run {
  explicit Run(double loop_rate) : schedule(loop_rate) {}

  void calls(int count, const std::function<void(int, FakeClock&)>& body = {}) {
    std::atomic<bool> stop{false};
    int call = 0;
    run_ticks(clock, schedule, origin, 0, stop, metrics, [&](const Tick& tick) {
      ticks.push_back(tick.number);
      deadlines.push_back(tick.deadline.ns);
      called.push_back((clock.now() - origin).ns);
      if (body) body(call, clock);
      if (++call == count) stop = true;
    });
  }
  void check_counts() const {
    BOOST_TEST(metrics.begun.value() == static_cast<std::int64_t>(ticks.size()));
    BOOST_TEST(metrics.ended.value() == metrics.begun.value());
    BOOST_TEST(metrics.begun.value() + metrics.missed.value() == ticks.back() + 1);
    BOOST_TEST(metrics.wake_latency.count() == ticks.size());
    BOOST_TEST(metrics.body_time.count() == ticks.size());
    for (std::size_t i = 0; i < ticks.size(); ++i) {
      BOOST_TEST(deadlines[i] == std::llround(static_cast<double>(ticks[i]) * 1e9 / schedule.rate()));
    }
  }

  TickSchedule schedule;
  FakeClock clock;
  LoopStatistics metrics;
  std::vector<std::int64_t> ticks;
  std::vector<std::int64_t> deadlines;
  std::vector<std::int64_t> called;
};

using Numbers = std::vector<std::int64_t>;

}  // namespace

BOOST_AUTO_TEST_CASE(deadlines_do_not_drift) {
  const TickSchedule thirds(3);
  BOOST_TEST(thirds.deadline(1).ns == 333'333'333);
  BOOST_TEST(thirds.deadline(2).ns == 666'666'667);
  BOOST_TEST(thirds.deadline(3'000'000).ns == 1'000'000 * 1000 * ms);
  for (const double rate : {1000.0, 3.0, 0.1, 44'100.0, 999.9, 1e6}) {
    const TickSchedule schedule(rate);
    for (std::int64_t k : {0, 1, 2, 7, 999, 1'000'000, 86'400'000}) {
      const Time due = schedule.deadline(k);
      BOOST_TEST(schedule.last_due(due) == k);
      BOOST_TEST(schedule.first_due(due) == k);
      BOOST_TEST(schedule.last_due(due - Duration{1}) == k - 1);
      BOOST_TEST(schedule.first_due(due + Duration{1}) == k + 1);
    }
    BOOST_TEST(schedule.first_due(Time{-1000 * ms}) == 0);
  }
}

BOOST_AUTO_TEST_CASE(ticks_come_at_their_deadlines) {
  Run run(3);
  run.calls(7);
  BOOST_TEST(run.ticks == (Numbers{0, 1, 2, 3, 4, 5, 6}));
  BOOST_TEST(run.called == run.deadlines);
  BOOST_TEST(run.metrics.missed.value() == 0);
  run.check_counts();
}

BOOST_AUTO_TEST_CASE(nothing_is_called_before_the_origin) {
  Run run(1000);
  run.clock.advance(-1234 * ms);
  run.calls(2);
  BOOST_TEST(run.called == (Numbers{0, ms}));
  BOOST_TEST(run.clock.slept.ns == 1235 * ms);
  run.check_counts();
}

BOOST_AUTO_TEST_CASE(a_start_after_the_origin_misses_what_was_due) {
  Run run(1000);
  run.clock.advance(5 * ms + 1);
  run.calls(2);
  BOOST_TEST(run.ticks == (Numbers{6, 7}));
  BOOST_TEST(run.metrics.missed.value() == 6);
  run.check_counts();
}

BOOST_AUTO_TEST_CASE(a_late_wake_up_is_measured_and_the_next_tick_is_in_time) {
  Run run(1000);
  run.clock.after_sleep = [](FakeClock& clock) { clock.advance(60'000); };
  run.calls(4);
  BOOST_TEST(run.called == (Numbers{0, ms + 60'000, 2 * ms + 60'000, 3 * ms + 60'000}));
  BOOST_TEST(run.metrics.wake_latency.max().ns == 60'000);
  BOOST_TEST(run.metrics.missed.value() == 0);
  run.check_counts();
}

BOOST_AUTO_TEST_CASE(a_body_that_overruns_skips_and_does_not_burst) {
  Run run(1000);
  run.calls(4, [](int call, FakeClock& clock) {
    if (call == 1) clock.advance(3 * ms + 200'000);
  });
  // The body of tick 1 ends at 4.2 ms: 2, 3 and 4 are lost, 5 is in time.
  BOOST_TEST(run.ticks == (Numbers{0, 1, 5, 6}));
  BOOST_TEST(run.called == (Numbers{0, ms, 5 * ms, 6 * ms}));
  BOOST_TEST(run.metrics.missed.value() == 3);
  BOOST_TEST(run.metrics.body_time.max().ns == 3 * ms + 200'000);
  run.check_counts();
}

BOOST_AUTO_TEST_CASE(a_body_that_ends_exactly_at_a_deadline_meets_it) {
  Run run(1000);
  run.calls(3, [](int, FakeClock& clock) { clock.advance(ms); });
  BOOST_TEST(run.ticks == (Numbers{0, 1, 2}));
  BOOST_TEST(run.clock.sleeps == 0);
  run.check_counts();
}

BOOST_AUTO_TEST_CASE(a_wake_up_that_is_periods_late_calls_the_newest_tick_once) {
  Run run(1000);
  run.clock.after_sleep = [](FakeClock& clock) {
    if (clock.sleeps == 2) clock.advance(3 * ms + 500'000);
  };
  run.calls(4);
  // The sleep until 2 ms ends at 5.5 ms: the newest force wanted is that of tick 5.
  BOOST_TEST(run.ticks == (Numbers{0, 1, 5, 6}));
  BOOST_TEST(run.called == (Numbers{0, ms, 5 * ms + 500'000, 6 * ms}));
  BOOST_TEST(run.metrics.missed.value() == 3);
  // Measured from the deadline that was slept for, not from the one that was still met.
  BOOST_TEST(run.metrics.wake_latency.max().ns == 3 * ms + 500'000);
  run.check_counts();
}

BOOST_AUTO_TEST_CASE(an_hour_lost_is_one_jump_and_no_burst) {
  Run run(1000);
  run.clock.after_sleep = [](FakeClock& clock) {
    if (clock.sleeps == 3) clock.advance(3'600'000 * ms);
  };
  run.calls(6);
  BOOST_TEST(run.ticks == (Numbers{0, 1, 2, 3'600'003, 3'600'004, 3'600'005}));
  BOOST_TEST(run.metrics.missed.value() == 3'600'000);
  run.check_counts();
}

BOOST_AUTO_TEST_CASE(a_clock_that_falls_back_in_sleep_delays_no_tick_for_long) {
  Run run(1000);
  run.clock.after_sleep = [](FakeClock& clock) {
    if (clock.sleeps == 3) clock.advance(-3'600'000 * ms);
  };
  run.calls(6);
  BOOST_TEST(run.ticks == (Numbers{0, 1, 2, 3, 4, 5}));
  BOOST_TEST(run.metrics.missed.value() == 0);
  BOOST_TEST(run.metrics.clock_steps.value() == 1);
  // Five periods, and once more the one in which the clock fell.
  BOOST_TEST(run.clock.slept.ns == 6 * ms);
  run.check_counts();
}

BOOST_AUTO_TEST_CASE(a_clock_that_falls_back_in_the_body_delays_no_tick_for_long) {
  Run run(1000);
  run.calls(6, [](int call, FakeClock& clock) {
    if (call == 2) clock.advance(-3'600'000 * ms);
  });
  BOOST_TEST(run.ticks == (Numbers{0, 1, 2, 3, 4, 5}));
  BOOST_TEST(run.metrics.clock_steps.value() == 1);
  BOOST_TEST(run.clock.slept.ns == 5 * ms);
  run.check_counts();
}

BOOST_AUTO_TEST_CASE(a_clock_that_jumps_about_keeps_ticks_apart_and_counted) {
  Run run(1000);
  const std::vector<std::int64_t> jumps{7 * ms, -2 * ms, 400'000, -ms / 2, 90 * ms, -1000 * ms, 1};
  run.clock.after_sleep = [&](FakeClock& clock) {
    clock.advance(jumps[static_cast<std::size_t>(clock.sleeps) % jumps.size()]);
  };
  run.calls(500);
  for (std::size_t i = 1; i < run.ticks.size(); ++i) BOOST_TEST(run.ticks[i] > run.ticks[i - 1]);
  BOOST_TEST(run.clock.slept.ns <= static_cast<std::int64_t>(run.clock.sleeps) * ms);
  BOOST_TEST(run.clock.sleeps < 3 * 500);
  BOOST_TEST(run.metrics.clock_steps.value() > 100);
  run.check_counts();
}

BOOST_AUTO_TEST_CASE(a_slow_loop_looks_at_stop_while_it_waits) {
  LoopStatistics metrics;
  FakeClock clock;
  std::atomic<bool> stop{false};
  clock.advance(1);
  clock.after_sleep = [&](FakeClock& asleep) { stop = asleep.sleeps == 3; };
  run_ticks(clock, TickSchedule(0.01), origin, 0, stop, metrics, [](const Tick&) { BOOST_ERROR("called"); });
  BOOST_TEST(clock.slept.ns == 150 * ms);
  BOOST_TEST(metrics.begun.value() == 0);
}

BOOST_AUTO_TEST_CASE(what_the_body_throws_passes_through_and_shows_as_a_call_that_never_ended) {
  Run run(1000);
  const auto body = [](int call, FakeClock&) {
    if (call == 2) throw std::runtime_error("the device is gone");
  };
  BOOST_CHECK_THROW(run.calls(5, body), std::runtime_error);
  BOOST_TEST(run.metrics.begun.value() == 3);
  BOOST_TEST(run.metrics.ended.value() == 2);
}

namespace {

/// Beats at times that the test gives, by the same clock.
class FakePace {
 public:
  FakePace(FakeClock& clock, std::vector<double> beats_ms) : clock_(clock), beats_ms_(std::move(beats_ms)) {}
  [[nodiscard]] std::uint32_t beats() { return static_cast<std::uint32_t>(come()); }
  [[nodiscard]] Instant newest() { return come() == 0 ? Instant{} : at(come() - 1); }
  void wait(std::uint32_t seen, Instant end) {
    if (beats() != seen) return;
    const bool comes = seen < beats_ms_.size() && at(seen) <= end;
    clock_.sleep_until(comes ? at(seen) : end);
  }

 private:
  [[nodiscard]] Instant at(std::size_t i) const {
    return origin + Duration{static_cast<std::int64_t>(std::llround(beats_ms_[i] * 1e6))};
  }
  [[nodiscard]] std::size_t come() const {
    std::size_t n = 0;
    while (n < beats_ms_.size() && at(n) <= clock_.now()) ++n;
    return n;
  }
  FakeClock& clock_;
  std::vector<double> beats_ms_;
};

/// Ticks of a loop of 1 kHz at those beats: its deadlines in ms.
struct PacedRun {
  PacedRun(const std::vector<double>& beats_ms, int calls, const std::function<void(int, FakeClock&)>& body = {}) {
    FakePace pace(clock, beats_ms);
    std::atomic<bool> stop{false};
    run_ticks_by(clock, pace, TickSchedule(1000), origin, 0, stop, metrics, [&](const Tick& tick) {
      numbers.push_back(tick.number);
      deadlines_ms.push_back(1e-6 * static_cast<double>(tick.deadline.ns));
      if (body) body(static_cast<int>(numbers.size()), clock);
      if (static_cast<int>(numbers.size()) == calls) stop = true;
    });
  }
  FakeClock clock;
  LoopStatistics metrics;
  std::vector<double> deadlines_ms;
  Numbers numbers;
};

void check_near(const std::vector<double>& found, const std::vector<double>& expected) {
  BOOST_TEST_REQUIRE(found.size() == expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) BOOST_TEST(std::abs(found[i] - expected[i]) < 1e-9);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_loop_with_a_pace_ticks_at_its_beats) {
  // A device whose clock is slower than ours, and uneven.
  const std::vector<double> beats{0.3, 1.32, 2.30, 3.36, 4.38};
  const PacedRun run(beats, 6);
  // It begins at its origin, and is at the device's pace from the first beat on.
  check_near(run.deadlines_ms, {0, 0.3, 1.32, 2.30, 3.36, 4.38});
  BOOST_TEST((run.numbers == Numbers{0, 1, 2, 3, 4, 5}));
  BOOST_TEST(run.metrics.missed.value() == 0);
}

BOOST_AUTO_TEST_CASE(a_loop_goes_on_without_beats_after_half_a_period_and_takes_them_up_again) {
  const PacedRun run({0, 1, 2, 6.2, 7.2}, 9);
  check_near(run.deadlines_ms, {0, 1, 2, 3.5, 4.5, 5.5, 6.2, 7.2, 8.7});
  BOOST_TEST(run.metrics.missed.value() == 0);
}

BOOST_AUTO_TEST_CASE(beats_that_come_too_soon_are_let_pass) {
  const PacedRun run({0, 0.4, 1, 1.5, 2}, 3);
  check_near(run.deadlines_ms, {0, 1, 2});
}

BOOST_AUTO_TEST_CASE(a_body_that_runs_past_beats_takes_the_newest_and_counts_what_it_missed) {
  const PacedRun run({0, 1, 2, 3, 4, 5, 6}, 4, [](int call, FakeClock& clock) {
    if (call == 2) clock.advance(3'300'000);
  });
  check_near(run.deadlines_ms, {0, 1, 4, 5});
  BOOST_TEST((run.numbers == Numbers{0, 1, 4, 5}));
  BOOST_TEST(run.metrics.missed.value() == 2);
}

BOOST_AUTO_TEST_SUITE_END()
