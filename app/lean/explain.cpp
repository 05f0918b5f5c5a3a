#include "app/lean/explain.hpp"

#include <fmt/format.h>
#include <link.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <span>
#include <utility>

#include "app/run/summary.hpp"
#include "app/run/timed_run.hpp"
#include "app/statistics.hpp"
#include "framework/graph/scheduling_words.hpp"
#include "framework/graph/text_table.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "framework/session/session.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// Bytes of the heap that a node has.
struct HeapUse {
  std::int64_t built = 0, now = 0, peak = 0;
};

/// Counts what each node takes of the heap of its thread while it is made, starts and steps.
class HeapMeter final : public NodeMeter {
 public:
  explicit HeapMeter(std::size_t nodes) : uses_(nodes) {}
  void begin(std::size_t /*node*/, Work /*work*/) override {
    before_ = thread_heap_bytes();
    static_cast<void>(thread_heap_bytes_peak());
  }
  void end(std::size_t node, Work work) override {
    HeapUse& use = uses_[node];
    use.peak = std::max(use.peak, use.now + thread_heap_bytes_peak() - before_);
    use.now += thread_heap_bytes() - before_;
    if (work == Work::make) use.built = use.now;
  }
  [[nodiscard]] const std::vector<HeapUse>& uses() const { return uses_; }

 private:
  std::vector<HeapUse> uses_;
  std::int64_t before_ = 0;
};

std::vector<HeapUse> heap_uses(const Plan& plan, const std::function<bool()>& interrupted) {
  HeapMeter meter(plan.nodes.size());
  // The same work in a child would count as well, but a thread of its own would find other caches.
  count_thread_heap_bytes(true);
  {
    Session session(plan, {.engine = {.meter = &meter}});
    run_to_end(session, interrupted);
  }
  count_thread_heap_bytes(false);
  return meter.uses();
}

double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

ExplainedCost cost_of(const std::vector<double>& repeats) {
  return {median(repeats), quantile(repeats, 0), quantile(repeats, 1)};
}

/// A plan that is run by turns with others.
struct Timed {
  Plan plan;
  std::vector<std::uint64_t> steps;          // by node
  std::vector<std::vector<double>> repeats;  // by node, us of CPU time a simulated second
};

void run_once(Timed& timed, bool counts, const std::function<bool()>& interrupted) {
  Session session(timed.plan, {.engine = {.measure_cpu = true}});
  run_to_end(session, interrupted);
  timed.steps.clear();
  for (std::size_t n = 0; n < timed.plan.nodes.size(); ++n) timed.steps.push_back(session.node_statistics(n).steps);
  if (!counts) return;
  const std::vector<double> costs = node_costs(session);
  timed.repeats.resize(costs.size());
  for (std::size_t n = 0; n < costs.size(); ++n) timed.repeats[n].push_back(costs[n]);
}

/// The costs of all nodes, by repeat.
std::vector<double> totals(const Timed& timed) {
  std::vector<double> result(timed.repeats.front().size(), 0.0);
  for (const auto& node : timed.repeats) {
    for (std::size_t r = 0; r < node.size(); ++r) result[r] += node[r];
  }
  return result;
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
    const NodeInfo* other = node.info->role == Role::dynamics ? dearer(*node.info, registry) : nullptr;
    if (other != nullptr) node.info = other;
  }
  return graph;
}

/// The graph with what was left out kept in; none where that cannot be run.
std::optional<GraphSpec> kept_in(const GraphSpec& graph, const LeftOut& left, const Registry& registry) {
  if (left.kind == LeftOut::Kind::torque) return with_rotation(graph, registry);
  const NodeSpec* spec = left.kind == LeftOut::Kind::node ? graph.node(left.node) : nullptr;
  if (spec == nullptr || spec->info->outputs.empty()) return std::nullopt;
  // A node whose output is recorded is wanted.
  GraphSpec result = graph;
  result.record.push_back(left.node + "." + spec->info->outputs.front().name);
  return result;
}

