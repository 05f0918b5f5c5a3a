#include "framework/engine/live/lane_node.hpp"

#include <algorithm>
#include <string>

#include "framework/core/messages.hpp"
#include "framework/realtime/device_node.hpp"

namespace tactor {

namespace {

/// Changes of parameters that may wait for a tick.
constexpr std::size_t most_tunings = 64;

}  // namespace

LaneNode::LaneNode(PlanNodes& nodes, std::size_t node, const std::vector<bool>& inner, std::size_t first_port,
                   FlightRing* flight)
    : nodes_(nodes),
      node_(node),
      first_port_(first_port),
      tick_(nodes, node, inner),
      tuned_(most_tunings, sizeof(const void*)),
      end_to_end_(std::make_unique<LatencyHistogram>()),
      body_time_(std::make_unique<LatencyHistogram>()) {
  const NodeSpec& spec = nodes.plan().nodes[node];
  if (flight != nullptr) {
    const bool is_device = dynamic_cast<const DeviceNode*>(&nodes[node]) != nullptr;
    flight_.emplace(FlightWriter{flight, node}, *spec.info, is_device, Duration::from_rate(spec.rate().value()));
  }
  for (const InputBase* input : tick_.inputs()) {
    inputs_.push_back(
        {&input->type() == &message_type<ForceSegment>(), Time{INT64_MIN}, std::make_unique<LatencyHistogram>()});
  }
  if (inputs_.size() > TickEvent::most_inputs) {
    throw InputError("node " + spec.name + ": " + std::to_string(inputs_.size()) + " edges end there, and " +
                     std::to_string(TickEvent::most_inputs) +
                     " are allowed in the real-time lane; put the node into another lane");
  }
  for (const OutputInfo& output : spec.info->outputs) TACTOR_DEMAND(output.type->arrays.empty());
}

std::optional<std::size_t> LaneNode::input_of(std::size_t edge) const {
  const std::vector<std::size_t>& edges = tick_.edges();
  const auto found = std::find(edges.begin(), edges.end(), edge);
  return found == edges.end() ? std::nullopt : std::optional(static_cast<std::size_t>(found - edges.begin()));
}

void LaneNode::put(std::size_t edge, const Stamp& stamp, const void* payload) {
  tick_.inputs()[input_of(edge).value()]->queue().push(stamp, payload);
}

bool LaneNode::tune(std::shared_ptr<const void> params) {
  for (const std::uint64_t applied = applied_.load(std::memory_order_acquire); tunings_ended_ < applied;
       ++tunings_ended_) {
    tunings_.pop_front();
  }
  const void* pointer = params.get();
  RecordHeader header;
  header.size = sizeof pointer;
  if (!tuned_.push(header, &pointer)) return false;
  tunings_.push_back(std::move(params));
  return true;
}

const LatencyHistogram* LaneNode::age(std::size_t edge) const {
  const auto input = input_of(edge);
  return input ? inputs_[*input].age.get() : nullptr;
}

void LaneNode::take_in(In& in, EdgeQueue& queue, Time deadline) {
  queue.admit(deadline);
  const MessageView newest = queue.newest();
  if (!newest) return;
  in.age->record(deadline - newest.stamp->produced);
  if (in.is_force && newest.stamp->valid > in.newest_valid) {
    in.newest_valid = newest.stamp->valid;
    end_to_end_->record(deadline - newest.stamp->valid);
  }
}

void LaneNode::tick(const Tick& tick, Phase phase, Ring& out) {
  RecordHeader header;
  for (const void* params = nullptr; tuned_.pop(header, &params);) {
    nodes_.set(node_, params);
    applied_.fetch_add(1, std::memory_order_release);
  }
  StepContext context(tick.deadline, phase);
  if (flight_) context.tell_flight(flight_->device());
  header.tick = tick.number;
  tick_.make(
      context, [&](std::size_t i, EdgeQueue& queue) { take_in(inputs_[i], queue, tick.deadline); },
      [&](std::size_t output, Time valid, const void* value) {
        header.port = static_cast<std::int32_t>(first_port_ + output);
        header.size = static_cast<std::uint32_t>(tick_.outputs()[output]->type().size);
        header.stamp.valid = valid;
        out.push(header, value);
        if (flight_) flight_->sent(output, value);
      });
  TickEvent event{.node = static_cast<std::int32_t>(node_),
                  .inputs = static_cast<std::int32_t>(inputs_.size()),
                  .tick = tick.number,
                  .phase = phase,
                  .sets = applied_.load(std::memory_order_relaxed)};
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    const MessageView newest = tick_.inputs()[i]->queue().newest();
    if (!newest) continue;
    event.seen[i] = newest.stamp->sequence + 1;
    if (flight_) flight_->age(i, tick.deadline - newest.stamp->valid);
  }
  header.port = tick_done;
  header.size = sizeof event;
  header.stamp.valid = tick.deadline;
  out.push(header, &event);
  if (phase == Phase::stopping && context.at_rest()) at_rest_.store(true, std::memory_order_release);
}

}  // namespace tactor
