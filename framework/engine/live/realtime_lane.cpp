#include "framework/engine/live/realtime_lane.hpp"

#include <algorithm>

#include "framework/core/messages.hpp"

namespace tactor {

namespace {

/// Room for a quarter of a second of a 1 kHz device, should the engine be kept from draining.
constexpr std::size_t ticks_held = 256;

double rate_of(const NodeSpec& spec) {
  TACTOR_DEMAND(spec.info->rate_parameter.has_value());
  return std::get<double>(spec.params[*spec.info->rate_parameter]);
}

}  // namespace

RealtimeLane::RealtimeLane(PlanNodes& nodes, std::size_t node, const ThreadSettings& settings)
    : nodes_(nodes),
      node_(node),
      schedule_(rate_of(nodes.plan().nodes[node])),
      end_to_end_(std::make_unique<LatencyHistogram>()),
      loop_({.name = nodes.plan().nodes[node].name, .rate = schedule_.rate(), .thread = settings},
            [this](const Tick& t) { tick(t); }) {
  const Plan& plan = nodes.plan();
  const NodeInfo& info = *plan.nodes[node].info;
  for (std::size_t e = 0; e < plan.edges.size(); ++e) {
    const PlannedEdge& edge = plan.edges[e];
    if (edge.to != node) continue;
    In in;
    in.edge = e;
    in.input = &info.inputs[edge.input].access(nodes[node]);
    in.is_force = &in.input->type() == &message_type<ForceSegment>();
    in.age = std::make_unique<LatencyHistogram>();
    inputs_.push_back(std::move(in));
  }
  std::size_t largest = 0;
  for (const OutputInfo& output : info.outputs) {
    outputs_.push_back(&output.access(nodes[node]));
    largest = std::max(largest, output.type->size);
    TACTOR_DEMAND(output.type->arrays.empty());
  }
  out_ = std::make_unique<Ring>(ticks_held * (outputs_.size() + 1), largest);
  out_payload_.resize(largest);
}

void RealtimeLane::put(std::size_t edge, const Stamp& stamp, const void* payload) {
  const auto in = std::find_if(inputs_.begin(), inputs_.end(), [edge](const In& i) { return i.edge == edge; });
  TACTOR_DEMAND(in != inputs_.end());
  in->input->queue().push(stamp, payload);
}

const LatencyHistogram* RealtimeLane::age(std::size_t edge) const {
  const auto in = std::find_if(inputs_.begin(), inputs_.end(), [edge](const In& i) { return i.edge == edge; });
  return in == inputs_.end() ? nullptr : in->age.get();
}

bool RealtimeLane::take(Out& out) {
  RecordHeader header;
  if (!out_->pop(header, out_payload_.data())) return false;
  out = {header.port, header.stamp.valid, out_payload_.data()};
  return true;
}

void RealtimeLane::take_in(In& in, Time deadline) {
  EdgeQueue& queue = in.input->queue();
  queue.admit(deadline);
  const MessageView newest = queue.newest();
  if (!newest) return;
  in.age->record(deadline - newest.stamp->produced);
  if (in.is_force && newest.stamp->valid > in.newest_valid) {
    in.newest_valid = newest.stamp->valid;
    end_to_end_->record(deadline - newest.stamp->valid);
  }
}

void RealtimeLane::tick(const Tick& tick) {
  for (In& in : inputs_) take_in(in, tick.deadline);
  StepContext context(tick.deadline, phase_.load(std::memory_order_acquire));
  nodes_.step(node_, context);
  for (In& in : inputs_) in.input->queue().mark_seen();
  RecordHeader header;
  header.tick = tick.number;
  for (std::size_t o = 0; o < outputs_.size(); ++o) {
    OutputBase& output = *outputs_[o];
    header.port = static_cast<std::int32_t>(o);
    header.size = static_cast<std::uint32_t>(output.type().size);
    for (std::size_t i = 0; i < output.pending(); ++i) {
      header.stamp.valid = output.pending_valid(i);
      out_->push(header, output.pending_value(i));
    }
    output.clear_pending();
  }
  header.port = step_done;
  header.size = 0;
  header.stamp.valid = tick.deadline;
  out_->push(header, &header);  // no payload
  if (context.phase() == Phase::stopping && context.at_rest()) at_rest_.store(true, std::memory_order_release);
}

}  // namespace tactor
