#include "framework/engine/plan_nodes.hpp"

#include "framework/core/random.hpp"
#include "framework/core/value_error.hpp"

namespace tactor {

namespace {

/// Calls `work`; the InputError that it throws gets the node's name, and the place of the value that it is about, else
/// that of the node.
template <class Work>
void at_place(const GraphSpec& graph, const NodeSpec& spec, const Work& work) {
  try {
    work();
  } catch (const YamlError&) {
    throw;
  } catch (const ValueError& error) {
    const std::string& path = error.path();
    const bool of_scene = path.starts_with("scene.");
    const Place place = graph.place_of(of_scene ? path : "nodes." + spec.name + "." + path);
    throw YamlError({{place, "node " + spec.name + ": " + error.what()}});
  } catch (const InputError& error) {
    throw YamlError({{spec.place, "node " + spec.name + ": " + error.what()}});
  }
}

/// What the graph says of costs that is without effect.
void note_costs(const Plan& plan, std::vector<std::string>& notes) {
  if (plan.graph.clock != Clock::real || !plan.graph.live.impose_cost) return;
  for (const NodeSpec& spec : plan.nodes) {
    if (spec.cost.kind == CostModel::Kind::none || spec.scheduling.lane != Lane::realtime) continue;
    notes.push_back(spec.place.text() + ": node " + spec.name +
                    ": its cost has no effect in lane realtime, whose loop is never held back; take the cost out, or "
                    "name another lane");
  }
}

}  // namespace

PlanNodes::PlanNodes(const Plan& plan) : plan_(plan) {
  for (const NodeSpec& spec : plan.nodes) {
    NodeContext context;
    context.name = spec.name;
    context.scene = &plan.graph.scene;
    context.torque = plan.torque;
    context.seed = derive_seed(plan.graph.seed, spec.name);
    context.duration = plan.graph.duration;
    context.notes = &notes_;
    at_place(plan.graph, spec, [&] { nodes_.push_back(spec.info->create(spec.params, context)); });
  }
  note_costs(plan, notes_);
}

std::vector<std::string> check_nodes(const Plan& plan) {
  std::vector<std::string> notes;
  for (const NodeSpec& spec : plan.nodes) {
    if (spec.info->check_bodies) at_place(plan.graph, spec, [&] { spec.info->check_bodies(plan.graph.scene, &notes); });
    if (spec.info->check_params) at_place(plan.graph, spec, [&] { spec.info->check_params(spec.params, &notes); });
  }
  note_costs(plan, notes);
  return notes;
}

void PlanNodes::follow(const PlanNodes& judged) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    for (std::size_t j = 0; j < judged.nodes_.size(); ++j) {
      if (plan_.nodes[i].name == judged.plan_.nodes[j].name) nodes_[i]->follow(*judged.nodes_[j]);
    }
  }
}

template <class Work>
void PlanNodes::guarded(std::size_t index, Time now, const Work& work) {
  // Put together where it fails alone: a step in the real-time lane allocates nothing.
  const auto node = [&] { return "node " + plan_.nodes[index].name; };
  const auto failed = [&](const std::string& why) {
    return RunError(node() + " failed at " + std::to_string(now.seconds()) + " s: " + why);
  };
  try {
    work(*nodes_[index]);
  } catch (const InputError& error) {
    throw InputError(node() + ": " + error.what());
  } catch (const std::exception& error) {
    throw failed(error.what());
  } catch (...) {
    throw failed("it threw what is no exception");
  }
}

void PlanNodes::start(std::size_t index, StepContext& context) {
  guarded(index, context.now(), [&](Node& node) { node.start(context); });
}

void PlanNodes::step(std::size_t index, StepContext& context) {
  guarded(index, context.now(), [&](Node& node) { node.step(context); });
}

}  // namespace tactor
