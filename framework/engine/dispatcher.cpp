#include "framework/engine/dispatcher.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace tactor {

bool Dispatcher::Later::operator()(const Event& a, const Event& b) const {
  if (a.time != b.time) return a.time > b.time;
  // Ticks last: a node whose step has passed at this instant is free, and does not miss its tick.
  const bool a_ticks = a.kind == Event::Kind::tick, b_ticks = b.kind == Event::Kind::tick;
  return a_ticks != b_ticks ? a_ticks : a.count > b.count;
}

Dispatcher::Dispatcher(PlanNodes& nodes, Chains chains, ExternalInputs* inputs)
    : nodes_(nodes), plan_(nodes.plan()), external_(inputs) {
  chains.of.resize(nodes.size());
  chains.inner.resize(plan_.edges.size());
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const NodeSpec& spec = plan_.nodes[n];
    NodeState state;
    state.external = chains.of[n].has_value();
    TACTOR_DEMAND(!state.external || external_ != nullptr);
    state.rate = spec.rate().value_or(0);
    for (const InputInfo& input : spec.info->inputs) state.inputs.push_back(&input.access(nodes_[n]));
    for (const OutputInfo& output : spec.info->outputs) state.outputs.push_back(&output.access(nodes_[n]));
    const std::size_t outputs = state.outputs.size();
    state.sequence.resize(outputs);
    state.edges_out.resize(outputs);
    state.taps.resize(outputs);
    for (const OutputBase* output : state.outputs) state.held.emplace_back(output->type());
    states_.push_back(std::move(state));
  }
  connect();
  for (std::size_t e = 0; e < edges_.size(); ++e) edges_[e].is_inner = chains.inner[e];
  find_groups();
  find_awaited();
}

void Dispatcher::connect() {
  for (std::size_t i = 0; i < plan_.edges.size(); ++i) {
    const PlannedEdge& edge = plan_.edges[i];
    const NodeInfo& reader = *plan_.nodes[edge.to].info;
    EdgeState state(*states_[edge.to].inputs[edge.input]);
    state.input->configure(edge.spec.queue);
    state.to_sink = reader.sink;
    if (edge.triggers && edge.spec.queue.policy != QueuePolicy::latest) {
      states_[edge.to].trigger_queues.push_back(state.input);
    }
    states_[edge.from].edges_out[edge.output].push_back(i);
    states_[edge.to].edges_in.push_back(i);
    edges_.push_back(std::move(state));
  }
  for (NodeState& state : states_) {
    for (std::size_t o = 0; o < state.outputs.size(); ++o) find_wanted(state, o);
  }
}

void Dispatcher::find_wanted(NodeState& state, std::size_t output) {
  state.outputs[output]->set_wanted(!state.edges_out[output].empty() || !state.taps[output].empty());
}

void Dispatcher::add_tap(std::size_t node, std::size_t output, Tap& tap) {
  NodeState& state = states_[node];
  TACTOR_DEMAND(same_type(tap.type(), state.outputs[output]->type()));
  state.taps[output].push_back(&tap);
  find_wanted(state, output);
}

void Dispatcher::add_arrival_tap(std::size_t edge, Tap& tap) {
  TACTOR_DEMAND(same_type(tap.type(), edges_[edge].input->type()));
  edges_[edge].taps.push_back(&tap);
}

void Dispatcher::remove_tap(const Tap& tap) {
  std::erase(step_taps_, &tap);
  std::erase(tick_taps_, &tap);
  std::erase(set_taps_, &tap);
  std::erase(stop_taps_, &tap);
  for (EdgeState& edge : edges_) std::erase(edge.taps, &tap);
  for (NodeState& state : states_) {
    for (std::size_t o = 0; o < state.outputs.size(); ++o) {
      if (std::erase(state.taps[o], &tap) > 0) find_wanted(state, o);
    }
  }
}

void Dispatcher::tell_step(std::size_t node) {
  if (step_taps_.empty()) return;
  const NodeState& state = states_[node];
  const StepEvent event{static_cast<std::int32_t>(node)};
  const Stamp stamp{state.begun, now_, state.steps - 1};
  for (Tap* tap : step_taps_) tap->put(stamp, &event);
}

