// The nodes of a plan, made, and the calls into them with errors that name the node.
#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "framework/graph/plan.hpp"
#include "framework/node/node.hpp"

namespace tactor {

/// Measures the work of nodes from outside: nodes themselves are never wrapped, because what a NodeInfo calls takes its
/// node for one of its own class.
class NodeMeter {
 public:
  virtual ~NodeMeter() = default;
  /// What a node does, on the thread that does it.
  enum class Work : std::uint8_t { make, start, step };
  /// Before and after it, also where it throws; by index of the node in the plan.
  virtual void begin(std::size_t node, Work work) = 0;
  virtual void end(std::size_t node, Work work) = 0;
};

/// One instance of each node of a plan. The plan must outlive it.
class PlanNodes {
 public:
  /// Makes the nodes. Throws YamlError with the node's place and name where a node refuses its input. `meter` is told
  /// of their work; it outlives this, and is null where nobody asks; so is `flight`, where lines tell their cycles.
  explicit PlanNodes(const Plan& plan, NodeMeter* meter = nullptr, FlightRing* flight = nullptr);

  /// In a reference run: every node meets its counterpart in the run under test.
  void follow(const PlanNodes& tested);
  /// Calls `start` of node `index`; throws as `step` does.
  void start(std::size_t index, StepContext& context);
  /// Steps node `index`. Throws InputError or RunError with the node's name where the step throws.
  void step(std::size_t index, StepContext& context);
  /// Between two steps: gives node `index` new parameters, or, if `params` is null, tells it that a request is done.
  void set(std::size_t index, const void* params);

  [[nodiscard]] const Plan& plan() const { return plan_; }
  /// What the nodes said of their input while they were made, and what `note` added.
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }
  void note(std::string text) { notes_.push_back(std::move(text)); }
  [[nodiscard]] std::size_t size() const { return nodes_.size(); }
  [[nodiscard]] Node& operator[](std::size_t index) { return *nodes_[index]; }
  [[nodiscard]] const Node& operator[](std::size_t index) const { return *nodes_[index]; }

 private:
  /// Calls `work(node)`; what it throws gets the node's name.
  template <class Work>
  void guarded(std::size_t index, Time now, const Work& work);

  const Plan& plan_;
  NodeMeter* meter_;
  std::vector<std::string> notes_;
  std::vector<std::unique_ptr<Node>> nodes_;
};

/// Refuses what the nodes of plans would refuse when they are made. A node that has passed in the same scene is not
/// checked again, so that the rows of a study, which share most of theirs, take little more than one.
class NodeChecks {
 public:
  /// The notes that the nodes would tell, of those that are checked for the first time; no device is opened. Throws
  /// YamlError with the errors of all nodes.
  std::vector<std::string> check(const Plan& plan);

 private:
  std::set<std::string> passed_;  // resolved nodes with all that their checks may ask for
};

/// The same for one plan.
std::vector<std::string> check_nodes(const Plan& plan);
/// What a node tells when it is checked.
struct NodeNotes {
  std::vector<std::string> notes;
  std::vector<LimitedParameter> limits;
};
/// The same for one node of a graph.
NodeNotes check_node(const GraphSpec& graph, const NodeSpec& spec);

}  // namespace tactor
