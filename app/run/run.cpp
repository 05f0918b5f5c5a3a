#include "app/run/run.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>

#include "app/run/experiment.hpp"
#include "app/run/live.hpp"
#include "app/run/record.hpp"
#include "app/run/recorded_reference.hpp"
#include "app/run/references.hpp"
#include "app/run/sha256.hpp"
#include "framework/core/clock.hpp"
#include "framework/core/shell_word.hpp"
#include "framework/graph/plan_metrics.hpp"
#include "framework/graph/texts.hpp"
#include "framework/realtime/flight_file.hpp"
#include "framework/record/recorder.hpp"
#include "framework/session/session.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// How long a follower may take, at the end of a run, for what it has not followed yet.
constexpr Duration follower_patience{1'000'000'000};

double peak_memory_MB() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

/// When the nodes are made, so that their libraries are loaded, and before anything is written, because it may refuse a
/// file.
Provenance provenance_of_run(const Plan& plan, const RunOptions& options) {
  if (!options.provenance) return {};
  if (options.recording && !plan.streams.empty()) static_cast<void>(load_record_library());
  Provenance made = provenance_of(plan, options.cache_folder);
  if (options.reference_recording) {
    made.files.push_back({std::string(reference_option), fs::absolute(*options.reference_recording),
                          sha256_of_file(*options.reference_recording)});
  }
  return made;
}

/// Begins to write, where that is asked for: where the run is recorded, with a stream for each of the plan's, by the
/// same index; null where nothing is.
std::unique_ptr<Recorder> make_recorder(const Plan& plan, const RunOptions& options, const RunResult& result) {
  if (options.before_writing) options.before_writing();
  if (!options.recording || plan.streams.empty()) return nullptr;
  return load_record_library().create(
      *options.recording, {result.graph_yaml, plan.graph.seed, TACTOR_VERSION, provenance_text(result.provenance)});
}

NodeCost node_cost(const NodeSpec& spec, const NodeStatistics& metrics) {
  NodeCost cost;
  cost.node = spec.name;
  cost.type = spec.info->type;
  cost.role = spec.info->role;
  cost.steps = metrics.steps;
  cost.missed_ticks = metrics.missed_ticks;
  cost.median_us = metrics.cpu.quantile(0.5).microseconds();
  cost.p99_us = metrics.cpu.quantile(0.99).microseconds();
  if (const std::uint64_t measured = metrics.cpu.count(); measured > 0) {
    // A live pool measures some of its steps, which stand for all.
    cost.total_s = metrics.cpu_total.seconds() * static_cast<double>(std::max(cost.steps, measured)) /
                   static_cast<double>(measured);
  }
  return cost;
}

/// The recording that judges the run, else its reference run or the one in the cache; none where no sink asks for one.
/// Sets `interrupted`, and throws RunError, where it is told not to go on.
std::optional<Reference> find_reference(const Plan& referred, const Plan& reference_plan, const RunOptions& options,
                                        const PlanNodes& nodes, RunResult& result) {
  if (reference_plan.nodes.empty()) return std::nullopt;
  const auto go_on = [&options, &result](double share) {
    result.reference_interrupted = options.progress && !options.progress(share, "reference run");
    return !result.reference_interrupted;
  };
  ReferenceUse& use = result.reference;
  use.made = true;
  const double cpu = clock_seconds(CLOCK_THREAD_CPUTIME_ID);
  std::optional<Reference> reference =
      must_be_followed(nodes) ? run_reference(reference_plan, &nodes, go_on)
                              : cached_reference(referred, {options.cache_folder, go_on, options.note}, &use.cached);
  use.cpu_s = clock_seconds(CLOCK_THREAD_CPUTIME_ID) - cpu;
  return reference;
}

/// Gives the nodes what judges the run, where that is finer than the run.
void give_reference(const Plan& plan, const RunOptions& options, const std::optional<Reference>& recorded,
                    PlanNodes& nodes, RunResult& result) {
  const Plan& referred = options.reference != nullptr ? *options.reference : plan;
  const Plan reference_plan = recorded ? Plan{} : make_reference_plan(referred);
  const std::optional<Reference> reference =
      recorded ? recorded : find_reference(referred, reference_plan, options, nodes, result);
  if (!reference) return;
  const ReferenceRate rate =
      rate_of(*reference, recorded ? nullptr : &reference_plan, plan, Duration::from_seconds(result.duration_s),
              [&](std::size_t edge) { return result.edges[edge].metrics.delivered; });
  result.reference.rate_hz = rate.hz;
  result.reference.too_coarse = rate.too_coarse;
  if (rate.too_coarse.empty()) set_reference(nodes, *reference);
}

/// Does what may fail while running; the first failure is the run's, which keeps what it has up to there.
template <class Work>
void attempt(RunResult& result, const Work& work) {
  try {
    work();
  } catch (const RunError& error) {
    if (!result.failure) result.failure = error.what();
  }
}

/// From when on the run is judged. Throws RunError where its nodes are not warm when the options ask for it.
Time judged_from(const Warmth& warmth, const RunOptions& options) {
  if (options.judge_whole) return {};
  if (!options.judge_from) return warmth.since.value_or(Time{});
  if (warmth.since && *warmth.since <= *options.judge_from) return *options.judge_from;
  throw RunError(fmt::format("node {} is not warm at {} s, where the metrics begin: {}", warmth.last,
                             options.judge_from->seconds(), warmth.when));
}

/// What the nodes report, where they can be asked, and the metrics of nodes and edges.
void judge(const Plan& plan, const RunOptions& options, const std::optional<Reference>& recorded, PlanNodes* nodes,
           RunResult& result) {
  if (nodes != nullptr && !result.interrupted && !result.failure && !options.without_reference) {
    try {
      give_reference(plan, options, recorded, *nodes, result);
    } catch (const RunError& error) {
      // The run itself is over and keeps its metrics; those against the reference are left out.
      if (!result.reference_interrupted) result.failure = error.what();
    }
  }
  Report report;
  if (nodes != nullptr) {
    result.warmth = warmth_of(*nodes);
    attempt(result, [&] { result.judged_from = judged_from(result.warmth, options); });
  }
  report.judge_from(result.judged_from);
  report.begin("", program_metrics());
  if (result.warmth.since) report.set("warm_from_s", result.warmth.since->seconds());
  if (result.reference.rate_hz > 0) report.set("reference.rate_hz", result.reference.rate_hz);
  if (const std::string& why = result.reference.too_coarse; !why.empty())
    report.remark(why + "; so there are no errors");
  report.set("refits", 0);
  report.add("fallbacks", 0);
  for (std::size_t i = 0; nodes != nullptr && i < plan.nodes.size(); ++i) {
    attempt(result, [&] {
      report.ask((*nodes)[i], plan.nodes[i].name, node_metrics(plan, i, !options.without_reference).reported);
    });
  }
  if (result.live) report_live(plan, *result.live, result.record_dropped, report);
  if (result.follower) report_follower(*result.follower, report);
  double drops = 0;
  for (const EdgeResult& edge : result.edges) drops += static_cast<double>(edge.metrics.dropped);
  report.begin("", program_metrics());
  report.set("drops", drops);
  result.metrics = report.metrics();
  result.series = report.series();
  result.remarks = report.remarks();
  if (nodes == nullptr) return;
  std::vector<EdgeStatistics> carried;
  for (const EdgeResult& edge : result.edges) carried.push_back(edge.metrics);
  std::vector<std::uint64_t> steps;
  for (const NodeCost& node : result.nodes) steps.push_back(node.steps);
  result.no_force = devices_without_force(*nodes, carried, steps, result.metric("contacts.max") != 0);
}

void pass_notes(const PlanNodes& nodes, const RunOptions& options) {
  for (const std::string& note : nodes.notes()) {
    if (options.note) options.note(note);
  }
}

/// What each node and edge did.
void add_statistics(Session& session, RunResult& result) {
  const Plan& plan = session.plan();
  for (std::size_t i = 0; i < plan.nodes.size(); ++i) {
    result.nodes.push_back(node_cost(plan.nodes[i], session.node_statistics(i)));
    result.nodes.back().step_times = session.step_times(i);
  }
  for (std::size_t i = 0; i < plan.edges.size(); ++i) {
    const EdgeSpec& edge = plan.edges[i].spec;
    result.edges.push_back({edge.name(), queue_text(edge.queue), session.edge_statistics(i)});
  }
}

/// The watcher of a run, where there is one, from its begin to its end.
class Watched {
 public:
  Watched(RunWatcher* watcher, Session& session, Follower* follower, const RunResult& result)
      : watcher_(watcher), result_(result) {
    if (watcher_ != nullptr) watcher_->begin(session, follower);
  }
  Watched(const Watched&) = delete;
  Watched& operator=(const Watched&) = delete;
  ~Watched() {
    if (watcher_ != nullptr) watcher_->end(result_.failure || std::uncaught_exceptions() > 0);
  }
  void attend() {
    if (watcher_ != nullptr) watcher_->attend();
  }

 private:
  RunWatcher* watcher_;
  const RunResult& result_;
};

/// Follows a session where the options ask for it. Ended before the session.
class Traced {
 public:
  Traced(Session& session, const RunOptions& options) {
    if (options.traces) tracer_.emplace(session);
  }
  void attend() {
    if (tracer_) tracer_->attend();
  }
  void finish(RunResult& result) {
    if (!tracer_) return;
    tracer_->attend();
    result.trace = tracer_->trace();
    tracer_.reset();
  }

 private:
  std::optional<RunTracer> tracer_;
};

/// Asks ten times a second of wall time whether the run is to go on, by what the options have for its clock.
class Question {
 public:
  Question(Session& session, const Follower* follower, const RunOptions& options)
      : session_(session), options_(options) {
    if (session.plan().graph.clock == Clock::real && options.live_progress) watch_.emplace(session, follower);
  }
  /// An exception of the question is the run's failure.
  void attend(RunResult& result) {
    const double wall = clock_seconds(CLOCK_MONOTONIC);
    if (wall - asked_ < 0.1 || !session_.is_running()) return;
    asked_ = wall;
    try {
      result.interrupted = !goes_on();
    } catch (const std::exception& error) {
      result.failure = error.what();
    }
    if (result.interrupted || result.failure) session_.stop();
  }

 private:
  bool goes_on() {
    if (watch_) return options_.live_progress(watch_->look());
    const double planned = session_.plan().graph.duration.seconds();
    return !options_.progress || options_.progress(session_.now().seconds() / planned, "run");
  }

  Session& session_;
  const RunOptions& options_;
  std::optional<LiveWatch> watch_;
  double asked_ = clock_seconds(CLOCK_MONOTONIC);
};

void add_devices(const EngineStatus& status, RunResult& result) {
  for (const DeviceStatus& device : status.devices) {
    NodeCost& cost = result.nodes[device.node];
    cost.steps = device.ticks;
    cost.missed_ticks = device.missed;
    cost.median_us = device.body_time.p50.microseconds();
    cost.p99_us = device.body_time.p99.microseconds();
    cost.total_s = device.body_sum.seconds();
  }
}

/// Starts, or throws. Then nothing has run, because of a device that is not there, say: no recording without a message
/// stays behind.
void start(Session& session, std::unique_ptr<Recorder>& recorder, const RunOptions& options) {
  try {
    session.start();
  } catch (...) {
    if (recorder) {
      recorder.reset();
      std::error_code ignored;
      fs::remove(*options.recording, ignored);
    }
    throw;
  }
}

/// Runs a session to its end, by `drive` where that is not empty; between its slices watcher, trace and progress have
/// their turn.
void run_to_end(Session& session, const std::function<void()>& drive, Follower* follower,
                std::unique_ptr<Recorder>& recorder, Traced& traced, const RunOptions& options, RunResult& result) {
  const Duration slice{drive ? 0 : 20'000'000};
  Watched watched(options.watcher, session, follower, result);
  Question question(session, follower, options);
  if (follower != nullptr) follower->start();
  session.stop_when(options.stop_asked);
  start(session, recorder, options);
  attempt(result, [&] {
    session.run(slice, [&] {
      if (drive) drive();
      traced.attend();
      watched.attend();
      question.attend(result);
    });
  });
  // A run until stopped that is stopped has come to its end.
  const bool ends_itself = session.plan().graph.duration != until_stopped;
  result.interrupted = ends_itself && (result.interrupted || options.stop_asked());
  if (!result.failure) result.failure = session.failure();
}

/// Keeps the file of the flight recorder where that is worth a look: where it is now, in words; else empty.
std::string keep_flight(Session& session, const RunOptions& options, RunResult& result) {
  FlightFile* const flight = session.flight();
  if (flight == nullptr || !flight->is_to_stay()) return {};
  if (options.flight) attempt(result, [&] { flight->move_to(*options.flight); });
  const std::string text =
      "the flight recorder kept its last minute; see: tactor flight " + as_typed(flight->path().string());
  if (result.failure && options.note) options.note(text);
  return text;
}

void execute(const Plan& plan, const RunOptions& options, const std::optional<Reference>& recorded, RunResult& result) {
  Session session(plan, {.engine = {.measure_cpu = true,
                                    .keeps_step_times = options.keeps_step_times,
                                    .pace = options.watcher != nullptr ? 1.0 : 0.0,
                                    .without_dead_man = options.without_dead_man},
                         .keeps_tables = options.keeps_tables});
  pass_notes(session.nodes(), options);
  // Both may be refused, so that nothing has been written yet.
  const std::function<void()> drive = options.driver ? options.driver(session) : nullptr;
  std::unique_ptr<Follower> follower;
  if (options.follow != nullptr) follower = std::make_unique<Follower>(session, *options.follow);
  result.provenance = provenance_of_run(plan, options);
  std::unique_ptr<Recorder> recorder = make_recorder(plan, options, result);
  const auto recorder_failed = recorder ? record(session, *recorder) : std::make_shared<bool>(false);
  if (options.before_start) options.before_start(session);
  Traced traced(session, options);
  const Duration cpu = session.cpu_time();
  const double wall = clock_seconds(CLOCK_MONOTONIC);
  run_to_end(session, drive, follower.get(), recorder, traced, options, result);
  const std::string flight = keep_flight(session, options, result);
  result.cpu_s = (session.cpu_time() - cpu).seconds();
  result.wall_s = clock_seconds(CLOCK_MONOTONIC) - wall;
  // A recording that has failed is left as the last flush has it.
  if (recorder && !*recorder_failed) attempt(result, [&] { recorder->close(); });
  if (follower) {
    follower->finish(follower_patience);
    result.follower = follower->figures();
  }
  traced.finish(result);
  follower.reset();
  result.abandoned = session.is_abandoned();
  const EngineStatus status = session.status();
  if (plan.graph.clock == Clock::real) result.live = status;
  result.record_dropped = session.dropped();
  // A run may be ended before its time zero.
  result.duration_s = std::clamp(status.now, Time{}, Time{} + plan.graph.duration).seconds();
  add_statistics(session, result);
  add_devices(status, result);
  // The nodes of an abandoned run cannot be asked: one of them is still at work.
  judge(plan, options, recorded, result.abandoned ? nullptr : &session.nodes(), result);
  if (!flight.empty()) result.remarks.push_back(flight);
}

}  // namespace