void Dispatcher::passed(std::size_t node, Time begun) {
  NodeState& state = states_[node];
  state.begun = begun;
  ++state.steps;
  tell_step(node);
  first_step_passed(state);
}

void Dispatcher::find_groups() {
  std::map<std::string, std::size_t> groups;
  for (std::size_t n = 0; n < states_.size(); ++n) {
    const Scheduling& scheduling = plan_.nodes[n].scheduling;
    if (scheduling.lane != Lane::thread || scheduling.thread.empty()) continue;
    states_[n].group = groups.try_emplace(scheduling.thread, groups.size()).first->second;
  }
  group_busy_.assign(groups.size(), 0);
}

void Dispatcher::find_awaited() {
  // Upstream of a device, except devices: they step from the beginning, and what they show starts the rest.
  std::vector<std::size_t> todo;
  std::vector<bool> seen(states_.size(), false);
  for (std::size_t n = 0; n < states_.size(); ++n) {
    if (plan_.nodes[n].info->actuator) todo.push_back(n);
  }
  while (!todo.empty()) {
    const std::size_t n = todo.back();
    todo.pop_back();
    if (seen[n]) continue;
    seen[n] = true;
    if (!plan_.nodes[n].info->actuator && !plan_.nodes[n].info->fed) {
      states_[n].awaited = true;
      ++awaited_;
    }
    for (const std::size_t edge : states_[n].edges_in) todo.push_back(plan_.edges[edge].from);
  }
}

EngineStatus Dispatcher::status() const {
  EngineStatus status;
  status.now = now_;
  status.phase = phase_;
  for (std::size_t n = 0; n < states_.size(); ++n) {
    const NodeState& node = states_[n];
    if (phase_ == Phase::starting && node.awaited) status.waiting_for.push_back(plan_.nodes[n].name);
    status.nodes.push_back({node.steps, node.missed_ticks, false, false});
  }
  for (std::size_t e = 0; e < edges_.size(); ++e) status.edges.push_back({edge_statistics(e), {}});
  return status;
}

EdgeStatistics Dispatcher::edge_statistics(std::size_t index) const {
  const EdgeState& edge = edges_[index];
  const EdgeQueue& queue = edge.input->queue();
  return {edge.delivered, queue.dropped(), queue.superseded()};
}

void Dispatcher::start() {
  if (awaited_ == 0) set_phase(Phase::running);
  for (std::size_t n = 0; n < states_.size(); ++n) {
    StepContext context(now_, phase_);
    nodes_.start(n, context);
    take_outputs(n);
    release(n);
  }
  for (std::size_t n = 0; n < states_.size(); ++n) schedule_tick(n);
}

void Dispatcher::stop(bool failed) {
  set_phase(Phase::stopping);
  const StopEvent event{failed ? 1 : 0};
  for (Tap* tap : stop_taps_) tap->put({now_, now_, 0}, &event);
}

void Dispatcher::set_phase(Phase phase) {
  phase_ = phase;
  if (external_ != nullptr) external_->on_phase(phase);
}

void Dispatcher::tell_tick(Time deadline, Time now, const TickEvent& event) {
  const Stamp stamp{deadline, now, states_[static_cast<std::size_t>(event.node)].steps};
  for (Tap* tap : tick_taps_) tap->put(stamp, &event);
}

void Dispatcher::tell_set(Time now, const SetEvent& event) {
  const Stamp stamp{now, now, sets_++};
  for (Tap* tap : set_taps_) tap->put(stamp, &event);
}

std::optional<Time> Dispatcher::next_event() const {
  if (events_.empty()) return std::nullopt;
  return events_.front().time;
}

bool Dispatcher::has_event_at(Time t) const {
  return std::any_of(events_.begin(), events_.end(), [t](const Event& event) { return event.time == t; });
}

void Dispatcher::move_to(Time t) {
  TACTOR_ASSERT(t >= now_ && (events_.empty() || t <= events_.front().time));
  now_ = t;
}

void Dispatcher::push_event(Time time, Event::Kind kind, std::size_t index) {
  events_.push_back({time, event_count_++, kind, index});
  std::push_heap(events_.begin(), events_.end(), Later{});
}

