// The fault that a flight file shows is the one that happened: each is written by hand and looked for.
#include "app/flight/flight_findings.hpp"

#include <boost/test/unit_test.hpp>
#include <functional>

#include "framework/core/messages.hpp"

BOOST_AUTO_TEST_SUITE(flight_findings_test)

using namespace tactor;

namespace {

constexpr std::uint16_t device = 0, physics = 1;
constexpr std::int64_t ms = 1'000'000;
constexpr float period = 1e-3F;

/// A run of a device at 1 kHz for 2 s, engaged with 1 N from the begin; `change` makes each tick what it was.
struct Script {
  FlightLog log;

  Script() {
    log.nodes = {{"device", "device.simulated", 1000, {{"physics", "segment", true}}},
                 {"physics", "dynamics.translation", 0, {}}};
    log.end = FlightEnd::well;
  }
  template <class Body>
  void add(FlightKind kind, std::uint16_t node, std::int64_t time_ns, const Body& body) {
    FlightRecord record;
    record.kind = kind;
    record.node = node;
    record.sequence = log.records.size();
    record.time_ns = time_ns;
    std::memcpy(record.body.data(), &body, sizeof body);
    log.records.push_back(record);
  }
  void tell(FlightEvent event, std::uint16_t node, std::int64_t time_ns, const std::string& words) {
    FlightText text;
    text.event = event;
    text.first = log.records.size();
    text.length = static_cast<std::uint8_t>(words.size());
    std::memcpy(text.text.data(), words.data(), words.size());
    add(FlightKind::event, node, time_ns, text);
  }
  /// Ticks from `from_ms` to `to_ms`; `change` is told the time in ms.
  void ticks(std::int64_t from_ms, std::int64_t to_ms,
             const std::function<void(std::int64_t, FlightDevice&)>& change = nullptr) {
    for (std::int64_t t = from_ms; t < to_ms; ++t) {
      FlightDevice tick;
      tick.wanted_force = tick.commanded_force = {1, 0, 0};
      tick.engagement = static_cast<std::uint8_t>(Engagement::engaged);
      tick.phase = 1;
      tick.generated_J = tick.allowed_J = 0;
      if (change) change(t, tick);
      add(FlightKind::device, device, t * ms, tick);
    }
  }
  [[nodiscard]] FlightFinding fault(bool is_running = false) const {
    const std::vector<FlightFinding> found = find_faults(log, is_running);
    BOOST_REQUIRE(!found.empty());
    return found.front();
  }
};

void cut(FlightDevice& tick, Engagement engagement, SafetyCause cause) {
  tick.engagement = static_cast<std::uint8_t>(engagement);
  tick.cause = static_cast<std::uint8_t>(cause);
}

void check(const FlightFinding& found, FlightFault fault, const std::string& node, double time_s) {
  BOOST_TEST(name_of(found.fault) == name_of(fault));
  BOOST_TEST(found.node == node);
  BOOST_TEST(std::abs(found.time.seconds() - time_s) < 1e-6);
}

}  // namespace

BOOST_AUTO_TEST_CASE(in_a_good_run_nothing_is_found) {
  Script script;
  script.ticks(0, 2000);
  BOOST_TEST(find_faults(script.log, false).empty());
}

BOOST_AUTO_TEST_CASE(a_process_that_ended_without_a_word_was_killed_at_its_last_record) {
  Script script;
  script.ticks(0, 500);
  script.log.end = FlightEnd::none;
  check(script.fault(), FlightFault::killed, "", 0.499);
  BOOST_TEST(script.fault().words.find("device had 1.00 N") != std::string::npos);
  BOOST_TEST(find_faults(script.log, true).empty());  // it goes on
}

BOOST_AUTO_TEST_CASE(a_crash_is_told_with_the_node_that_stepped) {
  Script script;
  script.ticks(0, 500);
  script.tell(FlightEvent::crashed, physics, 500 * ms, "SIGSEGV");
  script.log.end = FlightEnd::none;
  check(script.fault(), FlightFault::crashed, "physics", 0.5);
}

BOOST_AUTO_TEST_CASE(a_step_that_did_not_come_back_stands_before_the_force_that_came_too_late) {
  Script script;
  script.ticks(0, 1500, [](std::int64_t t, FlightDevice& tick) {
    if (t >= 1100) cut(tick, Engagement::ramping, SafetyCause::stale);
    tick.result_age_s = t > 1000 ? static_cast<float>(t - 1000) * period : 0;
  });
  script.tell(FlightEvent::stalled, physics, 1000 * ms, "its step has not come back");
  script.tell(FlightEvent::failed, physics, 1500 * ms, "node physics has stalled");
  script.log.end = FlightEnd::failed;
  check(script.fault(), FlightFault::stalled, "physics", 1.0);
}

BOOST_AUTO_TEST_CASE(without_a_stall_the_writer_of_the_late_result_is_named) {
  Script script;
  script.ticks(0, 1500, [](std::int64_t t, FlightDevice& tick) {
    if (t >= 1100 && t < 1300) cut(tick, Engagement::ramping, SafetyCause::stale);
    tick.result_age_s = 0.1F;
  });
  check(script.fault(), FlightFault::late_result, "physics", 1.1);
}