/// The plan with `left` kept in, run once; none where it cannot be run.
std::optional<Timed> warmed(const Plan& plan, const LeftOut& left, const Registry& registry,
                            const std::function<bool()>& interrupted) {
  const std::optional<GraphSpec> graph = kept_in(plan.graph, left, registry);
  if (!graph) return std::nullopt;
  try {
    Timed timed{make_plan(*graph), {}, {}};
    run_once(timed, false, interrupted);
    return timed;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

/// What it cost in `kept` to keep `left` in: the node's steps; of torque all of the run, less `without`, by repeat.
std::optional<ExplainedCost> cost_kept_in(const Timed& kept, const LeftOut& left, const std::vector<double>& without) {
  if (left.kind == LeftOut::Kind::torque) {
    std::vector<double> more = totals(kept);
    for (std::size_t r = 0; r < more.size(); ++r) more[r] -= without[r];
    return cost_of(more);
  }
  for (std::size_t n = 0; n < kept.plan.nodes.size(); ++n) {
    if (kept.plan.nodes[n].name == left.node) return cost_of(kept.repeats[n]);
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

void add_nodes(Explanation& e, const Timed& timed, const std::vector<HeapUse>& heap) {
  std::vector<double> medians;
  for (const auto& repeats : timed.repeats) medians.push_back(median(repeats));
  const double total = sum(medians);
  for (std::size_t n = 0; n < timed.plan.nodes.size(); ++n) {
    const NodeSpec& planned = timed.plan.nodes[n];
    ExplainedNode node{.node = planned.name, .type = planned.info->type, .lane = word(planned.scheduling.lane)};
    node.steps = timed.steps[n];
    node.us_per_second = medians[n];
    node.us_per_step = node.steps > 0 ? medians[n] * e.duration_s / static_cast<double>(node.steps) : 0;
    node.spread = spread_of_repeats(timed.repeats[n]);
    node.share = total > 0 ? medians[n] / total : 0;
    node.built_bytes = heap[n].built;
    node.peak_bytes = std::max(heap[n].peak, heap[n].built);
    e.nodes.push_back(std::move(node));
  }
}

std::string megabytes(double bytes) {
  return fmt::format("{:.2f} MB", 1e-6 * bytes);
}

std::string cost_text(const ExplainedCost& cost) {
  return fmt::format("{:.0f} us a simulated s ({:.0f} to {:.0f})", cost.median, cost.least, cost.most);
}

nlohmann::ordered_json to_json(const ExplainedCost& cost) {
  return {{"median", cost.median}, {"least", cost.least}, {"most", cost.most}};
}

}  // namespace

Explanation explain_measured(const GraphSpec& graph, double seconds, Repeats repeats, const Registry& registry,
                             const std::function<bool()>& interrupted) {
  GraphSpec shorter = graph;
  shorter.duration = Duration::from_seconds(seconds);
  Timed timed{make_plan(shorter), {}, {}};
  const Plan& plan = timed.plan;
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
  e.physics = measure_physics_fit(plan, interrupted);
  run_once(timed, false, interrupted);
  std::vector<std::optional<Timed>> kept;
  for (const LeftOut& left : plan.left_out) kept.push_back(warmed(plan, left, registry, interrupted));
  std::vector<double> control;
  const auto run_timed = [&](Timed& one) {
    control.push_back(measure_control());
    run_once(one, true, interrupted);
  };
  for (std::int64_t repeat = 0; repeat < repeats.count; ++repeat) {
    run_timed(timed);
    for (std::optional<Timed>& one : kept) {
      if (one) run_timed(*one);
    }
  }
  const std::vector<double> total = totals(timed);
  e.total = cost_of(total);
  const std::array<double, 1> spread{spread_of_repeats(total)};
  e.timing = timing_note(control, spread, repeats, spread_warning(spread));
  add_nodes(e, timed, heap_uses(plan, interrupted));
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const LeftOut& left = plan.left_out[i];
    e.left_out.push_back(
        {left.what, left.why, kept[i] ? cost_kept_in(*kept[i], left, total) : std::optional<ExplainedCost>()});
  }
  return e;
}

std::string explanation_table(const Explanation& e, std::size_t columns) {
  std::string text =
      fmt::format("\n{}  {}\n  {} degrees of freedom, {} moving, {}; {} s simulated, seed {}\n\n", e.graph, e.title,
                  e.degrees_of_freedom, e.moving_bodies == 1 ? "one body" : fmt::format("{} bodies", e.moving_bodies),
                  e.torque ? "with torque" : "without torque", pretty(e.duration_s), e.seed);
  using enum TextTable::Align;
  TextTable nodes({{"node"},
                   {"type"},
                   {"lane"},
                   {"steps", right},
                   {"us a step", right},
                   {"us a simulated s", right},
                   {"spread", right},
                   {"share", right},
                   {"built", right},
                   {"at most", right}});
  for (const ExplainedNode& n : e.nodes) {
    const auto memory = [&](std::int64_t bytes) {
      return e.memory_is_counted ? megabytes(static_cast<double>(bytes)) : std::string("-");
    };
    nodes.add({n.node, n.type, n.lane, std::to_string(n.steps), pretty(n.us_per_step),
               fmt::format("{:.0f}", n.us_per_second), percent(n.spread), fmt::format("{:.1f} %", 100 * n.share),
               memory(n.built_bytes), memory(n.peak_bytes)});
  }
  text += nodes.text(columns);
  text += fmt::format("\n  {} {}\n\n  {}\n", "together:", cost_text(e.total), e.timing.text);
  if (!e.timing.warning.empty()) text += "  " + e.timing.warning + "\n";
  if (e.physics) text += "\n" + text_of(*e.physics, "  ");
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
    text += fmt::format("    {}: {}; {}\n", left.what, left.why,
                        left.cost ? cost_text(*left.cost) : std::string("not measured"));
  }
  return wrapped(text, columns);
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
              {"spread", number_json(n.spread)},
              {"share", n.share}};
    node["built_bytes"] = e.memory_is_counted ? Json(n.built_bytes) : Json(nullptr);
    node["peak_bytes"] = e.memory_is_counted ? Json(n.peak_bytes) : Json(nullptr);
    json["nodes"].push_back(std::move(node));
  }
  json["total_us_per_simulated_s"] = to_json(e.total);
  json["physics"] = e.physics ? to_json(*e.physics) : Json(nullptr);
  json["timing"] = to_json(e.timing);
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
    json["left_out"].push_back({{"what", left.what},
                                {"why", left.why},
                                {"us_per_simulated_s", left.cost ? to_json(*left.cost) : Json(nullptr)}});
  }
  return json;
}

}  // namespace tactor