bool RunResult::force_was_withheld() const {
  const auto withheld = std::count_if(no_force.begin(), no_force.end(), std::mem_fn(&NoForce::was_withheld));
  return withheld > 0 && static_cast<std::size_t>(withheld) == devices;
}

double RunResult::metric(std::string_view name) const {
  for (const auto& [key, value] : metrics) {
    if (key == name) return value;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

const MetricInfo* RunResult::info(std::string_view name) const {
  const auto found = declared.find(name);
  return found == declared.end() ? nullptr : &found->second;
}

const Series* RunResult::curve(std::string_view name) const {
  for (const Series& s : series) {
    if (s.name == name) return &s;
  }
  return nullptr;
}

std::string first_difference(const RunResult& a, const RunResult& b) {
  if (a.metrics.size() != b.metrics.size()) return "the number of metrics";
  for (std::size_t i = 0; i < a.metrics.size(); ++i) {
    const auto& [name, value] = a.metrics[i];
    const bool same = value == b.metrics[i].second || (std::isnan(value) && std::isnan(b.metrics[i].second));
    if (name != b.metrics[i].first || !same) return name;
  }
  return {};
}

RunResult execute(const Plan& plan, const RunOptions& options) {
  if (plan.graph.duration == until_stopped && !options.without_reference) {
    RunOptions alone = options;
    alone.without_reference = true;
    return execute(plan, alone);
  }
  RunResult result;
  result.graph = plan.graph.name;
  result.title = plan.graph.title;
  result.seed = plan.graph.seed;
  result.chosen = plan.chosen;
  result.left_out = plan.left_out;
  result.graph_yaml = to_yaml(plan.graph);
  result.blind = experiment_of(plan).has_value();
  result.devices = static_cast<std::size_t>(
      std::count_if(plan.nodes.begin(), plan.nodes.end(), [](const NodeSpec& node) { return node.info->actuator; }));
  const bool ends_itself = plan.graph.duration != until_stopped;
  result.planned_s = ends_itself ? plan.graph.duration.seconds() : std::numeric_limits<double>::infinity();
  // A recording that cannot judge the run is bad input, which is said before it begins. It judges no live run.
  std::optional<Reference> recorded;
  if (options.reference_recording) recorded = recorded_reference(*options.reference_recording, plan);
  result.declared = run_metrics(plan, !options.without_reference, options.follow != nullptr).reported;
  execute(plan, options, recorded, result);
  result.peak_memory_MB = peak_memory_MB();
  return result;
}

}  // namespace tactor
