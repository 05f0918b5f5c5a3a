// One run of a planned graph with its reference run: what `tactor run` and the engine of studies are made of.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/run/live_look.hpp"
#include "app/run/no_force.hpp"
#include "app/run/provenance.hpp"
#include "app/run/run_metrics.hpp"
#include "app/run/run_trace.hpp"
#include "framework/engine/engine_status.hpp"
#include "framework/engine/plan_nodes.hpp"
#include "framework/engine/reference.hpp"
#include "framework/engine/warmth.hpp"
#include "framework/graph/plan.hpp"
#include "framework/session/follower.hpp"

namespace tactor {

/// CPU time a node's steps took.
struct NodeCost {
  std::string node;
  std::string type;
  Role role = Role::other;
  std::uint64_t steps = 0;
  std::uint64_t missed_ticks = 0;
  double median_us = 0;
  double p99_us = 0;
  double total_s = 0;
  std::vector<Duration> step_times;  ///< of each step, where the options keep them (see Session::step_times)
};

struct EdgeResult {
  std::string edge;
  std::string queue;
  EdgeStatistics metrics;
};

/// How the reference came about.
struct ReferenceUse {
  bool made = false;  ///< the graph has a sink that asked for one
  bool cached = false;
  double cpu_s = 0;
  double rate_hz = 0;      ///< how often the truth is known a second; 0: there is none
  std::string too_coarse;  ///< why it judges nothing (see ReferenceRate), else empty
};

/// A finished run.
struct RunResult {
  std::string graph;
  std::string title;
  std::uint64_t seed = 0;
  double duration_s = 0;  ///< time of the graph's clock that was run
  double planned_s = 0;   ///< and that the graph asked for; infinite: until it is stopped
  double wall_s = 0;      ///< of the run alone, without its reference
  double cpu_s = 0;
  double peak_memory_MB = 0;                ///< of the process so far
  bool interrupted = false;                 ///< before planned_s
  bool reference_interrupted = false;       ///< the run is whole, but lacks the metrics against its reference run
  std::optional<std::string> failure;       ///< why it ended before its time, where it did
  bool abandoned = false;                   ///< a step never came back: the process must end without cleaning up
  std::optional<EngineStatus> live;         ///< how it ended, where its clock was real
  std::optional<FollowerFigures> follower;  ///< of the reference that followed it, where one did
  std::uint64_t record_dropped = 0;         ///< messages that the recording could not take in time
  ReferenceUse reference;
  Warmth warmth;     ///< of its nodes
  Time judged_from;  ///< what the metrics leave out before `settle`: until all nodes were warm, or what the options say
  std::vector<std::pair<std::string, double>> metrics;  ///< by dotted name
  MetricMap declared;                                   ///< what the run may report, reported or not
  std::vector<Series> series;
  RunTrace trace;                    ///< empty unless the options ask for it
  std::vector<std::string> remarks;  ///< of the nodes, in words
  std::vector<NodeCost> nodes;
  std::vector<EdgeResult> edges;
  std::vector<Chosen> chosen;
  std::vector<LeftOut> left_out;
  std::string graph_yaml;         ///< resolved
  std::size_t devices = 0;        ///< how many the plan has
  std::vector<NoForce> no_force;  ///< the devices that no force of the pipeline reached, and why
  Provenance provenance;          ///< empty unless the options ask for it
  bool blind = false;             ///< it led a person through an experiment (see experiment_of)

  /// True where something kept the force from every device: then there is nothing to be judged.
  [[nodiscard]] bool force_was_withheld() const;
  /// The metric of that name, or NaN.
  [[nodiscard]] double metric(std::string_view name) const;
  /// The declaration of a metric, or null.
  [[nodiscard]] const MetricInfo* info(std::string_view name) const;
  /// The curve of that name, or null.
  [[nodiscard]] const Series* curve(std::string_view name) const;
};

/// The name of a metric in which two runs differ; empty where there is none.
std::string first_difference(const RunResult& a, const RunResult& b);

/// Looks at a run while it goes on, on its thread.
class RunWatcher {
 public:
  virtual ~RunWatcher() = default;
  /// Before the session starts; `follower` is null where none follows.
  virtual void begin(Session& session, Follower* follower) = 0;
  /// About fifty times a second while it runs.
  virtual void attend() = 0;
  /// The session has ended, or has failed to start; nothing of it is used afterwards. `failed`: not as it should.
  virtual void end(bool failed) = 0;
};

struct RunOptions {
  std::optional<std::filesystem::path> recording;  ///< where to record what the graph asks for; absent: nowhere
  /// Where to keep the file of the flight recorder, where there is one that is to stay; absent: where it is.
  std::optional<std::filesystem::path> flight;
  std::filesystem::path cache_folder;
  /// The plan whose reference run judges this one, with the same sinks; null: the plan itself.
  const Plan* reference = nullptr;
  /// A recording that judges the run instead of a reference run (see recorded_reference); absent: a reference run does.
  std::optional<std::filesystem::path> reference_recording;
  /// From when on the run is judged, as find_warmth has it for all runs that it is compared with; a run that is not
  /// warm by then fails. Absent: from when its own nodes are warm, or all of it where one of them never is.
  std::optional<Time> judge_from;
  bool judge_whole = false;  ///< the run is judged from its start, warm or not
  /// No reference run: the metrics that need one are left out. As in every run until stopped.
  bool without_reference = false;
  bool traces = false;            ///< the result has what a page shows of its devices
  bool provenance = false;        ///< result and recording tell when, where and from what they were made
  bool keeps_step_times = false;  ///< the result has what each step took
  bool keeps_tables = false;      ///< nodes may write files of their own (see SessionOptions)
  Ask without_dead_man;           ///< see EngineOptions::without_dead_man
  /// Called before the run for each thing that the nodes say of their input and that nothing stops for.
  std::function<void(const std::string& note)> note;
  /// Called once before anything is written, when nothing of the input can be refused any more.
  std::function<void()> before_writing;
  /// Called a few times a second with the share done in [0, 1] and what is being done; false interrupts.
  std::function<bool(double share, const char* what)> progress;
  /// The same for a run whose clock is real.
  std::function<bool(const LiveLook&)> live_progress;
  /// Not null: a reference follows a run whose clock is real, and its figures are metrics. Its nodes come from here.
  Registry* follow = nullptr;
  /// Not null: looks at the run, which under the virtual clock then takes as long as it lasts.
  RunWatcher* watcher = nullptr;
  /// Not empty: makes, before the session starts, the function that advances it. That is called again and again until
  /// the session ends, and takes about 20 ms each time.
  std::function<std::function<void()>(Session&)> driver;
  /// Called with the session before it starts, for taps.
  std::function<void(Session&)> before_start;
  /// Ends a run. If its clock is real, it is asked on another thread, about fifty times a second.
  std::function<bool()> stop_asked = [] { return false; };
};

/// Runs the plan by its clock, then its reference run (or takes it from the cache), and judges. What fails while
/// running is the result's `failure`. Throws RunError only where nothing has run (`on_missing_privilege: fail`).
RunResult execute(const Plan& plan, const RunOptions& options);

}  // namespace tactor
