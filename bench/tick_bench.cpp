// What a tick of the device lane costs, the safety gate in it, and the flight recorder: with warm caches and with cold
// ones.
//
// tick_bench [--seconds S] [--json]
#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "bench/cache_load.hpp"
#include "bench/tick_lane.hpp"
#include "framework/realtime/flight_file.hpp"
#include "framework/realtime/flight_log.hpp"
#include "framework/realtime/memory_lock.hpp"
#include "framework/realtime/periodic_loop.hpp"
#include "framework/realtime/safety_gate.hpp"

using namespace tactor;
using namespace tactor::bench;

namespace {

constexpr int turns = 4;
constexpr std::uint64_t flight_capacity = 65'536;

/// How a row is run.
struct Condition {
  const char* name;
  double rate;  // Hz
  bool load;    // other work on the core of the loop sweeps through the caches
};

constexpr Condition conditions[] = {
    {"hot, 100 kHz", 100'000, false}, {"1 kHz, idle core", 1000, false}, {"1 kHz, caches swept", 1000, true}};

ThreadSettings loop_settings() {
  return {SchedulingPolicy::fifo, 80, static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN)) - 1};
}

nlohmann::ordered_json row(const char* what, const Condition& condition, const LatencyHistogram& h) {
  return {{"what", what},
          {"condition", condition.name},
          {"ticks", h.count()},
          {"p50_us", h.quantile(0.5).microseconds()},
          {"p99_us", h.quantile(0.99).microseconds()},
          {"p99_9_us", h.quantile(0.999).microseconds()},
          {"max_us", h.max().microseconds()}};
}

nlohmann::ordered_json whole_tick(const char* what, const Condition& condition, const LaneTimes& lane) {
  nlohmann::ordered_json r = row(what, condition, lane.body);
  r.update({{"missed", lane.missed},
            {"dropped", lane.dropped},
            {"engaged_share", lane.engaged_share},
            {"allocations", lane.heap_calls},
            {"page_faults", lane.page_faults}});
  return r;
}

/// The gate between two readings of the clock, engaged on a wrench that moves, and the two readings alone.
void run_gate(double rate, Duration duration, LatencyHistogram& gate_time, LatencyHistogram& clock_time) {
  SafetyGate gate({}, Duration::from_seconds(1 / rate));
  SafetyInput input;
  input.permitted = true;
  double commanded = 0;  // kept, so that no tick is left out
  PeriodicLoop loop({.name = "gate", .rate = rate, .thread = loop_settings()}, [&](const Tick& tick) {
    input.now = tick.deadline;
    input.fresh_segment = tick.number % 10 == 0;
    input.wanted_D_W = Wrench{{1, 1e-3 * static_cast<double>(tick.number % 1000), 0}, {}};
    const Instant begin = MonotonicClock::now();
    const SafetyOutput output = gate.tick(input);
    const Instant end = MonotonicClock::now();
    gate_time.record(end - begin);
    clock_time.record(MonotonicClock::now() - end);
    commanded += output.commanded_D_W.force.x;
  });
  loop.start(MonotonicClock::now() + Duration{10'000'000});
  MonotonicClock::sleep_until(MonotonicClock::now() + duration);
  TACTOR_DEMAND(loop.stop(Duration{1'000'000'000}));
  TACTOR_DEMAND(commanded > 0);
}

nlohmann::ordered_json run_all(Duration duration) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const Condition& condition : conditions) {
    std::optional<CacheLoad> load;
    if (condition.load) load.emplace(*loop_settings().cpu);
    LatencyHistogram gate, clock;
    run_gate(condition.rate, duration, gate, clock);
    // In turns, so that both meet the same machine.
    LaneTimes lane, recorded;
    for (int turn = 0; turn < turns; ++turn) {
      run_lane(condition.rate, {duration.ns / turns}, loop_settings(), lane);
      FlightFile flight("tick_bench", {"0", flight_names("tick_bench", {}), flight_capacity});
      run_lane(condition.rate, {duration.ns / turns}, loop_settings(), recorded, &flight.ring());
      flight.ring().set_end(FlightEnd::well);
    }
    rows.push_back(row("reading the clock", condition, clock));
    rows.push_back(row("safety gate", condition, gate));
    rows.push_back(whole_tick("whole tick", condition, lane));
    rows.push_back(whole_tick("with flight record", condition, recorded));
    rows.back()["ratio"] = recorded.body.quantile(0.5).seconds() / lane.body.quantile(0.5).seconds();
  }
  return rows;
}

}  // namespace

int main(int count, char** arguments) {
  double seconds = 10;
  bool json = false;
  for (int i = 1; i < count; ++i) {
    const std::string argument = arguments[i];
    if (argument == "--json") {
      json = true;
    } else if (argument == "--seconds" && i + 1 < count) {
      seconds = std::atof(arguments[++i]);
    } else {
      seconds = 0;
    }
  }
  if (!(seconds >= 1)) {
    fmt::print(stderr, "usage: tick_bench [--seconds S] [--json], at least 1 s a row\n");
    return 2;
  }
  const MemoryLock lock;
  const nlohmann::ordered_json rows = run_all(Duration::from_seconds(seconds));
  if (json) {
    fmt::print("{}\n", nlohmann::ordered_json{{"seconds", seconds}, {"rows", rows}}.dump(2));
    return 0;
  }
  fmt::print("{:<18} {:<20} {:>9} {:>8} {:>8} {:>8} {:>8}\n", "what", "condition", "ticks", "p50 us", "p99 us", "p99.9",
             "max");
  for (const auto& r : rows) {
    fmt::print("{:<18} {:<20} {:>9} {:>8.2f} {:>8.2f} {:>8.2f} {:>8.2f}", r["what"].get<std::string>(),
               r["condition"].get<std::string>(), r["ticks"].get<std::uint64_t>(), r["p50_us"].get<double>(),
               r["p99_us"].get<double>(), r["p99_9_us"].get<double>(), r["max_us"].get<double>());
    if (r.contains("missed")) {
      fmt::print("   missed {}, dropped {}, engaged {:.2f}, allocations {}, page faults {}",
                 r["missed"].get<std::uint64_t>(), r["dropped"].get<std::uint64_t>(), r["engaged_share"].get<double>(),
                 r["allocations"].get<std::int64_t>(), r["page_faults"].get<std::int64_t>());
    }
    if (r.contains("ratio")) fmt::print(", {:.2f} times as long at p50", r["ratio"].get<double>());
    fmt::print("\n");
  }
  return 0;
}
