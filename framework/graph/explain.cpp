#include <algorithm>

#include "framework/graph/chains.hpp"
#include "framework/graph/plan.hpp"
#include "framework/graph/scheduling_words.hpp"
#include "framework/graph/texts.hpp"
#include "framework/graph/values.hpp"

namespace tactor {

namespace {

std::string steps_text(const Plan& plan, std::size_t n) {
  const NodeSpec& node = plan.nodes[n];
  std::string text;
  if (const std::optional<double> rate = node.rate()) text = "at " + number_text(*rate) + " Hz";
  for (const PlannedEdge& edge : plan.edges) {
    if (edge.to == n && edge.triggers) text += (text.empty() ? "on " : ", on ") + edge.spec.to_port;
  }
  return text;
}

// `thread physics, fifo 40, cpu 1`; the pool's threads are told with the clock.
std::string lane_text(const NodeSpec& node) {
  const Scheduling& scheduling = node.scheduling;
  std::string text = word(scheduling.lane);
  if (scheduling.lane == Lane::thread) text = scheduling.thread.empty() ? "own thread" : "thread " + scheduling.thread;
  if (scheduling.policy) text += ", " + word(*scheduling.policy);
  if (scheduling.priority) text += " " + std::to_string(*scheduling.priority);
  if (scheduling.cpu) text += ", cpu " + std::to_string(*scheduling.cpu);
  return text + (scheduling == default_scheduling(*node.info) ? " (default)" : "");
}

std::string live_text(const LiveSettings& live) {
  std::string text = "pool: ";
  if (live.pool_workers > 0)
    text += std::to_string(live.pool_workers) + (live.pool_workers == 1 ? " worker, " : " workers, ");
  text += word(live.pool.policy);
  if (live.pool.policy != SchedulingPolicy::other) text += " " + std::to_string(live.pool.priority);
  if (live.pool.cpu) text += ", cpu " + std::to_string(*live.pool.cpu);
  text += "; a missing privilege: " + word(live.on_missing_privilege) + "; a step of more than " +
          duration_text(live.stall_timeout) + ": " + word(live.on_stall);
  if (live.impose_cost) text += "; a step takes at least its declared cost";
  if (live.flight != FlightChoice::automatic) text += "; flight recorder: " + word(live.flight);
  return text + (live == LiveSettings{} ? " (default)" : "");
}

}  // namespace

std::string explain(const Plan& plan, std::size_t columns) {
  const GraphSpec& graph = plan.graph;
  std::string text = graph.name + (graph.title.empty() ? "" : ": " + graph.title) + "\n";
  text += std::string("clock ") + (graph.clock == Clock::real ? "real" : "virtual") + ", duration " +
          duration_text(graph.duration) + ", seed " + std::to_string(graph.seed) + ", " + motion_text(graph.scene);
  const auto is_haptic = [](const NodeSpec& node) { return node.info->haptic_rate; };
  if (std::any_of(plan.nodes.begin(), plan.nodes.end(), is_haptic)) {
    text += ", haptic loop at " + number_text(graph.rate) + " Hz";
  }
  text += "\n";
  if (graph.clock == Clock::real) text += live_text(graph.live) + "\n";
  for (const auto& nodes : shared_loops(plan)) {
    text += "in one real-time loop, stepping in this order: " + node_names(plan, nodes) + "\n";
  }
  const auto has_cost = [](const NodeSpec& node) { return node.cost.kind != CostModel::Kind::none; };
  if (graph.clock == Clock::real && !graph.live.impose_cost &&
      std::any_of(plan.nodes.begin(), plan.nodes.end(), has_cost)) {
    text += "the costs below have no effect: a step takes the time it takes; live: {impose_cost: true} imposes them\n";
  }

  TextTable nodes({{"node"}, {"type"}, {"steps"}, {"cost"}, {"lane"}});
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    const NodeSpec& node = plan.nodes[n];
    nodes.add({node.name, node.info->type, steps_text(plan, n), cost_text(node.cost), lane_text(node)});
  }
  text += "\nruns\n" + nodes.text(columns);

  TextTable edges({{"edge"}, {"message"}, {"queue"}, {""}});
  for (const PlannedEdge& edge : plan.edges) {
    const OutputInfo& output = plan.nodes[edge.from].info->outputs[edge.output];
    std::string notes = edge.triggers ? "triggers" : "";
    if (edge.spec.delay.ns > 0) notes += (notes.empty() ? "delay " : ", delay ") + duration_text(edge.spec.delay);
    edges.add({edge.spec.name(), std::string(output.type->name),
               queue_text(edge.spec.queue) + (edge.spec.queue_is_default ? " (default)" : ""), notes});
  }
  if (!plan.edges.empty()) text += "\nedges\n" + edges.text(columns);

  if (!plan.streams.empty()) {
    text += "\nrecords\n";
    for (const PlannedStream& stream : plan.streams) text += "  " + stream.name + "\n";
  }
  if (!plan.chosen.empty()) {
    TextTable rows({{""}, {""}, {""}});
    for (const Chosen& c : plan.chosen) rows.add({c.node, c.asked + " is " + c.type, c.why});
    text += "\nchosen\n" + rows.text(columns);
  }
  if (!plan.left_out.empty()) {
    TextTable rows({{""}, {""}});
    for (const LeftOut& left : plan.left_out) rows.add({left.what, left.why});
    text += "\nleft out\n" + rows.text(columns);
  }
  return wrapped(text, columns);
}

}  // namespace tactor
