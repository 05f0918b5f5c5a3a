#include "framework/engine/plan_nodes.hpp"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "framework/core/random.hpp"
#include "framework/core/value_error.hpp"
#include "framework/engine/setting_effects.hpp"
#include "framework/engine/slow_physics.hpp"
#include "framework/graph/shared_parameters.hpp"

namespace tactor {

namespace {

/// The error with the node's name, and the place of the value that it is about, else that of the node.
Diagnostic located(const GraphSpec& graph, const NodeSpec& spec, const InputError& error) {
  SourceLocation place = spec.place;
  if (const auto* value = dynamic_cast<const ValueError*>(&error)) {
    const std::string& path = value->path();
    place = graph.place_of(path.starts_with("scene.") ? path : "nodes." + spec.name + "." + path);
  }
  return {place, "node " + spec.name + ": " + error.what()};
}

/// Calls `work`; the InputError that it throws gets place and name, unless it names places of its own.
template <class Work>
void at_place(const GraphSpec& graph, const NodeSpec& spec, const Work& work) {
  try {
    work();
  } catch (const YamlError&) {
    throw;
  } catch (const InputError& error) {
    throw YamlError({located(graph, spec, error)});
  }
}

/// What the graph says of costs that is without effect, or takes the force away.
void note_costs(const Plan& plan, std::vector<std::string>& notes) {
  for (std::string& note : slow_physics_notes(plan)) notes.push_back(std::move(note));
  if (plan.graph.clock != Clock::real || !plan.graph.live.impose_cost) return;
  for (const NodeSpec& spec : plan.nodes) {
    if (spec.cost.kind == CostModel::Kind::none || spec.scheduling.lane != Lane::realtime) continue;
    notes.push_back(spec.place.text() + ": node " + spec.name +
                    ": its cost has no effect in lane realtime, whose loop is never held back; take the cost out, or "
                    "name another lane");
  }
}

/// A crash in the code of a node in Python ends the process, and what drives a device with it.
void note_python_beside_hardware(const Plan& plan, std::vector<std::string>& notes) {
  const auto drives_hardware = [](const NodeSpec& spec) { return spec.info->hardware.has_value(); };
  const auto device = std::find_if(plan.nodes.begin(), plan.nodes.end(), drives_hardware);
  if (device == plan.nodes.end() || plan.graph.clock != Clock::real) return;
  for (const NodeSpec& spec : plan.nodes) {
    if (spec.info->python.empty()) continue;
    notes.push_back(spec.place.text() + ": node " + spec.name + " is in Python and runs in the process that drives " +
                    device->name +
                    ": if its code crashes, nothing commands zero any more, and the watchdog of the "
                    "device itself must let go (docs/trust/safety.md)");
  }
}

void note_plan(const Plan& plan, std::vector<std::string>& notes) {
  note_costs(plan, notes);
  note_python_beside_hardware(plan, notes);
  for (std::string& note : unshared_parameter_notes(plan)) notes.push_back(std::move(note));
}

bool is_fed_by_foreign_physics(const GraphSpec& graph, const NodeSpec& spec) {
  return std::any_of(graph.edges.begin(), graph.edges.end(), [&](const EdgeSpec& edge) {
    if (edge.to_node != spec.name) return false;
    const NodeSpec* from = graph.node(edge.from_node);
    return from != nullptr && from->info->is_foreign_physics();
  });
}

NodeContext context_of(const GraphSpec& graph, const NodeSpec& spec, const HandPath* hand,
                       std::vector<std::string>* notes) {
  NodeContext context;
  context.name = spec.name;
  context.scene = &graph.scene;
  context.torque = graph.scene.rotates();
  context.seed = derive_seed(graph.seed, spec.name);
  context.duration = graph.duration;
  context.foreign_physics = is_fed_by_foreign_physics(graph, spec);
  context.wall_clock = graph.clock == Clock::real;
  context.in_loop = context.wall_clock && spec.scheduling.lane == Lane::realtime;
  context.hand = hand;
  context.notes = notes;
  return context;
}

/// The graph without nodes, and without what no check asks for.
GraphSpec bare(const GraphSpec& graph) {
  GraphSpec left;
  left.clock = graph.clock;
  left.duration = graph.duration;
  left.scene = graph.scene;
  return left;
}

/// Where the hand is led; none where no node knows, or several do.
std::optional<HandPath> hand_path(const Plan& plan) {
  const NodeSpec* leader = nullptr;
  for (const NodeSpec& spec : plan.nodes) {
    if (!spec.info->hand_path) continue;
    if (leader != nullptr) return std::nullopt;
    leader = &spec;
  }
  if (leader == nullptr) return std::nullopt;
  std::optional<HandPath> path;
  at_place(plan.graph, *leader,
           [&] { path = leader->info->hand_path(leader->params, context_of(plan.graph, *leader, nullptr, nullptr)); });
  return path;
}

/// Tells a meter, where there is one, of some work of a node.
class Metered {
 public:
  Metered(NodeMeter* meter, std::size_t node, NodeMeter::Work work) : meter_(meter), node_(node), work_(work) {
    if (meter_ != nullptr) meter_->begin(node_, work_);
  }
  Metered(const Metered&) = delete;
  Metered& operator=(const Metered&) = delete;
  ~Metered() {
    if (meter_ != nullptr) meter_->end(node_, work_);
  }

