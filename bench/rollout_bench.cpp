// What the local rollout costs: a tick of interpolation.rollout in its loop, and a result of prediction.local. Both
// forms of the rollout run side by side, tick by tick: on the contacts that come with the results, and on those that it
// finds on the surface.
//
// rollout_bench [--seconds S] [--contacts N] [--bunny FILE] [--json]
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "bench/cache_load.hpp"
#include "bench/rollout_course.hpp"
#include "framework/core/check.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "framework/realtime/latency_histogram.hpp"
#include "framework/realtime/memory_lock.hpp"
#include "framework/realtime/periodic_loop.hpp"
#include "nodes/interpolation/rollout.hpp"
#include "nodes/prediction/local.hpp"
#include "tests/support/nodes.hpp"

using namespace tactor;
using namespace tactor::bench;
using tactor::test::context_for;
using tactor::test::default_params;
using tactor::test::report_of;
using tactor::test::sent;

namespace {

constexpr double rate = 1000;           // Hz
constexpr int period = 20;              // ticks from result to result, each of which is as late
constexpr std::uint64_t warm_up = 100;  // ticks that are not counted

/// One form of the rollout, with the predictor that feeds it.
struct Form {
  Form(std::string form, const Course& course, const Rollout::Params& params)
      : name(std::move(form)),
        predictor(default_params<LocalPredictor>(), context_for(course.scene)),
        rollout(params, context_for(course.scene)) {
    predictor.bodies.configure({});
    predictor.contacts.configure({});
    predictor.state.configure({});
    predictor.coupling.configure({});
    predictor.device.configure({QueuePolicy::drop_oldest, 512});
    rollout.model.configure({});
    rollout.device.configure({QueuePolicy::drop_oldest, 64});
    predictor.coupling.push({}, &course.coupling);
  }

  void take(std::uint64_t n, Time now, const DeviceState& handle) {
    predictor.device.push({now, now, n}, &handle);
    rollout.device.push({now, now, n}, &handle);
  }
  void take(Time then, Time now, const PhysicsResult& physics) {
    predictor.state.push({then, now, results}, &physics.state);
    predictor.bodies.push({then, now, results}, &physics.bodies);
    predictor.contacts.push({then, now, results}, &physics.around);
    StepContext context(now);
    const Instant begin = MonotonicClock::now();
    predictor.step(context);
    result.record(MonotonicClock::now() - begin);
    ++results;
    if (predictor.model.pending() > 0) rollout.model.push({then, now, results}, &sent(predictor.model));
    predictor.model.clear_pending();
  }
  void step(std::uint64_t n, Time now) {
    StepContext context(now);
    const std::int64_t calls = thread_heap_calls(), faults = thread_page_faults();
    const Instant begin = MonotonicClock::now();
    rollout.step(context);
    const Duration took = MonotonicClock::now() - begin;
    if (n >= warm_up) {
      tick.record(took);
      heap_calls += thread_heap_calls() - calls;
      page_faults += thread_page_faults() - faults;
    }
    if (rollout.segment.pending() > 0) force += norm(sent(rollout.segment).c[0].force);
    rollout.segment.clear_pending();
  }

  std::string name;
  LocalPredictor predictor;
  Rollout rollout;
  LatencyHistogram tick, result;
  std::int64_t heap_calls = 0, page_faults = 0;
  std::uint64_t results = 0;
  double force = 0;  // kept, so that nothing is left out
};

using Forms = std::array<std::unique_ptr<Form>, 2>;

Forms forms_on(const Course& course) {
  Rollout::Params anchors = course.params;
  anchors.contacts = SurfaceOptions::From::anchors;
  anchors.restart = Rollout::Params::Restart::always;
  return {std::make_unique<Form>("anchors", course, anchors), std::make_unique<Form>("surface", course, course.params)};
}

void run(const Course& course, Duration duration, Forms& forms) {
  std::uint64_t tick_number = 0;
  PeriodicLoop loop({.name = "rollout",
                     .rate = rate,
                     .thread = {SchedulingPolicy::fifo, 80, static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN)) - 1}},
                    [&](const Tick&) {
                      const std::uint64_t n = tick_number++;
                      if (n / period >= course.results.size()) return;
                      const Time now{static_cast<std::int64_t>(n) * 1'000'000};
                      const DeviceState handle = course.handle(now.seconds());
                      // Each form is first in every other tick.
                      for (std::size_t k = 0; k < forms.size(); ++k) {
                        Form& form = *forms[(n + k) % forms.size()];
                        form.take(n, now, handle);
                        if (n >= 2 * period && n % period == 0) {
                          form.take(Time{now.ns - period * 1'000'000}, now, course.results[n / period - 1]);
                        }
                        form.step(n, now);
                      }
                    });
  loop.start(MonotonicClock::now() + Duration{10'000'000});
  MonotonicClock::sleep_until(MonotonicClock::now() + duration);
  TACTOR_DEMAND(loop.stop(Duration{1'000'000'000}));
  for (const auto& form : forms) TACTOR_DEMAND(form->force > 0);
}

double metric_of(const Rollout& node, const std::string& name) {
  const Report report = report_of(node);
  for (const auto& [key, value] : report.metrics()) {
    if (key == name) return value;
  }
  return 0;
}

nlohmann::ordered_json row(const Course& course, const Form& form, const char* what, const char* condition,
                           const LatencyHistogram& h) {
  return {{"scene", course.name},
          {"form", form.name},
          {"what", what},
          {"condition", condition},
          {"times", h.count()},
          {"p50_us", h.quantile(0.5).microseconds()},
          {"p99_us", h.quantile(0.99).microseconds()},
          {"max_us", h.max().microseconds()}};
}

void run_on(const Course& course, double seconds, nlohmann::ordered_json& rows) {
  for (const bool swept : {false, true}) {
    std::optional<CacheLoad> load;
    if (swept) load.emplace(static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN)) - 1);
    const char* condition = swept ? "1 kHz, caches swept" : "1 kHz, idle core";
    Forms forms = forms_on(course);
    run(course, Duration::from_seconds(seconds), forms);
    for (const auto& form : forms) {
      rows.push_back(row(course, *form, "tick", condition, form->tick));
      rows.back()["allocations"] = form->heap_calls;
      rows.back()["page_faults"] = form->page_faults;
      rows.back()["fallbacks"] = metric_of(form->rollout, "fallbacks");
      rows.back()["anchored_steps"] = metric_of(form->rollout, "rollout.anchored_steps");
      rows.push_back(row(course, *form, "result", condition, form->result));
    }
  }
}

