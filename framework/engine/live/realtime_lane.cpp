#include "framework/engine/live/realtime_lane.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "framework/core/messages.hpp"
#include "framework/engine/run_events.hpp"

namespace tactor {

namespace {

/// Room for a quarter of a second of a 1 kHz device, should the engine be kept from draining.
constexpr std::size_t ticks_held = 256;
/// Changes of parameters that may wait for a tick.
constexpr std::size_t most_tunings = 64;
/// Messages that a tick may send.
constexpr std::size_t most_sent = 16;
/// The port of what tells that a tick is over.
constexpr std::int32_t tick_done = -1;

std::size_t largest_payload(const NodeInfo& info) {
  std::size_t largest = sizeof(TickEvent);
  for (const OutputInfo& output : info.outputs) largest = std::max(largest, output.type->size);
  return largest;
}

double rate_of(const NodeSpec& spec) {
  TACTOR_DEMAND(spec.info->rate_parameter.has_value());
  return std::get<double>(spec.params[*spec.info->rate_parameter]);
}

}  // namespace

RealtimeLane::RealtimeLane(PlanNodes& nodes, std::size_t node, const std::vector<std::size_t>& edges,
                           const ThreadSettings& settings)
    : nodes_(nodes),
      node_(node),
      schedule_(rate_of(nodes.plan().nodes[node])),
      tick_(nodes, node, edges),
      tuned_(most_tunings, sizeof(const void*)),
      sent_payloads_(most_sent, largest_payload(*nodes.plan().nodes[node].info)),
      end_to_end_(std::make_unique<LatencyHistogram>()),
      loop_({.name = nodes.plan().nodes[node].name, .rate = schedule_.rate(), .thread = settings},
            [this](const Tick& t) { tick(t); }) {
  const Plan& plan = nodes.plan();
  const NodeInfo& info = *plan.nodes[node].info;
  for (const InputBase* input : tick_.inputs()) {
    inputs_.push_back(
        {&input->type() == &message_type<ForceSegment>(), Time{INT64_MIN}, std::make_unique<LatencyHistogram>()});
  }
  if (inputs_.size() > TickEvent::most_inputs) {
    throw InputError("node " + plan.nodes[node].name + ": " + std::to_string(inputs_.size()) +
                     " edges end there, and " + std::to_string(TickEvent::most_inputs) +
                     " are allowed in the real-time lane; put the node into another lane");
  }
  const std::size_t largest = largest_payload(info);
  sent_.reserve(most_sent);
  for (const OutputInfo& output : info.outputs) TACTOR_DEMAND(output.type->arrays.empty());
  out_ = std::make_unique<Ring>(ticks_held * (info.outputs.size() + 1), largest);
  out_payload_.resize(largest);
}

std::optional<std::size_t> RealtimeLane::input_of(std::size_t edge) const {
  const std::vector<std::size_t>& edges = tick_.edges();
  const auto found = std::find(edges.begin(), edges.end(), edge);
  return found == edges.end() ? std::nullopt : std::optional(static_cast<std::size_t>(found - edges.begin()));
}

void RealtimeLane::put(std::size_t edge, const Stamp& stamp, const void* payload) {
  tick_.inputs()[input_of(edge).value()]->queue().push(stamp, payload);
}

bool RealtimeLane::tune(std::shared_ptr<const void> params) {
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

const LatencyHistogram* RealtimeLane::age(std::size_t edge) const {
  const auto input = input_of(edge);
  return input ? inputs_[*input].age.get() : nullptr;
}

bool RealtimeLane::take_tick() {
  if (std::exchange(tick_taken_, false)) sent_.clear();
  RecordHeader header;
  while (out_->pop(header, out_payload_.data())) {
    if (header.port == tick_done) {
      std::memcpy(&event_, out_payload_.data(), sizeof event_);
      deadline_ = header.stamp.valid;
      return tick_taken_ = true;
    }
    // More than there is room for are there only where the ring has lost the end of a tick.
    if (sent_.size() == most_sent) continue;
    std::byte* payload = sent_payloads_[sent_.size()];
    std::memcpy(payload, out_payload_.data(), header.size);
    sent_.push_back({static_cast<std::size_t>(header.port), header.stamp.valid, payload});
  }
  return false;
}

void RealtimeLane::take_in(In& in, EdgeQueue& queue, Time deadline) {
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
  RecordHeader header;
  for (const void* params = nullptr; tuned_.pop(header, &params);) {
    nodes_.set(node_, params);
    applied_.fetch_add(1, std::memory_order_release);
  }
  StepContext context(tick.deadline, phase_.load(std::memory_order_acquire));
  header.tick = tick.number;
  tick_.make(
      context, [&](std::size_t i, EdgeQueue& queue) { take_in(inputs_[i], queue, tick.deadline); },
      [&](std::size_t output, Time valid, const void* value) {
        header.port = static_cast<std::int32_t>(output);
        header.size = static_cast<std::uint32_t>(tick_.outputs()[output]->type().size);
        header.stamp.valid = valid;
        out_->push(header, value);
      });
  TickEvent event{.node = static_cast<std::int32_t>(node_),
                  .inputs = static_cast<std::int32_t>(inputs_.size()),
                  .tick = tick.number,
                  .phase = context.phase(),
                  .sets = applied_.load(std::memory_order_relaxed)};
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    if (const MessageView newest = tick_.inputs()[i]->queue().newest()) event.seen[i] = newest.stamp->sequence + 1;
  }
  header.port = tick_done;
  header.size = sizeof event;
  header.stamp.valid = tick.deadline;
  out_->push(header, &event);
  if (context.phase() == Phase::stopping && context.at_rest()) at_rest_.store(true, std::memory_order_release);
}

}  // namespace tactor
