// What the local rollout costs: a tick of interpolation.rollout in its loop, and a result of prediction.local.
//
// rollout_bench [--seconds S] [--contacts N] [--json]
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>

#include "bench/cache_load.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "framework/realtime/latency_histogram.hpp"
#include "framework/realtime/memory_lock.hpp"
#include "framework/realtime/periodic_loop.hpp"
#include "nodes/interpolation/rollout.hpp"
#include "nodes/physics/contact/local_contacts.hpp"
#include "nodes/prediction/local.hpp"
#include "tests/nodes/defaults.hpp"

using namespace tactor;
using namespace tactor::bench;
using tactor::test::context_for;
using tactor::test::default_params;
using tactor::test::sent;

namespace {

constexpr double rate = 1000;          // Hz
constexpr int period = 20;             // ticks from result to result, each of which is as late
constexpr double pressed = 2e-4;       // m, depth of the tool in the surface
constexpr double bowl = 0.05;          // m, radius of the surface
constexpr double ring = 0.008;         // m, radius of the ring of contacts under the tool
constexpr double anchor_time = 0.015;  // s

/// A handle that slides to and fro over a bowl with some tremor, 1 mm deeper than the tool.
DeviceState handle_at(double t) {
  const double w = 2 * std::numbers::pi * 2, u = 2 * std::numbers::pi * 10;
  DeviceState s;
  s.X_WD.p = {5e-3 * std::sin(w * t), 0, -1e-3 + 5e-5 * std::sin(u * t)};
  s.V_WD.v = {5e-3 * w * std::cos(w * t), 0, 5e-5 * u * std::cos(u * t)};
  return s;
}

Scene scene_of_the_tool() {
  Body tool{.name = "tool", .shape = BoxShape{{0.02, 0.02, 0.02}}};
  tool.motion = Motion::rigid;
  return Scene{.bodies = {tool}};
}

BodyStates tool_at(double t) {
  const DeviceState handle = handle_at(t);
  BodyStates bodies;
  bodies.count = 1;
  bodies.X_WB[0].p = {handle.X_WD.p.x, 0, 0};
  bodies.V_WB[0].v = {handle.V_WD.v.x, 0, 0};
  return bodies;
}

/// A ring of contacts, all of which touch and slide, looked up at three anchors.
LocalContacts contacts_at(double t, int count) {
  LocalContacts local;
  local.anchors = LocalContacts::max_anchors;
  local.bodies = 1;
  local.count = count;
  for (std::size_t j = 0; j < LocalContacts::max_anchors; ++j) {
    Pose X_WT = tool_at(t).X_WB[0];
    X_WT.p += static_cast<double>(j) * anchor_time * tool_at(t).V_WB[0].v;
    local.X_WB[j][0] = X_WT;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(i) / count;
      Contact& c = local.contact[i][j];
      c.p_TC = {ring * std::cos(angle), ring * std::sin(angle), -0.01};
      // The bowl is the same wherever the tool slides: what is timed is the arithmetic.
      const Vec3 lean{-c.p_TC.x / bowl, -c.p_TC.y / bowl, 1};
      c.n_W = (1 / norm(lean)) * lean;
      c.distance = -pressed;
      c.p_WC = transform(X_WT, c.p_TC) + pressed * c.n_W;
      c.weight = 8.0 / count;
      c.stiffness = 2000;
      c.damping = 2;
      c.friction = 0.3;
      c.H_W = {1 / bowl, 0, 0, 1 / bowl, 0, 0};
    }
  }
  return local;
}

/// What physics would feel of these contacts at their first anchor, where all of them slide.
PhysicsState felt_at(double t, const LocalContacts& local) {
  PhysicsState state;
  state.X_WT = tool_at(t).X_WB[0];
  state.V_WT = tool_at(t).V_WB[0];
  state.contacts = local.count;
  const Vec3 v = state.V_WT.v;
  for (std::size_t i = 0; i < static_cast<std::size_t>(local.count); ++i) {
    const Contact& c = local.contact[i][0];
    const double N = std::max(0.0, -c.weight * (c.stiffness * c.distance + c.damping * dot(c.n_W, v)));
    const Vec3 sliding = v - dot(c.n_W, v) * c.n_W;
    const double speed = norm(sliding);
    const Vec3 force = N * c.n_W - (speed > 0 ? c.friction * N / speed : 0) * sliding;
    state.contact_T_W.force += force;
    state.contact_T_W.torque += cross(rotate(state.X_WT.R, c.p_TC), force);
  }
  return state;
}

struct Times {
  LatencyHistogram tick, result;
  std::int64_t heap_calls = 0;
  double force = 0;  // kept, so that nothing is left out
};