void Dispatcher::schedule_tick(std::size_t node) {
  NodeState& state = states_[node];
  if (state.rate <= 0 || state.external) return;
  // From the tick's number, so that no rounding adds up.
  const Time time{std::llround(static_cast<double>(state.next_tick) * 1e9 / state.rate)};
  ++state.next_tick;
  push_event(time, Event::Kind::tick, node);
}

void Dispatcher::handle_due() {
  while (!events_.empty() && events_.front().time == now_) {
    std::pop_heap(events_.begin(), events_.end(), Later{});
    const Event event = events_.back();
    events_.pop_back();
    handle(event);
  }
}

void Dispatcher::handle(const Event& event) {
  switch (event.kind) {
    case Event::Kind::tick: {
      NodeState& state = states_[event.index];
      if (state.busy || state.blocked_edges > 0) {
        ++state.missed_ticks;
      } else {
        state.tick_due = true;
      }
      schedule_tick(event.index);
      break;
    }
    case Event::Kind::complete:
      complete(event.index);
      break;
    case Event::Kind::arrival: {
      HeldMessages& delayed = edges_[event.index].delayed;
      arrive(event.index, delayed.stamp(), delayed.value());
      delayed.pop();
      break;
    }
  }
}

bool Dispatcher::ready(const NodeState& state) const {
  return !state.busy && state.blocked_edges == 0 && (state.tick_due || state.triggered) &&
         !(state.group && group_busy_[*state.group] != 0);
}

bool Dispatcher::is_next(const NodeState& state) const {
  if (!ready(state)) return false;
  // Of those that share a thread, the one whose last step lies longest ago: none waits for ever.
  return !state.group || std::none_of(states_.begin(), states_.end(), [&](const NodeState& other) {
    return other.group == state.group && other.begun < state.begun && ready(other);
  });
}

std::optional<Dispatcher::StepRequest> Dispatcher::next_request() {
  // What became visible by a node's becoming free at this instant is worked on before that node steps anew: it may
  // wait for the answer, as collision does for the tool pose that follows from its contacts.
  auto next =
      std::find_if(states_.begin(), states_.end(), [this](const auto& s) { return is_next(s) && s.completed != now_; });
  if (next == states_.end()) {
    next = std::find_if(states_.begin(), states_.end(), [this](const auto& s) { return is_next(s); });
  }
  if (next == states_.end()) return std::nullopt;
  next->tick_due = false;
  next->triggered = false;
  next->busy = true;
  next->begun = now_;
  ++next->steps;
  if (next->group) group_busy_[*next->group] = 1;
  next->unread_before = 0;
  for (const InputBase* input : next->trigger_queues) next->unread_before += input->unread();
  for (const std::size_t edge : next->edges_in) edges_[edge].unread_at_begin = edges_[edge].input->unread();
  return StepRequest{static_cast<std::size_t>(next - states_.begin()), now_, phase_};
}

void Dispatcher::take_outputs(std::size_t node) {
  NodeState& state = states_[node];
  for (std::size_t o = 0; o < state.outputs.size(); ++o) {
    OutputBase& output = *state.outputs[o];
    for (std::size_t i = 0; i < output.pending(); ++i) {
      state.held[o].push({output.pending_valid(i), {}, state.sequence[o]++}, output.pending_value(i));
    }
    output.clear_pending();
  }
}

void Dispatcher::complete_at(std::size_t node, Time t) {
  push_event(t, Event::Kind::complete, node);
}

void Dispatcher::complete(std::size_t node) {
  NodeState& state = states_[node];
  state.busy = false;
  state.completed = now_;
  tell_step(node);
  if (state.group) group_busy_[*state.group] = 0;
  for (InputBase* input : state.inputs) {
    if (input->connected()) input->queue().mark_seen();
  }
  std::size_t left = 0;
  for (const InputBase* input : state.trigger_queues) left += input->unread();
  // A step that took messages and left some is asked again; one that took none waits for the next arrival.
  if (left > 0 && left < state.unread_before) state.triggered = true;
  take_outputs(node);
  for (const std::size_t e : state.edges_in) {
    admit(e);
  }
  flush_blocked(node);
  first_step_passed(state);
  release(node);
}

