#include "framework/engine/virtual_clock.hpp"

#include <algorithm>
#include <ctime>
#include <utility>

namespace tactor {

std::int64_t thread_cpu_ns() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

VirtualClock::VirtualClock(const Plan& plan, bool measure_cpu, std::vector<bool> external, ExternalInputs* inputs,
                           NodeMeter* meter)
    : plan_(plan),
      measure_cpu_(measure_cpu),
      nodes_(plan, meter),
      dispatcher_(nodes_, std::move(external), inputs),
      node_statistics_(plan.nodes.size()) {
  for (const NodeSpec& spec : plan.nodes) costs_.emplace_back(spec.cost, plan.graph.seed, spec.name);
}

NodeStatistics VirtualClock::node_statistics(std::size_t index) const {
  NodeStatistics statistics = node_statistics_[index];
  statistics.steps = dispatcher_.steps(index);
  statistics.missed_ticks = dispatcher_.missed_ticks(index);
  return statistics;
}

void VirtualClock::start() {
  dispatcher_.start();
}

void VirtualClock::advance_to(Time t) {
  TACTOR_DEMAND(t >= now());
  while (now() < t) {
    // What was sent at this instant, by a start or from outside, may have made nodes ready before any event.
    dispatcher_.handle_due();
    if (const auto request = dispatcher_.next_request()) {
      step(*request);
      continue;
    }
    const std::optional<Time> next = dispatcher_.next_event();
    dispatcher_.move_to(next ? std::min(*next, t) : t);
  }
}

void VirtualClock::step(const Dispatcher::StepRequest& request) {
  StepContext context(request.now, request.phase);
  const std::int64_t cpu_begin = measure_cpu_ ? thread_cpu_ns() : 0;
  nodes_.step(request.node, context);
  if (measure_cpu_) {
    const Duration taken{thread_cpu_ns() - cpu_begin};
    node_statistics_[request.node].add_cpu(taken);
    if (!step_times_.empty()) step_times_[request.node].push_back(taken);
  }
  const Duration cost = costs_[request.node].next(context.work());
  if (cost.ns > 0) {
    dispatcher_.complete_at(request.node, request.now + cost);
  } else {
    dispatcher_.complete(request.node);
  }
}

}  // namespace tactor