BOOST_AUTO_TEST_CASE(a_line_that_failed_stands_before_the_reading_that_failed_and_the_end_of_the_run) {
  Script script;
  script.ticks(0, 2000, [](std::int64_t t, FlightDevice& tick) {
    if (t < 1050) return;
    cut(tick, Engagement::fault, SafetyCause::read_failed);
    tick.health = 2;
  });
  for (std::int64_t t = 0; t < 1100; ++t) {
    FlightExchange cycle;
    cycle.error = t >= 1000 ? 1 : 0;
    script.add(FlightKind::exchange, device, t * ms, cycle);
  }
  script.tell(FlightEvent::line_failed, device, 1001 * ms, "timeout: no whole answer");
  script.tell(FlightEvent::failed, device, 2000 * ms, "device device could not be read");
  script.log.end = FlightEnd::failed;
  const FlightFinding fault = script.fault();
  check(fault, FlightFault::line_failed, "device", 1.0);
  BOOST_TEST(fault.ended_run);
  BOOST_TEST(fault.words.starts_with("timeout: no whole answer"));
}

BOOST_AUTO_TEST_CASE(a_cycle_that_never_came_back_is_a_line_that_failed) {
  Script script;
  script.ticks(0, 1500, [](std::int64_t t, FlightDevice& tick) {
    if (t >= 1050) cut(tick, Engagement::fault, SafetyCause::read_failed);
  });
  for (std::int64_t t = 0; t <= 1000; ++t) script.add(FlightKind::exchange, device, t * ms, FlightExchange{});
  check(script.fault(), FlightFault::line_failed, "device", 1.0);
}

BOOST_AUTO_TEST_CASE(a_value_that_is_not_finite_is_told_where_it_came_from) {
  Script script;
  script.tell(FlightEvent::not_finite, physics, 1000 * ms, "state");
  script.ticks(0, 1500, [](std::int64_t t, FlightDevice& tick) {
    if (t >= 1010) cut(tick, Engagement::fault, SafetyCause::not_finite);
  });
  script.tell(FlightEvent::not_finite, device, 1010 * ms, "interpolated");
  check(script.fault(), FlightFault::not_finite, "physics", 1.0);
}

BOOST_AUTO_TEST_CASE(a_late_wake_up_stands_before_the_command_that_expired) {
  Script script;
  script.ticks(0, 1000);
  script.ticks(1030, 1500, [](std::int64_t t, FlightDevice& tick) {
    if (t > 1030) return;
    tick.lateness_s = 30.4F * period;  // ticks from 1000 on
    cut(tick, Engagement::ramping, SafetyCause::expired);
  });
  check(script.fault(), FlightFault::late_wake, "device", 1.0);
}

BOOST_AUTO_TEST_CASE(a_step_that_took_long_is_no_late_wake_up) {
  Script script;
  script.ticks(0, 1001, [](std::int64_t t, FlightDevice& tick) { tick.body_s = t == 1000 ? 29.5F * period : 1e-5F; });
  script.ticks(1030, 1500, [](std::int64_t t, FlightDevice& tick) {
    if (t > 1030) return;
    tick.lateness_s = 29 * period;
    cut(tick, Engagement::ramping, SafetyCause::time_gap);
  });
  check(script.fault(), FlightFault::long_step, "device", 1.0);
}

BOOST_AUTO_TEST_CASE(what_the_gate_held_back_is_told_by_its_kind) {
  for (const auto& [cause, fault] : {std::pair{SafetyCause::overspeed, FlightFault::too_fast},
                                     std::pair{SafetyCause::outside_workspace, FlightFault::outside},
                                     std::pair{SafetyCause::read_failed, FlightFault::device_failed},
                                     std::pair{SafetyCause::dead_man, FlightFault::other_cut}}) {
    Script script;
    script.ticks(0, 1500, [&](std::int64_t t, FlightDevice& tick) {
      if (t >= 1000) cut(tick, Engagement::fault, cause);
    });
    check(script.fault(), fault, "device", 1.0);
  }
  Script limited;
  limited.ticks(0, 1500, [](std::int64_t t, FlightDevice& tick) {
    if (t >= 991) tick.wanted_force = {3, 0, 0};
  });
  check(limited.fault(), FlightFault::limited, "device", 1.0);
  Script energy;
  energy.ticks(0, 1500, [](std::int64_t t, FlightDevice& tick) { tick.generated_J = t >= 1000 ? 1.0F : 0.0F; });
  check(energy.fault(), FlightFault::energy, "device", 1.0);
}

BOOST_AUTO_TEST_CASE(a_node_that_threw_is_told_with_its_words) {
  Script script;
  script.ticks(0, 1000);
  script.tell(FlightEvent::failed, physics, 1000 * ms, "node physics failed at 1.0 s: it broke");
  script.tell(FlightEvent::failed, device, 1100 * ms, "device node device has not stopped");
  script.log.end = FlightEnd::failed;
  const FlightFinding fault = script.fault();
  check(fault, FlightFault::failed, "physics", 1.0);
  BOOST_TEST(fault.words == "node physics failed at 1.0 s: it broke");
}

BOOST_AUTO_TEST_SUITE_END()