void Dispatcher::failed(std::size_t node) {
  const NodeState& state = states_[node];
  if (state.group) group_busy_[*state.group] = 0;
}

void Dispatcher::first_step_passed(NodeState& state) {
  if (!state.awaited) return;
  state.awaited = false;
  if (--awaited_ == 0 && phase_ == Phase::starting) set_phase(Phase::running);
}

void Dispatcher::release(std::size_t node) {
  NodeState& state = states_[node];
  for (std::size_t o = 0; o < state.outputs.size(); ++o) {
    for (HeldMessages& held = state.held[o]; !held.empty(); held.pop()) {
      held.stamp().produced = now_;
      for (Tap* tap : state.taps[o]) tap->put(held.stamp(), held.value());
      for (const std::size_t edge : state.edges_out[o]) deliver(edge, held.stamp(), held.value());
    }
  }
}

void Dispatcher::publish(std::size_t node, std::size_t output, Time valid, const void* payload) {
  NodeState& state = states_[node];
  const Stamp stamp{valid, now_, state.sequence[output]++};
  for (Tap* tap : state.taps[output]) tap->put(stamp, payload);
  for (const std::size_t edge : state.edges_out[output]) {
    if (edges_[edge].is_inner) {
      count(edges_[edge], stamp);
    } else {
      deliver(edge, stamp, static_cast<const std::byte*>(payload));
    }
  }
}

void Dispatcher::deliver(std::size_t edge, const Stamp& stamp, const std::byte* payload) {
  const PlannedEdge& planned = plan_.edges[edge];
  if (planned.spec.delay.ns == 0) {
    arrive(edge, stamp, payload);
    return;
  }
  edges_[edge].delayed.push(stamp, payload);
  push_event(now_ + planned.spec.delay, Event::Kind::arrival, edge);
}

void Dispatcher::arrive(std::size_t edge, const Stamp& stamp, const std::byte* payload) {
  EdgeState& state = edges_[edge];
  const PlannedEdge& planned = plan_.edges[edge];
  if (phase_ == Phase::stopping && state.to_sink) return;
  NodeState& reader = states_[planned.to];
  if (reader.external) {
    count(state, stamp);
    external_->on_arrival(edge, stamp, payload);
    return;
  }
  // While the reader is busy nobody knows yet what its step will leave: it is taken to leave everything.
  const bool full = reader.busy
                        ? planned.spec.queue.policy == QueuePolicy::block &&
                              state.unread_at_begin + state.input->queue().arrived() >= planned.spec.queue.capacity
                        : state.input->full();
  if (full || !state.blocked.empty()) {
    if (state.blocked.empty()) ++states_[planned.from].blocked_edges;
    state.blocked.push(stamp, payload);
    return;
  }
  ++state.delivered;
  for (Tap* tap : state.taps) tap->put(stamp, payload);
  if (planned.triggers) reader.triggered = true;
  state.input->queue().push(stamp, payload);
  // A step under way sees what had arrived when it began.
  if (!reader.busy) admit(edge);
}

void Dispatcher::count(EdgeState& edge, const Stamp& stamp) {
  ++edge.delivered;
  edge.newest_produced = stamp.produced;
}

void Dispatcher::admit(std::size_t edge) {
  EdgeQueue& queue = edges_[edge].input->queue();
  queue.admit();
  if (const MessageView newest = queue.newest()) edges_[edge].newest_produced = newest.stamp->produced;
}

void Dispatcher::flush_blocked(std::size_t reader) {
  for (const std::size_t edge : states_[reader].edges_in) {
    EdgeState& state = edges_[edge];
    if (state.blocked.empty()) continue;
    while (!state.blocked.empty() && !state.input->full()) {
      HeldMessages& blocked = state.blocked;
      ++state.delivered;
      for (Tap* tap : state.taps) tap->put(blocked.stamp(), blocked.value());
      if (plan_.edges[edge].triggers) states_[reader].triggered = true;
      state.input->queue().push(blocked.stamp(), blocked.value());
      admit(edge);
      blocked.pop();
    }
    if (state.blocked.empty()) --states_[plan_.edges[edge].from].blocked_edges;
  }
}

}  // namespace tactor
