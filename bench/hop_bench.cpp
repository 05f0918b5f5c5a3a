// Message latency between two light nodes: the live engine beside bare CAF, in interleaved rounds of one run.
//
// hop_bench [--rounds N] [--seconds S] [--json]
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/hop_caf.hpp"
#include "bench/hop_live.hpp"
#include "framework/realtime/memory_lock.hpp"

using namespace tactor;
using namespace tactor::bench;

namespace {

constexpr int workers = 2;
constexpr ThreadSettings other{};
constexpr ThreadSettings fifo{SchedulingPolicy::fifo, 50, std::nullopt};
/// What the live engine's own timer asks for, so the one beside CAF asks for it too.
constexpr ThreadSettings timer{SchedulingPolicy::fifo, 70, std::nullopt};

/// One row: a system under one policy, from one kind of sender.
struct Contestant {
  std::string from;     // where the sender is
  std::string threads;  // policy of the threads
  std::string system;
  std::function<void(HopMeter&)> run;
  std::vector<double> p50_us, p99_us;  // by round
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<Contestant> contestants(Duration duration) {
  std::vector<Contestant> all;
  for (const bool detached : {false, true}) {
    for (const ThreadSettings& threads : {other, fifo}) {
      const auto add = [&](const char* system, std::function<void(HopMeter&)> run) {
        all.push_back(
            {detached ? "own thread" : "pool", threads == fifo ? "fifo 50" : "other", system, std::move(run), {}, {}});
      };
      const auto add_caf = [&](const char* system, CafScheduler scheduler) {
        add(system, [=](HopMeter& m) { hop_by_caf(scheduler, detached, workers, threads, timer, duration, m); });
      };
      add("tactor", [=](HopMeter& m) { hop_by_live_run(detached, workers, threads, duration, m); });
      add_caf("CAF stealing", CafScheduler::stealing);
      add_caf("CAF sharing", CafScheduler::sharing);
      add_caf("CAF defaults", CafScheduler::defaults);
    }
  }
  return all;
}

void run_rounds(std::vector<Contestant>& all, int rounds) {
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      // A round begins at another place each time, so that no one always follows the same one.
      Contestant& c = all[(i + static_cast<std::size_t>(round)) % all.size()];
      HopMeter meter;
      c.run(meter);
      c.p50_us.push_back(meter.latency().quantile(0.5).microseconds());
      c.p99_us.push_back(meter.latency().quantile(0.99).microseconds());
    }
    fmt::print(stderr, "round {} of {}\n", round + 1, rounds);
  }
}

}  // namespace

int main(int count, char** arguments) {
  int rounds = 7;
  double seconds = 1;
  bool json = false;
  for (int i = 1; i < count; ++i) {
    const std::string argument = arguments[i];
    if (argument == "--json") {
      json = true;
    } else if (argument == "--rounds" && i + 1 < count) {
      rounds = std::atoi(arguments[++i]);
    } else if (argument == "--seconds" && i + 1 < count) {
      seconds = std::atof(arguments[++i]);
    } else {
      rounds = 0;
    }
  }
  if (rounds < 1 || seconds < 0.2) {
    fmt::print(stderr, "usage: hop_bench [--rounds N] [--seconds S] [--json], at least 1 round of 0.2 s\n");
    return 2;
  }
  // A live run locks memory; so does bare CAF here.
  const MemoryLock lock;
  std::vector<Contestant> all = contestants(Duration::from_seconds(seconds));
  run_rounds(all, rounds);

  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  double ours_p50 = 0, ours_p99 = 0;
  if (!json) {
    fmt::print("{:<11} {:<8} {:<13} {:>8} {:>8}   {:>16}\n", "sender in", "threads", "system", "p50 us", "p99 us",
               "tactor / CAF p50, p99");
  }
  for (const Contestant& c : all) {
    const double p50 = median(c.p50_us), p99 = median(c.p99_us);
    const bool ours = c.system == "tactor";
    if (ours) ours_p50 = p50, ours_p99 = p99;
    rows.push_back({{"from", c.from}, {"threads", c.threads}, {"system", c.system}, {"p50_us", p50}, {"p99_us", p99}});
    if (!ours) rows.back().update({{"ratio_p50", ours_p50 / p50}, {"ratio_p99", ours_p99 / p99}});
    if (json) continue;
    fmt::print("{:<11} {:<8} {:<13} {:>8.2f} {:>8.2f}   {}\n", c.from, c.threads, c.system, p50, p99,
               ours ? "" : fmt::format("{:>8.2f} {:>8.2f}", ours_p50 / p50, ours_p99 / p99));
  }
  if (json)
    fmt::print("{}\n", nlohmann::ordered_json{{"rounds", rounds}, {"seconds", seconds}, {"rows", rows}}.dump(2));
  return 0;
}