 private:
  NodeMeter* meter_;
  std::size_t node_;
  NodeMeter::Work work_;
};

}  // namespace

PlanNodes::PlanNodes(const Plan& plan, NodeMeter* meter, FlightRing* flight) : plan_(plan), meter_(meter) {
  const std::optional<HandPath> hand = hand_path(plan);
  for (const NodeSpec& spec : plan.nodes) {
    NodeContext context = context_of(plan.graph, spec, hand ? &*hand : nullptr, &notes_);
    context.flight = flight;
    context.index = nodes_.size();
    const Metered metered(meter_, nodes_.size(), NodeMeter::Work::make);
    at_place(plan.graph, spec, [&] { nodes_.push_back(spec.info->create(spec.params, context)); });
  }
  note_plan(plan, notes_);
}

std::vector<std::string> NodeChecks::check(const Plan& plan) {
  std::vector<std::string> notes;
  Diagnostics diagnostics;
  std::set<std::string> said;  // a body that several nodes refuse is refused once
  const auto leads = [](const NodeSpec& spec) { return spec.info->hand_path != nullptr; };
  // What a node is checked with, as text.
  GraphSpec asked = bare(plan.graph);
  std::copy_if(plan.nodes.begin(), plan.nodes.end(), std::back_inserter(asked.nodes), leads);
  const auto check = [&](const NodeSpec& spec, const HandPath* hand) {
    asked.nodes.push_back(spec);
    std::string key = to_yaml(asked);
    asked.nodes.pop_back();
    if (passed_.contains(key)) return;
    try {
      spec.info->check(spec.params, context_of(plan.graph, spec, hand, &notes));
      passed_.insert(std::move(key));
    } catch (const YamlError& error) {
      diagnostics.add(error);
    } catch (const InputError& error) {
      if (!said.insert(error.what()).second) return;
      const Diagnostic found = located(plan.graph, spec, error);
      diagnostics.error(found.place, found.message);
    }
  };
  // Those that lead the hand first, because the others are told where to.
  for (const NodeSpec& spec : plan.nodes) {
    if (leads(spec)) check(spec, nullptr);
  }
  const std::optional<HandPath> hand = diagnostics.any() ? std::nullopt : hand_path(plan);
  for (const NodeSpec& spec : plan.nodes) {
    if (!leads(spec)) check(spec, hand ? &*hand : nullptr);
  }
  diagnostics.throw_if_any();
  check_effects(plan);
  note_plan(plan, notes);
  return notes;
}

std::vector<std::string> check_nodes(const Plan& plan) {
  return NodeChecks().check(plan);
}

NodeNotes check_node(const GraphSpec& graph, const NodeSpec& spec) {
  NodeNotes told;
  NodeContext context = context_of(graph, spec, nullptr, &told.notes);
  context.limits = &told.limits;
  at_place(graph, spec, [&] { spec.info->check(spec.params, context); });
  return told;
}

void PlanNodes::follow(const PlanNodes& tested) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    for (std::size_t j = 0; j < tested.nodes_.size(); ++j) {
      if (plan_.nodes[i].name == tested.plan_.nodes[j].name) nodes_[i]->follow(*tested.nodes_[j]);
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
    throw failed("it threw an object that is not a std::exception");
  }
}

void PlanNodes::start(std::size_t index, StepContext& context) {
  const Metered metered(meter_, index, NodeMeter::Work::start);
  guarded(index, context.now(), [&](Node& node) { node.start(context); });
}

void PlanNodes::set(std::size_t index, const void* params) {
  if (params == nullptr) return nodes_[index]->request_done();
  plan_.nodes[index].info->tuning.value().tune(*nodes_[index], params);
}

void PlanNodes::step(std::size_t index, StepContext& context) {
  const Metered metered(meter_, index, NodeMeter::Work::step);
  guarded(index, context.now(), [&](Node& node) { node.step(context); });
}

}  // namespace tactor
