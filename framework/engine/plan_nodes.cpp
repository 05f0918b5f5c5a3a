#include "framework/engine/plan_nodes.hpp"

#include "framework/core/random.hpp"

namespace tactor {

namespace {

/// Calls `work`; the InputError that it throws gets the node's place and name.
template <class Work>
void at_place(const NodeSpec& spec, const Work& work) {
  try {
    work();
  } catch (const InputError& error) {
    throw InputError(spec.place.text() + ": node " + spec.name + ": " + error.what());
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
    at_place(spec, [&] { nodes_.push_back(spec.info->create(spec.params, context)); });
  }
}

std::vector<std::string> check_nodes(const Plan& plan) {
  std::vector<std::string> notes;
  for (const NodeSpec& spec : plan.nodes) {
    if (spec.info->check_bodies) at_place(spec, [&] { spec.info->check_bodies(plan.graph.scene, &notes); });
    if (spec.info->check_params) at_place(spec, [&] { spec.info->check_params(spec.params, &notes); });
  }
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
