#include "app/lean/explain.hpp"

#include <fmt/format.h>
#include <link.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/run/step_times.hpp"
#include "app/run/summary.hpp"
#include "framework/engine/virtual_clock.hpp"
#include "framework/graph/scheduling_words.hpp"
#include "framework/realtime/allocation_watch.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

class Watch final : public RunObserver {
 public:
  explicit Watch(const std::function<bool()>& interrupted) : interrupted_(interrupted) {}
  bool on_progress(Time) override {
    if (interrupted_()) throw RunError("interrupted");
    return true;
  }

 private:
  const std::function<bool()>& interrupted_;
};

/// What a node has of the heap.
struct HeapUse {
  std::int64_t built = 0, now = 0, peak = 0;
};

/// A node that watches what another one takes of the heap while it is made and steps.
class Metered final : public Node {
 public:
  Metered(std::unique_ptr<Node> node, HeapUse* use) : node_(std::move(node)), use_(use) {}
  Node& inner() { return *node_; }
  void start(StepContext& context) override {
    counted([&] { node_->start(context); });
  }
  void step(StepContext& context) override {
    counted([&] { node_->step(context); });
  }
  [[nodiscard]] bool must_be_followed() const override { return node_->must_be_followed(); }

  /// Does the work and adds what it took.
  template <class Work>
  static void count(HeapUse& use, const Work& work) {
    const std::int64_t before = thread_heap_bytes();
    static_cast<void>(thread_heap_bytes_peak());
    work();
    use.peak = std::max(use.peak, use.now + thread_heap_bytes_peak() - before);
    use.now += thread_heap_bytes() - before;
  }

 private:
  template <class Work>
  void counted(const Work& work) {
    count(*use_, work);
  }

  std::unique_ptr<Node> node_;
  HeapUse* use_;
};

/// The declaration of a node whose heap is counted into `use`, which must outlive it.
NodeInfo metered(const NodeInfo& info, HeapUse& use) {
  NodeInfo result = info;
  result.create = [create = info.create, &use](const std::vector<ParamValue>& values, const NodeContext& context) {
    std::unique_ptr<Node> node;
    Metered::count(use, [&] { node = create(values, context); });
    use.built = use.now;
    return std::make_unique<Metered>(std::move(node), &use);
  };
  for (InputInfo& input : result.inputs) {
    input.access = [access = input.access](Node& node) -> InputBase& {
      return access(static_cast<Metered&>(node).inner());
    };
  }
  for (OutputInfo& output : result.outputs) {
    output.access = [access = output.access](Node& node) -> OutputBase& {
      return access(static_cast<Metered&>(node).inner());
    };
  }
  return result;
}

std::vector<HeapUse> heap_uses(const Plan& plan, const std::function<bool()>& interrupted) {
  std::vector<HeapUse> uses(plan.nodes.size());
  std::vector<NodeInfo> infos;
  infos.reserve(plan.nodes.size());
  Plan watched = plan;
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    infos.push_back(metered(*plan.nodes[n].info, uses[n]));
    watched.nodes[n].info = &infos.back();
  }
  // The same work in a child would count as well, but a thread of its own would find other caches.
  count_thread_heap_bytes(true);
  {
    VirtualClock engine(watched, false);
    Watch watch(interrupted);
    engine.run(watch);
  }
  count_thread_heap_bytes(false);
  return uses;
}

/// us of CPU time a simulated second, by node.
std::vector<double> costs(const Plan& plan, const std::function<bool()>& interrupted,
                          std::vector<std::uint64_t>* steps = nullptr) {
  VirtualClock engine(plan, true);
  Watch watch(interrupted);
  engine.run(watch);
  std::vector<double> result;
  const double seconds = engine.now().seconds();
  for (const auto& node : step_times(engine, plan.nodes.size())) {
    double ns = 0;
    for (const std::uint32_t step : node) ns += step;
    result.push_back(1e-3 * ns / seconds);
    if (steps != nullptr) steps->push_back(node.size());
  }
  return result;
}

double sum(const std::vector<double>& values) {
  double total = 0;
  for (const double value : values) total += value;
  return total;
}

int degrees_of_freedom(const Scene& scene) {
  int count = 0;
  for (const std::size_t i : scene.moving()) count += scene.bodies[i].motion == Motion::rigid ? 6 : 3;
  return count;
}

