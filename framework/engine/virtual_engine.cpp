#include "framework/engine/virtual_engine.hpp"

#include <algorithm>
#include <utility>

#include "framework/core/clock.hpp"
#include "framework/realtime/monotonic_clock.hpp"

namespace tactor {

namespace {

/// A slice of a paced run.
constexpr Duration paced_period{2'000'000};
/// Requests of nodes are done at multiples of it, so that they are the same for any division into advances.
constexpr Duration request_period{1'000'000};

std::vector<CostModel> costs_of(const Plan& plan) {
  std::vector<CostModel> costs;
  for (const NodeSpec& spec : plan.nodes) costs.push_back(spec.cost);
  return costs;
}

bool has_requests(const Plan& plan) {
  return std::any_of(plan.nodes.begin(), plan.nodes.end(), [](const NodeSpec& spec) { return bool{spec.info->sets}; });
}

}  // namespace

VirtualEngine::VirtualEngine(const Plan& plan, const EngineOptions& options)
    : VirtualEngine(plan, options, costs_of(plan), {}, nullptr) {}

VirtualEngine::VirtualEngine(const Plan& plan, const EngineOptions& options, const std::vector<CostModel>& costs,
                             Chains chains, ExternalInputs* lanes)
    : plan_(plan),
      options_(options),
      // A log tells what was set when its run is made again.
      serves_(lanes == nullptr && has_requests(plan)),
      nodes_(plan, options.meter),
      dispatcher_(nodes_, std::move(chains), lanes),
      node_statistics_(plan.nodes.size()),
      step_times_(plan.nodes.size()) {
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    costs_.emplace_back(costs[n], plan.graph.seed, plan.nodes[n].name);
  }
}

bool VirtualEngine::feed(std::size_t node, std::optional<Time> valid, std::span<const FedValue> values) {
  if (dispatcher_.is_blocked(node)) return false;
  for (const FedValue& fed : values) dispatcher_.publish(node, fed.output, valid.value_or(now()), fed.value);
  return true;
}

void VirtualEngine::set(std::size_t node, std::shared_ptr<const void> params, const SetEvent& event) {
  nodes_.set(node, params.get());
  dispatcher_.tell_set(now(), event);
}

void VirtualEngine::advance(Duration duration, const Attendance& attendance) {
  const Time from = now(), until = std::min(from + duration, end());
  const Instant begun = MonotonicClock::now();
  try {
    while (now() < until && !stopped_) {
      advance_and_serve(options_.pace > 0 ? std::min(now() + paced_period, until) : until, attendance);
      if (stop_asked_()) stopped_ = true;
      if (options_.pace == 0) continue;
      attendance.read();
      MonotonicClock::sleep_until(begun + Duration::from_seconds((now() - from).seconds() / options_.pace));
    }
  } catch (const std::exception&) {
    // Readers still get the messages from before the failure.
    try {
      attendance.read();
    } catch (const std::exception&) {
      // The first failure is the one that is told.
    }
    throw;
  }
  attendance.read();
}

void VirtualEngine::advance_and_serve(Time t, const Attendance& attendance) {
  while (serves_ && now() < t && !stopped_) {
    const Time next{(now().ns / request_period.ns + 1) * request_period.ns};
    advance_to(std::min(t, next));
    if (now() == next) attendance.serve();
  }
  if (!stopped_) advance_to(t);
}

void VirtualEngine::advance_to(Time t) {
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

void VirtualEngine::step(const Dispatcher::StepRequest& request) {
  StepContext context(request.now, request.phase);
  const Duration cpu_begin = options_.measure_cpu ? clock_time(CLOCK_THREAD_CPUTIME_ID) : Duration{};
  nodes_.step(request.node, context);
  if (options_.measure_cpu) {
    const Duration taken = clock_time(CLOCK_THREAD_CPUTIME_ID) - cpu_begin;
    node_statistics_[request.node].add_cpu(taken);
    if (options_.keeps_step_times) step_times_[request.node].push_back(taken);
  }
  const Duration cost = costs_[request.node].next(context.work());
  if (cost.ns > 0) {
    dispatcher_.complete_at(request.node, request.now + cost);
  } else {
    dispatcher_.complete(request.node);
  }
}

void VirtualEngine::stop(const std::string& why) {
  if (!why.empty() && !failure_) failure_ = why;
  stopped_ = true;
}

void VirtualEngine::finish(const Attendance& attendance) {
  stopped_ = true;
  attendance.read();
}

NodeStatistics VirtualEngine::node_statistics(std::size_t node) const {
  NodeStatistics statistics = node_statistics_[node];
  statistics.steps = dispatcher_.steps(node);
  statistics.missed_ticks = dispatcher_.missed_ticks(node);
  return statistics;
}

Duration VirtualEngine::cpu_time() const {
  return clock_time(CLOCK_THREAD_CPUTIME_ID);
}

}  // namespace tactor