nlohmann::ordered_json work_of(const Course& course) {
  std::vector<int> work = course.work;
  std::sort(work.begin(), work.end());
  const auto at = [&](double share) {
    return work[static_cast<std::size_t>(share * static_cast<double>(work.size() - 1))];
  };
  return {{"scene", course.name}, {"contacts", course.contacts}, {"p50", at(0.5)},
          {"p99", at(0.99)},      {"max", work.back()},          {"most_work", course.params.most_work}};
}

}  // namespace

int main(int count, char** arguments) {
  double seconds = 10;
  int contacts = 24;
  bool json = false;
  std::filesystem::path bunny = std::filesystem::path(TACTOR_BINARY_DIR) / "meshes/bunny.off";
  for (int i = 1; i < count; ++i) {
    const std::string argument = arguments[i];
    if (argument == "--json") {
      json = true;
    } else if (argument == "--seconds" && i + 1 < count) {
      seconds = std::atof(arguments[++i]);
    } else if (argument == "--contacts" && i + 1 < count) {
      contacts = std::atoi(arguments[++i]);
    } else if (argument == "--bunny" && i + 1 < count) {
      bunny = arguments[++i];
    } else {
      seconds = 0;
    }
  }
  if (!(seconds >= 1 && seconds <= 12) || contacts < 1 || contacts > LocalContacts::capacity) {
    fmt::print(
        stderr,
        "usage: rollout_bench [--seconds S] [--contacts N] [--bunny FILE] [--json], 1 to 12 s, 1 to {} contacts\n",
        LocalContacts::capacity);
    return 2;
  }
  try {
    std::vector<Course> courses{ring_course(seconds, contacts)};
    if (std::filesystem::exists(bunny)) {
      courses.push_back(
          bunny_course(seconds, bunny, std::filesystem::path(TACTOR_SOURCE_DIR) / "graphs/trajectories/bunny.csv"));
    } else {
      fmt::print(stderr, "{} is not there: without the two bunnies\n", bunny.string());
    }
    // Just within the work that a query may do, and beyond.
    for (const double spacing : {0.0018, 0.001}) courses.push_back(dense_course(seconds, contacts, spacing));
    const MemoryLock lock;
    if (!lock.locked()) fmt::print(stderr, "the memory is not locked: {}\n", lock.refused()->why);
    nlohmann::ordered_json rows = nlohmann::ordered_json::array(), work = nlohmann::ordered_json::array();
    for (const Course& course : courses) {
      run_on(course, seconds, rows);
      work.push_back(work_of(course));
    }
    if (json) {
      fmt::print(
          "{}\n",
          nlohmann::ordered_json{
              {"seconds", seconds}, {"contacts", contacts}, {"period_ticks", period}, {"rows", rows}, {"work", work}}
              .dump(2));
      return 0;
    }
    for (const auto& r : rows) {
      fmt::print("{:<12} {:<8} {:<7} {:<20} {:>6} times, p50 {:>7.1f}, p99 {:>7.1f}, max {:>7.1f} us",
                 r["scene"].get<std::string>(), r["form"].get<std::string>(), r["what"].get<std::string>(),
                 r["condition"].get<std::string>(), r["times"].get<std::uint64_t>(), r["p50_us"].get<double>(),
                 r["p99_us"].get<double>(), r["max_us"].get<double>());
      if (r.contains("allocations")) {
        fmt::print(", {} allocations, {} faults, {} fallbacks, {} anchored", r["allocations"].get<std::int64_t>(),
                   r["page_faults"].get<std::int64_t>(), r["fallbacks"].get<double>(),
                   r["anchored_steps"].get<double>());
      }
      fmt::print("\n");
    }
    for (const auto& w : work) {
      fmt::print("{:<12} a query finds {:.1f} contacts with work of p50 {}, p99 {}, max {}, of {}\n",
                 w["scene"].get<std::string>(), w["contacts"].get<double>(), w["p50"].get<int>(), w["p99"].get<int>(),
                 w["max"].get<int>(), w["most_work"].get<int>());
    }
  } catch (const InputError& error) {
    fmt::print(stderr, "rollout_bench: {}\n", error.what());
    return 1;
  }
  return 0;
}