/// The type of the same library and the same parameters that this one is a cheaper stand-in for; null where there is
/// none.
const NodeInfo* dearer(const NodeInfo& info, const Registry& registry) {
  for (const NodeInfo* other : registry.types()) {
    const auto& cheaper = other->cheaper_types;
    if (std::find(cheaper.begin(), cheaper.end(), info.type) == cheaper.end()) continue;
    const auto same = [](const ParamInfo& a, const ParamInfo& b) { return a.name == b.name && a.kind == b.kind; };
    if (std::equal(info.params.begin(), info.params.end(), other->params.begin(), other->params.end(), same)) {
      return other;
    }
  }
  return nullptr;
}

/// The graph with torque kept in: its tool turns, and nodes that refuse such a scene are those that they stand in for.
/// None where no tool moves.
std::optional<GraphSpec> with_rotation(GraphSpec graph, const Registry& registry) {
  const std::vector<std::size_t> moving = graph.scene.moving();
  if (moving.empty()) return std::nullopt;
  graph.scene.bodies[moving.front()].motion = Motion::rigid;
  for (NodeSpec& node : graph.nodes) {
    const NodeInfo* other = node.info->type.starts_with("dynamics.") ? dearer(*node.info, registry) : nullptr;
    if (other != nullptr) node.info = other;
  }
  return graph;
}

/// What `what` would cost a simulated second; none where it cannot be measured.
std::optional<double> cost_kept_in(const Plan& plan, double total, const std::string& what, const Registry& registry,
                                   const std::function<bool()>& interrupted) {
  const std::string node = what.starts_with("node ") ? what.substr(5) : "";
  std::optional<GraphSpec> graph;
  if (what == "torque") {
    graph = with_rotation(plan.graph, registry);
  } else if (const NodeSpec* spec = node.empty() ? nullptr : plan.graph.node(node);
             spec != nullptr && !spec->info->outputs.empty()) {
    // A node whose output is recorded is wanted.
    graph = plan.graph;
    graph->record.push_back(node + "." + spec->info->outputs.front().name);
  }
  if (!graph) return std::nullopt;
  try {
    const Plan kept = make_plan(*graph);
    const std::vector<double> found = costs(kept, interrupted);
    if (what == "torque") return std::max(0.0, sum(found) - total);
    for (std::size_t n = 0; n < kept.nodes.size(); ++n) {
      if (kept.nodes[n].name == node) return found[n];
    }
  } catch (const InputError&) {
    // It cannot be kept in.
  }
  return std::nullopt;
}

std::vector<ExplainedLibrary> loaded_libraries() {
  std::vector<ExplainedLibrary> found;
  const auto add = [](dl_phdr_info* info, std::size_t, void* data) {
    const fs::path file = info->dlpi_name;
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(file, error);
    if (error) return 0;
    const std::string name = file.filename().string();
    static_cast<std::vector<ExplainedLibrary>*>(data)->push_back(
        {name, static_cast<std::uint64_t>(bytes), name.starts_with("libtactor_")});
    return 0;
  };
  dl_iterate_phdr(add, &found);
  std::sort(found.begin(), found.end(), [](const ExplainedLibrary& a, const ExplainedLibrary& b) {
    return a.ours != b.ours ? a.ours : a.bytes > b.bytes;
  });
  return found;
}

std::string megabytes(double bytes) {
  return fmt::format("{:.2f} MB", 1e-6 * bytes);
}

}  // namespace

Explanation explain_measured(const GraphSpec& graph, double seconds, const Registry& registry,
                             const std::function<bool()>& interrupted) {
  GraphSpec shorter = graph;
  shorter.duration = Duration::from_seconds(seconds);
  const Plan plan = make_plan(shorter);
  Explanation e;
  e.graph = plan.graph.name;
  e.title = plan.graph.title;
  e.seed = plan.graph.seed;
  e.duration_s = seconds;
  e.degrees_of_freedom = degrees_of_freedom(plan.graph.scene);
  e.moving_bodies = static_cast<int>(plan.graph.scene.moving().size());
  e.torque = plan.torque;
  e.chosen = plan.chosen;
  e.memory_is_counted = heap_calls_are_counted();
  e.libraries = loaded_libraries();
  std::vector<std::uint64_t> steps;
  const std::vector<double> cost = costs(plan, interrupted, &steps);
  const double total = sum(cost);
  const std::vector<HeapUse> heap = heap_uses(plan, interrupted);
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    ExplainedNode node{
        .node = plan.nodes[n].name, .type = plan.nodes[n].info->type, .lane = word(plan.nodes[n].scheduling.lane)};
    node.steps = steps[n];
    node.us_per_second = cost[n];
    node.us_per_step = steps[n] > 0 ? cost[n] * seconds / static_cast<double>(steps[n]) : 0;
    node.share = total > 0 ? cost[n] / total : 0;
    node.built_bytes = heap[n].built;
    node.peak_bytes = std::max(heap[n].peak, heap[n].built);
    e.nodes.push_back(std::move(node));
  }
  for (const LeftOut& left : plan.left_out) {
    e.left_out.push_back({left.what, left.why, cost_kept_in(plan, total, left.what, registry, interrupted)});
  }
  return e;
}

