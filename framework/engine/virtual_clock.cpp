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
      node_figures_(plan.nodes.size()),
      edge_figures_(plan.edges.size()) {
  for (const NodeSpec& spec : plan.nodes) costs_.emplace_back(spec.cost, plan.graph.seed, spec.name);
}

void VirtualClock::run(RunObserver& observer) {
  Dispatcher dispatcher(nodes_, observer);
  try {
    run_to_end(dispatcher, observer);
  } catch (...) {
    keep_figures(dispatcher);
    throw;
  }
  keep_figures(dispatcher);
}

void VirtualClock::keep_figures(const Dispatcher& dispatcher) {
  now_ = dispatcher.now();
  for (std::size_t n = 0; n < node_figures_.size(); ++n) {
    node_figures_[n].steps = dispatcher.steps(n);
    node_figures_[n].missed_ticks = dispatcher.missed_ticks(n);
  }
  for (std::size_t e = 0; e < edge_figures_.size(); ++e) edge_figures_[e] = dispatcher.edge_figures(e);
}

void VirtualClock::run_to_end(Dispatcher& dispatcher, RunObserver& observer) {
  const Time end = Time{} + plan_.graph.duration;
  constexpr Duration progress_period{10'000'000};
  Time next_progress = Time{} + progress_period;
  // What the starts sent at time zero may have made nodes ready before any event.
  dispatcher.start();
  for (;;) {
    dispatcher.handle_due();
    if (const auto begun = dispatcher.begin_next()) {
      step(dispatcher, *begun, observer);
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

void VirtualClock::step(Dispatcher& dispatcher, const Dispatcher::Begun& begun, RunObserver& observer) {
  StepContext context(begun.now, begun.phase);
  const std::int64_t cpu_begin = measure_cpu_ ? thread_cpu_ns() : 0;
  nodes_.step(begun.node, context);
  if (measure_cpu_) {
    node_figures_[begun.node].add_cpu({thread_cpu_ns() - cpu_begin});
  }
  const Duration cost = costs_[begun.node].next(context.work());
  observer.on_step(begun.node, begun.now, cost);
  if (cost.ns > 0) {
    dispatcher.free_at(begun.node, begun.now + cost);
  } else {
    dispatcher.free(begun.node);
  }
}

}  // namespace tactor
