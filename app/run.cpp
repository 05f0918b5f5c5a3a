#include "app/run.hpp"

#include <link.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>
#include <memory>

#include "app/statistics.hpp"
#include "framework/graph/texts.hpp"
#include "framework/record/recorder.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double peak_memory_MB() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

/// Passes messages to the recorder and progress to the caller.
class Watch final : public RunObserver {
 public:
  Watch(const Plan& plan, Recorder* recorder, const RunOptions& options)
      : plan_(plan), recorder_(recorder), options_(options), last_(wall_seconds()) {
    if (recorder_ == nullptr) return;
    for (const PlannedStream& stream : plan.streams) {
      streams_.push_back(
          recorder_->add_stream(stream.name, *plan.nodes[stream.node].info->outputs[stream.output].type));
    }
  }
  void on_message(std::size_t stream, const Stamp& stamp, const void* payload) override {
    if (recorder_ != nullptr) recorder_->write(streams_[stream], stamp, payload);
  }
  bool on_progress(Time now) override {
    const double wall = wall_seconds();
    if (wall - last_ < 0.1) return true;
    last_ = wall;
    if (!options_.progress) return true;
    interrupted_ = !options_.progress(now.seconds() / plan_.graph.duration.seconds(), "run");
    return !interrupted_;
  }
  [[nodiscard]] bool interrupted() const { return interrupted_; }

 private:
  const Plan& plan_;
  Recorder* recorder_;
  const RunOptions& options_;
  std::vector<std::size_t> streams_;
  double last_;
  bool interrupted_ = false;
};

/// The program and the libraries of ours that it has loaded.
std::vector<fs::path> code_files() {
  std::vector<fs::path> files{fs::read_symlink("/proc/self/exe")};
  const auto add = [](dl_phdr_info* info, std::size_t, void* data) {
    const fs::path file = info->dlpi_name;
    if (file.filename().string().starts_with("libtactor_")) static_cast<std::vector<fs::path>*>(data)->push_back(file);
    return 0;
  };
  dl_iterate_phdr(add, &files);
  std::sort(files.begin(), files.end());
  return files;
}

NodeCost node_cost(const NodeSpec& spec, const NodeFigures& figures) {
  NodeCost cost;
  cost.node = spec.name;
  cost.type = spec.info->type;
  cost.steps = figures.steps;
  cost.missed_ticks = figures.missed_ticks;
  std::vector<double> us;
  us.reserve(figures.cpu_ns.size());
  for (const std::uint32_t ns : figures.cpu_ns) {
    us.push_back(1e-3 * ns);
    cost.total_s += 1e-9 * ns;
  }
  if (!us.empty()) {
    cost.median_us = median(us);
    cost.p99_us = quantile(us, 0.99);
  }
  return cost;
}

}  // namespace

double RunResult::figure(std::string_view name) const {
  for (const auto& [key, value] : figures) {
    if (key == name) return value;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

const Series* RunResult::curve(std::string_view name) const {
  for (const Series& s : series) {
    if (s.name == name) return &s;
  }
  return nullptr;
}

RunResult execute(const Plan& plan, const RunOptions& options) {
  RunResult result;
  result.graph = plan.graph.name;
  result.title = plan.graph.title;
  result.seed = plan.graph.seed;
  result.left_out = plan.left_out;
  result.graph_yaml = to_yaml(plan.graph);

  VirtualClock engine(plan, true);
  {
    std::unique_ptr<Recorder> recorder;
    if (options.recording && !plan.streams.empty()) {
      recorder = load_record_library().create(*options.recording, {result.graph_yaml, plan.graph.seed, TACTOR_VERSION});
    }
    Watch watch(plan, recorder.get(), options);
    const double cpu = cpu_seconds();
    const double wall = wall_seconds();
    engine.run(watch);
    if (recorder) recorder->close();
    result.cpu_s = cpu_seconds() - cpu;
    result.wall_s = wall_seconds() - wall;
    result.interrupted = watch.interrupted();
  }
  result.duration_s = engine.now().seconds();

  const Plan reference_plan = make_reference_plan(plan);
  if (!reference_plan.nodes.empty() && !result.interrupted) {
    const auto go_on = [&options](double share) {
      return !options.progress || options.progress(share, "reference run");
    };
    result.reference.made = true;
    const double cpu = cpu_seconds();
    if (must_be_followed(engine.nodes())) {
      set_reference(engine.nodes(), run_reference(reference_plan, &engine.nodes(), go_on));
    } else {
      const ReferenceCache cache(options.cache_folder);
      const std::string key = reference_key(reference_plan, code_files());
      std::optional<Reference> reference = cache.load(key);
      result.reference.cached = reference.has_value();
      if (!reference) {
        reference = run_reference(reference_plan, nullptr, go_on);
        cache.store(key, *reference);
      }
      set_reference(engine.nodes(), *reference);
    }
    result.reference.cpu_s = cpu_seconds() - cpu;
  }

  Report report;
  report.set("refits", 0);
  report.set("fallbacks", 0);
  for (std::size_t i = 0; i < plan.nodes.size(); ++i) {
    report.begin(plan.nodes[i].name);
    engine.nodes()[i].report(report);
    result.nodes.push_back(node_cost(plan.nodes[i], engine.node_figures(i)));
  }
  double drops = 0;
  for (std::size_t i = 0; i < plan.edges.size(); ++i) {
    const EdgeFigures figures = engine.edge_figures(i);
    drops += static_cast<double>(figures.dropped);
    result.edges.push_back({plan.edges[i].spec.name(), queue_text(plan.edges[i].spec.queue), figures});
  }
  report.set("drops", drops);
  result.figures = report.figures();
  result.series = report.series();
  result.peak_memory_MB = peak_memory_MB();
  return result;
}

bool prepare_reference(const Plan& plan, const fs::path& cache_folder, const std::function<bool(double)>& go_on) {
  const Plan reference_plan = make_reference_plan(plan);
  if (reference_plan.nodes.empty()) return false;
  const ReferenceCache cache(cache_folder);
  const std::string key = reference_key(reference_plan, code_files());
  // Asked first, because the next question takes an engine with its meshes and trees.
  if (cache.load(key)) return false;
  // Whether a node must be followed is known from its parameters alone, so nodes that never run can be asked.
  if (must_be_followed(PlanNodes(plan))) return false;
  cache.store(key, run_reference(reference_plan, nullptr, go_on));
  return true;
}

}  // namespace tactor
