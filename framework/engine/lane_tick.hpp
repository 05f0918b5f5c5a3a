// One tick of a node in the real-time lane: what it sees, its step, and what it sends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "framework/engine/dispatcher.hpp"
#include "framework/engine/plan_nodes.hpp"

namespace tactor {

/// The meaning of a tick, live and when it is made again. In it nothing allocates, locks, logs or waits.
class LaneTick {
 public:
  /// `inner`: Chains::inner. `nodes` and its plan must outlive it.
  LaneTick(PlanNodes& nodes, std::size_t node, const std::vector<bool>& inner)
      : nodes_(nodes), node_(node), readers_(nodes.plan().nodes[node].info->outputs.size()), sent_(readers_.size(), 0) {
    const Plan& plan = nodes.plan();
    for (const OutputInfo& output : plan.nodes[node].info->outputs) outputs_.push_back(&output.access(nodes[node]));
    for (std::size_t e = 0; e < plan.edges.size(); ++e) {
      const PlannedEdge& edge = plan.edges[e];
      InputBase& input = plan.nodes[edge.to].info->inputs[edge.input].access(nodes[edge.to]);
      if (inner[e] && edge.from == node) readers_[edge.output].push_back(&input);
      if (edge.to != node) continue;
      edges_.push_back(e);
      inputs_.push_back(&input);
    }
  }

  /// Before the first tick: what the node has sent in `start` counts.
  void count_from(const Dispatcher& started) {
    for (std::size_t o = 0; o < sent_.size(); ++o) sent_[o] = started.sent(node_, o);
  }

  /// The edges into the node, in the order of the plan.
  [[nodiscard]] const std::vector<std::size_t>& edges() const { return edges_; }
  /// The input at which each of them ends.
  [[nodiscard]] const std::vector<InputBase*>& inputs() const { return inputs_; }
  [[nodiscard]] const std::vector<OutputBase*>& outputs() const { return outputs_; }

  /// Calls `admit(i, queue)` for each edge, which lets the tick see its messages; steps the node; passes on what it
  /// sent on inner edges, produced at the time of the tick; and calls `send(output, valid, value)` for each message, in
  /// order.
  template <class Admit, class Send>
  void make(StepContext& context, const Admit& admit, const Send& send) {
    for (std::size_t i = 0; i < inputs_.size(); ++i) admit(i, inputs_[i]->queue());
    nodes_.step(node_, context);
    for (InputBase* input : inputs_) input->queue().mark_seen();
    for (std::size_t o = 0; o < outputs_.size(); ++o) {
      OutputBase& output = *outputs_[o];
      for (std::size_t i = 0; i < output.pending(); ++i) {
        const Time valid = output.pending_valid(i);
        const void* value = output.pending_value(i);
        const Stamp stamp{valid, context.now(), sent_[o]++};
        for (InputBase* reader : readers_[o]) reader->queue().push(stamp, value);
        send(o, valid, value);
      }
      output.clear_pending();
    }
  }

 private:
  PlanNodes& nodes_;
  const std::size_t node_;
  std::vector<std::size_t> edges_;
  std::vector<InputBase*> inputs_;
  std::vector<OutputBase*> outputs_;
  std::vector<std::vector<InputBase*>> readers_;  // by output: where its inner edges end
  std::vector<std::uint64_t> sent_;               // by output
};

}  // namespace tactor
