#include "framework/engine/virtual_clock.hpp"

#include <ctime>

namespace tactor {

std::int64_t thread_cpu_ns() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

VirtualClock::VirtualClock(const Plan& plan, bool measure_cpu)
    : plan_(plan),
      measure_cpu_(measure_cpu),
      nodes_(plan),
      node_statistics_(plan.nodes.size()),
      edge_statistics_(plan.edges.size()) {
  for (const NodeSpec& spec : plan.nodes) costs_.emplace_back(spec.cost, plan.graph.seed, spec.name);
}

void VirtualClock::run(RunObserver& observer) {
  Dispatcher dispatcher(nodes_, observer);
  try {
    run_to_end(dispatcher, observer);
  } catch (...) {
    keep_statistics(dispatcher);
    throw;
  }
  keep_statistics(dispatcher);
}

void VirtualClock::keep_statistics(const Dispatcher& dispatcher) {
  now_ = dispatcher.now();
  for (std::size_t n = 0; n < node_statistics_.size(); ++n) {
    node_statistics_[n].steps = dispatcher.steps(n);
    node_statistics_[n].missed_ticks = dispatcher.missed_ticks(n);
  }
  for (std::size_t e = 0; e < edge_statistics_.size(); ++e) edge_statistics_[e] = dispatcher.edge_statistics(e);
}

void VirtualClock::run_to_end(Dispatcher& dispatcher, RunObserver& observer) {
  const Time end = Time{} + plan_.graph.duration;
  constexpr Duration progress_period{10'000'000};
  Time next_progress = Time{} + progress_period;
  // What the starts sent at time zero may have made nodes ready before any event.
  dispatcher.start();
  for (;;) {
    dispatcher.handle_due();
    if (const auto request = dispatcher.next_request()) {
      step(dispatcher, *request, observer);
      continue;
    }
    const std::optional<Time> next = dispatcher.next_event();
    if (!next || *next >= end) break;
    dispatcher.move_to(*next);
    if (dispatcher.now() >= next_progress) {
      if (!observer.on_progress(dispatcher.now())) return;
      next_progress = dispatcher.now() + progress_period;
    }
  }
  dispatcher.move_to(end);
  observer.on_progress(end);
}

void VirtualClock::step(Dispatcher& dispatcher, const Dispatcher::StepRequest& request, RunObserver& observer) {
  StepContext context(request.now, request.phase);
  const std::int64_t cpu_begin = measure_cpu_ ? thread_cpu_ns() : 0;
  nodes_.step(request.node, context);
  if (measure_cpu_) {
    node_statistics_[request.node].add_cpu({thread_cpu_ns() - cpu_begin});
  }
  const Duration cost = costs_[request.node].next(context.work());
  observer.on_step(request.node, request.now, cost);
  if (cost.ns > 0) {
    dispatcher.complete_at(request.node, request.now + cost);
  } else {
    dispatcher.complete(request.node);
  }
}

}  // namespace tactor
