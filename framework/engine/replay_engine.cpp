#include "framework/engine/replay_engine.hpp"

#include <algorithm>

namespace tactor {

namespace {

/// The costs of the nodes: the time that each step took.
std::vector<CostModel> costs_of(const Plan& plan, const RunLog& log) {
  std::vector<RunLog::Step> steps = log.steps;
  std::sort(steps.begin(), steps.end(), [](const auto& a, const auto& b) { return a.begun < b.begun; });
  CostModel trace;
  trace.kind = CostModel::Kind::trace;
  std::vector<CostModel> costs(plan.nodes.size(), trace);
  for (const RunLog::Step& step : steps) costs[step.node].trace.push_back(step.passed - step.begun);
  // A step that had not passed at the end is in no log: it lasts until after it.
  const Duration rest = (log.end - Time{}) * 2 + Duration{1'000'000'000};
  for (CostModel& cost : costs) cost.trace.push_back(rest);
  return costs;
}

}  // namespace

ReplayEngine::ReplayEngine(const Plan& plan, const RunLog& log, const EngineOptions& options)
    : VirtualEngine(plan, options, costs_of(plan, log), find_chains(plan), this),
      log_(log),
      chains_(find_chains(plan)),
      lanes_(plan.nodes.size()),
      tunings_(plan.nodes.size()),
      tuned_(plan.nodes.size(), 0) {
  using Kind = Event::Kind;
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    if (chains_.of[n]) lanes_[n].emplace(nodes(), n, chains_.inner);
  }
  for (const PlannedEdge& edge : plan.edges) {
    held_.emplace_back(*plan.nodes[edge.to].info->inputs[edge.input].type);
  }
  for (std::size_t i = 0; i < log.ticks.size(); ++i) events_.push_back({log.ticks[i].told, Kind::tick, i});
  for (std::size_t i = 0; i < log.sets.size(); ++i) events_.push_back({log.sets[i].stamp.produced, Kind::set, i});
  for (std::size_t i = 0; i < log.fed.size(); ++i) {
    const MessageBatch& messages = log.fed[i].messages;
    for (std::size_t m = 0; m < messages.size(); ++m) {
      events_.push_back({messages.stamp(m).produced, Kind::fed, i, m});
    }
  }
  if (log.stop) events_.push_back({*log.stop, Kind::stop});
  // No two of a live run are at one instant, but for what was fed at once.
  std::stable_sort(events_.begin(), events_.end(), [](const Event& a, const Event& b) { return a.time < b.time; });
}

void ReplayEngine::start() {
  VirtualEngine::start();
  for (auto& lane : lanes_) {
    if (lane) lane->count_from(dispatcher());
  }
}

void ReplayEngine::on_arrival(std::size_t edge, const Stamp& stamp, const void* payload) {
  if (!chains_.inner[edge]) return held_[edge].push(stamp, payload);
  const PlannedEdge& planned = plan_.edges[edge];
  plan_.nodes[planned.to].info->inputs[planned.input].access(nodes()[planned.to]).queue().push(stamp, payload);
}

void ReplayEngine::advance_to(Time t) {
  for (; next_ < events_.size() && events_[next_].time < t; ++next_) {
    VirtualEngine::advance_to(events_[next_].time);
    make(events_[next_]);
  }
  VirtualEngine::advance_to(t);
}

void ReplayEngine::make(const Event& event) {
  switch (event.kind) {
    case Event::Kind::tick:
      tick(log_.ticks[event.index]);
      break;
    case Event::Kind::set: {
      const RunLog::Set& made = log_.sets[event.index];
      if (!lanes_[made.node]) return set(made.node, made.params, made.event);
      // Its tick takes them.
      dispatcher().tell_set(now(), made.event);
      tunings_[made.node].push_back(made.params);
      break;
    }
    case Event::Kind::fed: {
      const RunLog::Fed& fed = log_.fed[event.index];
      dispatcher().publish(fed.node, fed.output, fed.messages.stamp(event.message).valid,
                           fed.messages.value(event.message));
      break;
    }
    case Event::Kind::stop:
      dispatcher().stop();
      break;
  }
}

void ReplayEngine::check_seen(std::size_t edge, const RunLog::Tick& tick, std::uint64_t seen,
                              const MessageView& newest) const {
  if (seen == (newest ? newest.stamp->sequence + 1 : 0)) return;
  throw InputError("the recording cannot be replayed: at " + std::to_string(tick.deadline.seconds()) + " s, edge " +
                   plan_.edges[edge].spec.name() +
                   " had another message; the recording has lost ticks, or comes from a version of tactor in which " +
                   plan_.nodes[plan_.edges[edge].to].name + " had a loop of its own");
}

void ReplayEngine::tick(const RunLog::Tick& tick) {
  const auto node = static_cast<std::size_t>(tick.event.node);
  LaneTick& lane = *lanes_[node];
  for (; tuned_[node] < tick.event.sets && tuned_[node] < tunings_[node].size(); ++tuned_[node]) {
    nodes().set(node, tunings_[node][tuned_[node]].get());
  }
  StepContext context(tick.deadline, tick.event.phase);
  lane.make(
      context,
      [&](std::size_t i, EdgeQueue& queue) {
        const std::size_t edge = lane.edges()[i];
        HeldMessages& held = held_[edge];
        for (; !held.empty() && held.stamp().sequence < tick.event.seen[i]; held.pop())
          queue.push(held.stamp(), held.value());
        queue.admit();
        if (chains_.inner[edge]) check_seen(edge, tick, tick.event.seen[i], queue.newest());
      },
      [&](std::size_t output, Time valid, const void* value) { dispatcher().publish(node, output, valid, value); });
  dispatcher().tell_tick(tick.deadline, tick.told, tick.event);
  dispatcher().passed(node, tick.deadline);
}

}  // namespace tactor
