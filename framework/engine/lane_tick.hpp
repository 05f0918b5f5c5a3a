// One tick of a node in the real-time lane: what it sees, its step, and what it sends.
#pragma once

#include <cstddef>
#include <vector>

#include "framework/engine/plan_nodes.hpp"

namespace tactor {

/// The meaning of a tick, live and when it is made again. In it nothing allocates, locks, logs or waits.
class LaneTick {
 public:
  /// `edges`: Dispatcher::edges_into the node. All arguments must outlive it.
  LaneTick(PlanNodes& nodes, std::size_t node, const std::vector<std::size_t>& edges)
      : nodes_(nodes), node_(node), edges_(edges) {
    const Plan& plan = nodes.plan();
    const NodeInfo& info = *plan.nodes[node].info;
    for (const std::size_t e : edges) inputs_.push_back(&info.inputs[plan.edges[e].input].access(nodes[node]));
    for (const OutputInfo& output : info.outputs) outputs_.push_back(&output.access(nodes[node]));
  }

  /// The edges into the node.
  [[nodiscard]] const std::vector<std::size_t>& edges() const { return edges_; }
  /// The input at which each of them ends.
  [[nodiscard]] const std::vector<InputBase*>& inputs() const { return inputs_; }
  [[nodiscard]] const std::vector<OutputBase*>& outputs() const { return outputs_; }

  /// Calls `admit(i, queue)` for each edge, which lets the tick see its messages; steps the node; and calls
  /// `send(output, valid, value)` for each message that it sent, in order.
  template <class Admit, class Send>
  void make(StepContext& context, const Admit& admit, const Send& send) {
    for (std::size_t i = 0; i < inputs_.size(); ++i) admit(i, inputs_[i]->queue());
    nodes_.step(node_, context);
    for (InputBase* input : inputs_) input->queue().mark_seen();
    for (std::size_t o = 0; o < outputs_.size(); ++o) {
      OutputBase& output = *outputs_[o];
      for (std::size_t i = 0; i < output.pending(); ++i) send(o, output.pending_valid(i), output.pending_value(i));
      output.clear_pending();
    }
  }

 private:
  PlanNodes& nodes_;
  const std::size_t node_;
  const std::vector<std::size_t>& edges_;
  std::vector<InputBase*> inputs_;
  std::vector<OutputBase*> outputs_;
};

}  // namespace tactor
