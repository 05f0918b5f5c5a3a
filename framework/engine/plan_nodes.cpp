#include "framework/engine/plan_nodes.hpp"

#include "framework/core/random.hpp"

namespace tactor {

PlanNodes::PlanNodes(const Plan& plan) : plan_(plan) {
  for (const NodeSpec& spec : plan.nodes) {
    NodeContext context;
    context.name = spec.name;
    context.scene = &plan.graph.scene;
    context.torque = plan.torque;
    context.seed = derive_seed(plan.graph.seed, spec.name);
    context.duration = plan.graph.duration;
    try {
      nodes_.push_back(spec.info->create(spec.params, context));
    } catch (const InputError& error) {
      throw InputError(spec.place.text() + ": node " + spec.name + ": " + error.what());
    }
  }
}

void PlanNodes::follow(const PlanNodes& judged) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    for (std::size_t j = 0; j < judged.nodes_.size(); ++j) {
      if (plan_.nodes[i].name == judged.plan_.nodes[j].name) nodes_[i]->follow(*judged.nodes_[j]);
    }
  }
}

std::string step_failure(const Plan& plan, std::size_t node, Time now, const std::string& why) {
  return "node " + plan.nodes[node].name + " failed at " + std::to_string(now.seconds()) + " s: " + why;
}

void PlanNodes::start(std::size_t index, StepContext& context) {
  try {
    nodes_[index]->start(context);
  } catch (const InputError& error) {
    throw InputError("node " + plan_.nodes[index].name + ": " + error.what());
  } catch (const std::exception& error) {
    throw RunError(step_failure(plan_, index, context.now(), error.what()));
  } catch (...) {
    throw RunError(step_failure(plan_, index, context.now(), "it threw what is no exception"));
  }
}

void PlanNodes::step(std::size_t index, StepContext& context) {
  try {
    nodes_[index]->step(context);
  } catch (const InputError& error) {
    throw InputError("node " + plan_.nodes[index].name + ": " + error.what());
  } catch (const std::exception& error) {
    throw RunError(step_failure(plan_, index, context.now(), error.what()));
  } catch (...) {
    throw RunError(step_failure(plan_, index, context.now(), "it threw what is no exception"));
  }
}

}  // namespace tactor
