#include "framework/engine/replay_clock.hpp"

#include <algorithm>
#include <utility>

namespace tactor {

namespace {

/// The plan with what each step took as its cost.
Plan with_costs(Plan plan, const RunLog& log) {
  std::vector<RunLog::Step> steps = log.steps;
  std::sort(steps.begin(), steps.end(), [](const auto& a, const auto& b) { return a.begun < b.begun; });
  for (NodeSpec& node : plan.nodes) {
    node.cost = {};
    node.cost.kind = CostModel::Kind::trace;
  }
  for (const RunLog::Step& step : steps) plan.nodes[step.node].cost.trace.push_back(step.passed - step.begun);
  // A step that had not passed at the end is in no log: it lasts until after it.
  const Duration rest = (log.end - Time{}) * 2 + Duration{1'000'000'000};
  for (NodeSpec& node : plan.nodes) node.cost.trace.push_back(rest);
  return plan;
}

std::vector<bool> lanes_of(const Plan& plan) {
  std::vector<bool> external;
  for (const NodeSpec& node : plan.nodes) external.push_back(node.scheduling.lane == Lane::realtime);
  return external;
}

}  // namespace

ReplayClock::ReplayClock(const Plan& plan, const RunLog& log)
    : log_(log),
      plan_(with_costs(plan, log)),
      external_(lanes_of(plan)),
      clock_(std::make_unique<VirtualClock>(plan_, false, external_, this)),
      tunings_(plan.nodes.size()),
      tuned_(plan.nodes.size(), 0) {
  using Kind = Event::Kind;
  for (const PlannedEdge& edge : plan_.edges) {
    held_.emplace_back(*plan_.nodes[edge.to].info->inputs[edge.input].type);
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
  // No two of a live run are at one instant.
  std::stable_sort(events_.begin(), events_.end(), [](const Event& a, const Event& b) { return a.time < b.time; });
}

void ReplayClock::on_arrival(std::size_t edge, const Stamp& stamp, const void* payload) {
  held_[edge].push(stamp, payload);
}

void ReplayClock::advance_to(Time t) {
  for (; next_ < events_.size() && events_[next_].time < t; ++next_) {
    clock_->advance_to(events_[next_].time);
    make(events_[next_]);
  }
  clock_->advance_to(t);
}

void ReplayClock::make(const Event& event) {
  Dispatcher& dispatcher = clock_->dispatcher();
  switch (event.kind) {
    case Event::Kind::tick:
      tick(log_.ticks[event.index]);
      break;
    case Event::Kind::set: {
      const RunLog::Set& set = log_.sets[event.index];
      if (tell_set_) tell_set_(set);
      if (external_[set.node]) {
        tunings_[set.node].push_back(set.params);
      } else {
        plan_.nodes[set.node].info->tune(clock_->nodes()[set.node], set.params.get());
      }
      break;
    }
    case Event::Kind::fed: {
      const RunLog::Fed& fed = log_.fed[event.index];
      dispatcher.publish(fed.node, 0, fed.messages.stamp(event.message).valid, fed.messages.value(event.message));
      break;
    }
    case Event::Kind::stop:
      dispatcher.stop();
      break;
  }
}

void ReplayClock::tick(const RunLog::Tick& tick) {
  Dispatcher& dispatcher = clock_->dispatcher();
  PlanNodes& nodes = clock_->nodes();
  const auto node = static_cast<std::size_t>(tick.event.node);
  const NodeInfo& info = *plan_.nodes[node].info;
  for (; tuned_[node] < tick.event.sets && tuned_[node] < tunings_[node].size(); ++tuned_[node]) {
    info.tune(nodes[node], tunings_[node][tuned_[node]].get());
  }
  const std::vector<std::size_t>& edges = dispatcher.edges_into(node);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    HeldMessages& held = held_[edges[i]];
    EdgeQueue& queue = info.inputs[plan_.edges[edges[i]].input].access(nodes[node]).queue();
    for (; !held.empty() && held.stamp().sequence < tick.event.seen[i]; held.pop())
      queue.push(held.stamp(), held.value());
    queue.admit();
  }
  StepContext context(tick.deadline, tick.event.phase);
  nodes.step(node, context);
  for (const std::size_t edge : edges) {
    info.inputs[plan_.edges[edge].input].access(nodes[node]).queue().mark_seen();
  }
  for (std::size_t o = 0; o < info.outputs.size(); ++o) {
    OutputBase& output = info.outputs[o].access(nodes[node]);
    for (std::size_t i = 0; i < output.pending(); ++i) {
      dispatcher.publish(node, o, output.pending_valid(i), output.pending_value(i));
    }
    output.clear_pending();
  }
  dispatcher.tell_tick(tick.deadline, tick.told, tick.event);
  dispatcher.passed(node, tick.deadline);
}

}  // namespace tactor