std::string explanation_table(const Explanation& e) {
  std::string text =
      fmt::format("\n{}  {}\n  {} degrees of freedom, {} moving, {}; {} s simulated, seed {}\n\n", e.graph, e.title,
                  e.degrees_of_freedom, e.moving_bodies == 1 ? "one body" : fmt::format("{} bodies", e.moving_bodies),
                  e.torque ? "with torque" : "without torque", pretty(e.duration_s), e.seed);
  text += fmt::format("  {:<16} {:<24} {:<9} {:>8} {:>10} {:>16} {:>7} {:>10} {:>10}\n", "node", "type", "lane",
                      "steps", "us a step", "us a simulated s", "share", "built", "at most");
  for (const ExplainedNode& n : e.nodes) {
    const auto memory = [&](std::int64_t bytes) {
      return e.memory_is_counted ? megabytes(static_cast<double>(bytes)) : std::string("-");
    };
    text += fmt::format("  {:<16} {:<24} {:<9} {:>8} {:>10} {:>16.0f} {:>5.1f} % {:>10} {:>10}\n", n.node, n.type,
                        n.lane, n.steps, pretty(n.us_per_step), n.us_per_second, 100 * n.share, memory(n.built_bytes),
                        memory(n.peak_bytes));
  }
  double others = 0;
  std::size_t count = 0;
  text += "\n  libraries loaded\n";
  for (const ExplainedLibrary& library : e.libraries) {
    if (library.ours) {
      text += fmt::format("    {:<40} {:>10}\n", library.name, megabytes(static_cast<double>(library.bytes)));
    } else {
      others += static_cast<double>(library.bytes);
      ++count;
    }
  }
  text += fmt::format("    {:<40} {:>10}\n", fmt::format("{} of the system", count), megabytes(others));
  if (!e.chosen.empty()) text += "\n  chosen\n";
  for (const Chosen& c : e.chosen) text += fmt::format("    {}: {} is {}: {}\n", c.node, c.asked, c.type, c.why);
  if (!e.left_out.empty()) text += "\n  left out, and what it would cost\n";
  for (const ExplainedLeftOut& left : e.left_out) {
    text += fmt::format(
        "    {}: {}; {}\n", left.what, left.why,
        left.us_per_second ? fmt::format("{:.0f} us a simulated s", *left.us_per_second) : std::string("not measured"));
  }
  return text;
}

nlohmann::ordered_json to_json(const Explanation& e) {
  using Json = nlohmann::ordered_json;
  Json json{{"graph", e.graph},
            {"seed", e.seed},
            {"duration_s", e.duration_s},
            {"scene",
             {{"degrees_of_freedom", e.degrees_of_freedom}, {"moving_bodies", e.moving_bodies}, {"torque", e.torque}}}};
  json["nodes"] = Json::array();
  for (const ExplainedNode& n : e.nodes) {
    Json node{{"node", n.node},
              {"type", n.type},
              {"lane", n.lane},
              {"steps", n.steps},
              {"us_per_step", n.us_per_step},
              {"us_per_simulated_s", n.us_per_second},
              {"share", n.share}};
    node["built_bytes"] = e.memory_is_counted ? Json(n.built_bytes) : Json(nullptr);
    node["peak_bytes"] = e.memory_is_counted ? Json(n.peak_bytes) : Json(nullptr);
    json["nodes"].push_back(std::move(node));
  }
  json["libraries"] = Json::array();
  for (const ExplainedLibrary& l : e.libraries) {
    json["libraries"].push_back({{"name", l.name}, {"bytes", l.bytes}, {"ours", l.ours}});
  }
  json["chosen"] = Json::array();
  for (const Chosen& c : e.chosen) {
    json["chosen"].push_back({{"node", c.node}, {"asked", c.asked}, {"type", c.type}, {"why", c.why}});
  }
  json["left_out"] = Json::array();
  for (const ExplainedLeftOut& left : e.left_out) {
    json["left_out"].push_back(
        {{"what", left.what},
         {"why", left.why},
         {"us_per_simulated_s", left.us_per_second ? Json(*left.us_per_second) : Json(nullptr)}});
  }
  return json;
}

}  // namespace tactor