void run(int contacts, Duration duration, Times& times) {
  const Scene scene = scene_of_the_tool();
  LocalPredictor predictor(default_params<LocalPredictor>(), context_for(scene));
  Rollout rollout(default_params<Rollout>(), context_for(scene));
  predictor.bodies.configure({});
  predictor.contacts.configure({});
  predictor.state.configure({});
  predictor.coupling.configure({});
  predictor.device.configure({QueuePolicy::drop_oldest, 512});
  rollout.model.configure({});
  rollout.device.configure({QueuePolicy::drop_oldest, 64});
  const CouplingParameters coupling{.k_t = 500, .b_t = 14, .k_r = 1, .b_r = 0.01, .force_max = 8, .torque_max = 0.3};
  predictor.coupling.push({}, &coupling);
  std::uint64_t tick_number = 0, results = 0;
  PeriodicLoop loop({.name = "rollout",
                     .rate = rate,
                     .thread = {SchedulingPolicy::fifo, 80, static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN)) - 1}},
                    [&](const Tick&) {
                      const std::uint64_t n = tick_number++;
                      const Time now{static_cast<std::int64_t>(n) * 1'000'000};
                      const DeviceState handle = handle_at(now.seconds());
                      predictor.device.push({now, now, n}, &handle);
                      rollout.device.push({now, now, n}, &handle);
                      StepContext context(now);
                      if (n >= 2 * period && n % period == 0) {
                        const Time then{now.ns - period * 1'000'000};
                        const BodyStates bodies = tool_at(then.seconds());
                        const LocalContacts around = contacts_at(then.seconds(), contacts);
                        const PhysicsState felt = felt_at(then.seconds(), around);
                        predictor.state.push({then, now, results}, &felt);
                        predictor.bodies.push({then, now, results}, &bodies);
                        predictor.contacts.push({then, now, results}, &around);
                        const Instant begin = MonotonicClock::now();
                        predictor.step(context);
                        times.result.record(MonotonicClock::now() - begin);
                        rollout.model.push({then, now, results++}, &sent(predictor.model));
                        predictor.model.clear_pending();
                      }
                      const std::int64_t before = thread_heap_calls();
                      const Instant begin = MonotonicClock::now();
                      rollout.step(context);
                      times.tick.record(MonotonicClock::now() - begin);
                      times.heap_calls += thread_heap_calls() - before;
                      if (rollout.segment.pending() > 0) times.force += norm(sent(rollout.segment).c[0].force);
                      rollout.segment.clear_pending();
                    });
  loop.start(MonotonicClock::now() + Duration{10'000'000});
  MonotonicClock::sleep_until(MonotonicClock::now() + duration);
  TACTOR_DEMAND(loop.stop(Duration{1'000'000'000}));
  TACTOR_DEMAND(times.force > 0);
}

nlohmann::ordered_json row(const char* what, const char* condition, const LatencyHistogram& h) {
  return {{"what", what},
          {"condition", condition},
          {"times", h.count()},
          {"p50_us", h.quantile(0.5).microseconds()},
          {"p99_us", h.quantile(0.99).microseconds()},
          {"max_us", h.max().microseconds()}};
}

}  // namespace

int main(int count, char** arguments) {
  double seconds = 10;
  int contacts = 24;
  bool json = false;
  for (int i = 1; i < count; ++i) {
    const std::string argument = arguments[i];
    if (argument == "--json") {
      json = true;
    } else if (argument == "--seconds" && i + 1 < count) {
      seconds = std::atof(arguments[++i]);
    } else if (argument == "--contacts" && i + 1 < count) {
      contacts = std::atoi(arguments[++i]);
    } else {
      seconds = 0;
    }
  }
  if (!(seconds >= 1) || contacts < 1 || contacts > LocalContacts::capacity) {
    fmt::print(stderr, "usage: rollout_bench [--seconds S] [--contacts N] [--json], at least 1 s, 1 to {} contacts\n",
               LocalContacts::capacity);
    return 2;
  }
  const MemoryLock lock;
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const bool swept : {false, true}) {
    std::optional<CacheLoad> load;
    if (swept) load.emplace(static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN)) - 1);
    const char* condition = swept ? "1 kHz, caches swept" : "1 kHz, idle core";
    Times times;
    run(contacts, Duration::from_seconds(seconds), times);
    rows.push_back(row("tick", condition, times.tick));
    rows.back()["allocations"] = times.heap_calls;
    rows.push_back(row("result", condition, times.result));
  }
  if (json) {
    fmt::print(
        "{}\n",
        nlohmann::ordered_json{{"seconds", seconds}, {"contacts", contacts}, {"period_ticks", period}, {"rows", rows}}
            .dump(2));
    return 0;
  }
  for (const auto& r : rows) {
    fmt::print("{:<8} {:<20} {:>8} times, p50 {:>8.2f}, p99 {:>8.2f}, max {:>8.2f} us\n", r["what"].get<std::string>(),
               r["condition"].get<std::string>(), r["times"].get<std::uint64_t>(), r["p50_us"].get<double>(),
               r["p99_us"].get<double>(), r["max_us"].get<double>());
  }
  return 0;
}
