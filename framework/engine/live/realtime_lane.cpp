#include "framework/engine/live/realtime_lane.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "framework/realtime/crash_note.hpp"
#include "framework/realtime/monotonic_clock.hpp"

namespace tactor {

namespace {

/// Room for a quarter of a second of a 1 kHz device, should the engine be kept from draining.
constexpr std::size_t ticks_held = 256;
/// How long after a tick the engine first looks for what the loop sent, and how often again until it is there.
constexpr Duration look_after{60'000};
constexpr Duration look_again{100'000};
/// Messages that a tick of a node may send.
constexpr std::size_t most_sent = 16;

std::size_t largest_payload(const Plan& plan, const std::vector<std::size_t>& chain) {
  std::size_t largest = sizeof(TickEvent);
  for (const std::size_t n : chain) {
    for (const OutputInfo& output : plan.nodes[n].info->outputs) largest = std::max(largest, output.type->size);
  }
  return largest;
}

Pace* pace_of(PlanNodes& nodes, const std::vector<std::size_t>& chain) {
  for (const std::size_t n : chain) {
    if (Pace* const pace = nodes[n].pace()) return pace;
  }
  return nullptr;
}

}  // namespace

RealtimeLane::RealtimeLane(PlanNodes& nodes, const Chains& chains, std::size_t chain, const ThreadSettings& settings,
                           FlightRing* flight)
    : schedule_(nodes.plan().nodes[chains.nodes[chain].front()].rate().value()),
      left_(chains.nodes[chain].size()),
      out_payload_(largest_payload(nodes.plan(), chains.nodes[chain])),
      sent_payloads_(most_sent, out_payload_.size()),
      pace_(pace_of(nodes, chains.nodes[chain])),
      loop_({.name = nodes.plan().nodes[chains.nodes[chain].front()].name,
             .rate = schedule_.rate(),
             .thread = settings,
             .pace = pace_},
            [this](const Tick& t) { tick(t); }) {
  for (const std::size_t n : chains.nodes[chain]) {
    nodes_.push_back(std::make_unique<LaneNode>(nodes, n, chains.inner, ports_.size(), flight));
    const std::size_t outputs = nodes.plan().nodes[n].info->outputs.size();
    for (std::size_t o = 0; o < outputs; ++o) ports_.push_back({n, o});
  }
  sent_.reserve(most_sent);
  out_ = std::make_unique<Ring>(ticks_held * (ports_.size() + nodes_.size()), out_payload_.size());
}

std::size_t RealtimeLane::position_of(std::size_t node) const {
  const auto is_it = [node](const auto& one) { return one->node() == node; };
  const auto found = std::find_if(nodes_.begin(), nodes_.end(), is_it);
  TACTOR_DEMAND(found != nodes_.end());
  return static_cast<std::size_t>(found - nodes_.begin());
}

std::exception_ptr RealtimeLane::failure(std::size_t node) const {
  const LaneNode& one = (*this)[node];
  // The last one's exception has ended the loop.
  return one.has_failed() ? one.failure() : loop_.failure();
}

bool RealtimeLane::take_tick() {
  if (std::exchange(tick_taken_, false)) sent_.clear();
  RecordHeader header;
  while (out_->pop(header, out_payload_.data())) {
    if (header.port == LaneNode::tick_done) {
      std::memcpy(&event_, out_payload_.data(), sizeof event_);
      deadline_ = header.stamp.valid;
      return tick_taken_ = true;
    }
    // More than there is room for are there only where the ring has lost the end of a tick.
    if (sent_.size() == most_sent) continue;
    std::byte* payload = sent_payloads_[sent_.size()];
    std::memcpy(payload, out_payload_.data(), header.size);
    const Port& port = ports_[static_cast<std::size_t>(header.port)];
    sent_.push_back({port.node, port.output, header.stamp.valid, payload});
  }
  return false;
}

Time RealtimeLane::next_look(Time now) const {
  // A tick that is due and has not been made yet is looked for soon, the next one when it will have been made.
  if (pace_ != nullptr) {
    const Duration period = Duration::from_rate(schedule_.rate());
    const Time first = deadline_ + period + look_after;
    if (now < first) return first;
    if (loop_.metrics().begun.value() != loop_.metrics().ended.value()) return now + look_again;
    return now + (now < first + period * 3 ? look_again : period);
  }
  const LoopStatistics& metrics = loop_.metrics();
  const std::int64_t due = schedule_.last_due(now);
  const Time next_tick = schedule_.deadline(due + 1);
  const bool awaited = due >= 0 && metrics.ended.value() + metrics.missed.value() <= due;
  return awaited ? std::min(now + look_again, next_tick) : next_tick + look_after;
}

void RealtimeLane::tick(const Tick& tick) {
  const Phase phase = phase_.load(std::memory_order_acquire);
  const Instant woke = MonotonicClock::now();
  Instant begun = woke;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    LaneNode& node = *nodes_[i];
    if (node.has_failed()) continue;
    stepping_.store(i, std::memory_order_relaxed);
    try {
      const SteppingNode stepping(node.node());
      node.tick(tick, phase, *out_);
    } catch (...) {
      if (--left_ == 0) throw;
      node.fail(std::current_exception());
    }
    const Instant ended = MonotonicClock::now();
    node.took(ended - begun);
    if (!node.has_failed()) node.tell_flight(tick, woke, ended - begun);
    begun = ended;
  }
  stepping_.store(0, std::memory_order_relaxed);
}

}  // namespace tactor
