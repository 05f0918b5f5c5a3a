#include "framework/engine/virtual_clock.hpp"

#include <ctime>

#include <algorithm>
#include <cmath>
#include <deque>

#include "framework/core/random.hpp"
#include "framework/engine/cost.hpp"

namespace tactor {

namespace {

std::int64_t thread_cpu_ns() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

/// A message on its way: stamp and payload bytes.
struct Held {
  Stamp stamp;
  std::vector<std::byte> payload;
};

}  // namespace

struct VirtualClock::NodeState {
  explicit NodeState(const CostDraw& draw) : cost(draw) {}
  CostDraw cost;
  double rate = 0;  // Hz; 0: it steps on messages only
  std::int64_t next_tick = 0;
  bool busy = false;
  Time freed{-1};  // when it last became free
  bool tick_due = false;
  bool triggered = false;
  int blocked_edges = 0;
  std::vector<InputBase*> inputs;
  std::vector<InputBase*> trigger_queues;             // inputs whose unread messages ask for a step
  std::vector<OutputBase*> outputs;                   // by index into NodeInfo::outputs
  std::vector<std::uint64_t> sequence;                // by output
  std::vector<std::vector<std::size_t>> edges_out;    // by output
  std::vector<std::vector<std::size_t>> streams_out;  // by output
  std::vector<std::vector<Held>> held;                // by output: what becomes visible when the node is free again
  std::vector<std::size_t> held_count;                // by output: entries of `held` in use; their memory is kept
  std::vector<std::size_t> edges_in;
  NodeFigures figures;

  [[nodiscard]] bool runnable() const { return !busy && blocked_edges == 0 && (tick_due || triggered); }
};

struct VirtualClock::EdgeState {
  InputBase* input = nullptr;
  bool reference = false;
  std::deque<Held> delayed;  // in order of arrival
  std::deque<Held> blocked;  // waiting for room in a `block` queue
  std::uint64_t delivered = 0;
};

struct VirtualClock::Event {
  enum class Kind : std::uint8_t { arrival, free, tick };
  Time time;
  std::uint64_t count = 0;  // ties of one kind are handled in the order of scheduling, which is deterministic
  Kind kind = Kind::tick;
  std::size_t index = 0;  // edge of an arrival, else node
};

struct VirtualClock::Later {
  bool operator()(const Event& a, const Event& b) const {
    if (a.time != b.time) return a.time > b.time;
    // Ticks last: a node whose cost has passed at this instant is free, and does not miss its tick.
    const bool a_ticks = a.kind == Event::Kind::tick, b_ticks = b.kind == Event::Kind::tick;
    return a_ticks != b_ticks ? a_ticks : a.count > b.count;
  }
};

VirtualClock::VirtualClock(const Plan& plan, bool measure_cpu) : plan_(plan), measure_cpu_(measure_cpu) {
  for (const NodeSpec& spec : plan.nodes) {
    NodeContext context;
    context.name = spec.name;
    context.scene = &plan.graph.scene;
    context.torque = plan.torque;
    context.seed = derive_seed(plan.graph.seed, spec.name);
    context.duration = plan.graph.duration;
    try {
      nodes_.push_back(spec.info->create(spec.params, context));
    } catch (const InputError& error) {
      throw InputError(spec.place.text() + ": node " + spec.name + ": " + error.what());
    }
    NodeState state(CostDraw(spec.cost, plan.graph.seed, spec.name));
    if (spec.info->rate_parameter) state.rate = std::get<double>(spec.params[*spec.info->rate_parameter]);
    for (const InputInfo& input : spec.info->inputs) state.inputs.push_back(&input.access(*nodes_.back()));
    for (const OutputInfo& output : spec.info->outputs) state.outputs.push_back(&output.access(*nodes_.back()));
    const std::size_t outputs = state.outputs.size();
    state.sequence.resize(outputs);
    state.edges_out.resize(outputs);
    state.streams_out.resize(outputs);
    state.held.resize(outputs);
    state.held_count.resize(outputs);
    states_.push_back(std::move(state));
  }
  for (std::size_t i = 0; i < plan.edges.size(); ++i) {
    const PlannedEdge& edge = plan.edges[i];
    EdgeState state;
    state.input = states_[edge.to].inputs[edge.input];
    state.input->configure(edge.spec.queue);
    state.reference = plan.nodes[edge.to].info->inputs[edge.input].reference;
    if (edge.triggers && edge.spec.queue.policy != QueuePolicy::latest) {
      states_[edge.to].trigger_queues.push_back(state.input);
    }
    states_[edge.from].edges_out[edge.output].push_back(i);
    states_[edge.to].edges_in.push_back(i);
    edges_.push_back(std::move(state));
  }
  for (std::size_t i = 0; i < plan.streams.size(); ++i) {
    states_[plan.streams[i].node].streams_out[plan.streams[i].output].push_back(i);
  }
  for (NodeState& state : states_) {
    for (std::size_t o = 0; o < state.outputs.size(); ++o) {
      state.outputs[o]->set_wanted(!state.edges_out[o].empty() || !state.streams_out[o].empty());
    }
  }
}

VirtualClock::~VirtualClock() = default;

void VirtualClock::follow(const VirtualClock& judged) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    for (std::size_t j = 0; j < judged.nodes_.size(); ++j) {
      if (plan_.nodes[i].name == judged.plan_.nodes[j].name) nodes_[i]->follow(*judged.nodes_[j]);
    }
  }
}

const NodeFigures& VirtualClock::node_figures(std::size_t index) const {
  return states_[index].figures;
}

EdgeFigures VirtualClock::edge_figures(std::size_t index) const {
  const EdgeState& edge = edges_[index];
  return {edge.delivered, edge.input->dropped(), edge.input->superseded()};
}

void VirtualClock::run(RunObserver& observer) {
  observer_ = &observer;
  const Time end = Time{} + plan_.graph.duration;
  for (std::size_t i = 0; i < nodes_.size(); ++i) step(i, true);
  for (std::size_t i = 0; i < nodes_.size(); ++i) schedule_tick(i);

  constexpr Duration progress_period{10'000'000};
  Time next_progress = Time{} + progress_period;
  // What the starts sent at time zero may have made nodes runnable before any event.
  while (true) {
    while (!events_.empty() && events_.front().time == now_) {
      std::pop_heap(events_.begin(), events_.end(), Later{});
      const Event event = events_.back();
      events_.pop_back();
      handle(event);
    }
    // What became visible by a node's becoming free at this instant is worked on before that node steps anew: it may
    // wait for the answer, as collision does for the tool pose that follows from its contacts.
    auto ready = std::find_if(states_.begin(), states_.end(),
                              [this](const NodeState& s) { return s.runnable() && s.freed != now_; });
    if (ready == states_.end()) {
      ready = std::find_if(states_.begin(), states_.end(), [](const NodeState& s) { return s.runnable(); });
    }
    if (ready != states_.end()) {
      step(static_cast<std::size_t>(ready - states_.begin()), false);
      continue;
    }
    if (events_.empty() || events_.front().time >= end) break;
    now_ = events_.front().time;
    if (now_ >= next_progress) {
      if (!observer.on_progress(now_)) return;
      next_progress = now_ + progress_period;
    }
  }
  now_ = end;
  observer.on_progress(now_);
}

void VirtualClock::schedule_tick(std::size_t node) {
  NodeState& state = states_[node];
  if (state.rate <= 0) return;
  // From the tick's number, so that no rounding adds up.
  const Time time{std::llround(static_cast<double>(state.next_tick) * 1e9 / state.rate)};
  ++state.next_tick;
  events_.push_back({time, event_count_++, Event::Kind::tick, node});
  std::push_heap(events_.begin(), events_.end(), Later{});
}

void VirtualClock::handle(const Event& event) {
  switch (event.kind) {
    case Event::Kind::tick: {
      NodeState& state = states_[event.index];
      if (state.busy || state.blocked_edges > 0) {
        ++state.figures.missed_ticks;
      } else {
        state.tick_due = true;
      }
      schedule_tick(event.index);
      break;
    }
    case Event::Kind::free:
      states_[event.index].busy = false;
      states_[event.index].freed = now_;
      release(event.index);
      break;
    case Event::Kind::arrival: {
      EdgeState& edge = edges_[event.index];
      const Held message = std::move(edge.delayed.front());
      edge.delayed.pop_front();
      arrive(event.index, message.stamp, message.payload.data());
      break;
    }
  }
}

void VirtualClock::step(std::size_t node, bool first) {
  NodeState& state = states_[node];
  state.tick_due = false;
  state.triggered = false;
  std::size_t unread_before = 0;
  for (const InputBase* input : state.trigger_queues) unread_before += input->unread();

  StepContext context(now_);
  const std::int64_t cpu_begin = measure_cpu_ && !first ? thread_cpu_ns() : 0;
  try {
    if (first) {
      nodes_[node]->start(context);
    } else {
      nodes_[node]->step(context);
    }
  } catch (const InputError& error) {
    throw InputError("node " + plan_.nodes[node].name + ": " + error.what());
  } catch (const std::exception& error) {
    throw RunError("node " + plan_.nodes[node].name + " failed at " + std::to_string(now_.seconds()) +
                   " s: " + error.what());
  }
  Duration cost;
  if (!first) {
    if (measure_cpu_)
      state.figures.cpu_ns.push_back(
          static_cast<std::uint32_t>(std::min<std::int64_t>(thread_cpu_ns() - cpu_begin, UINT32_MAX)));
    ++state.figures.steps;
    cost = state.cost.next(context.work());
    observer_->on_step(node, now_, cost);
    for (InputBase* input : state.inputs) {
      if (input->connected()) input->mark_seen();
    }
    flush_blocked(node);
    std::size_t unread_after = 0;
    for (const InputBase* input : state.trigger_queues) unread_after += input->unread();
    // A step that took messages and left some is asked again; one that took none waits for the next arrival.
    if (unread_after > 0 && unread_after < unread_before) state.triggered = true;
  }

  for (std::size_t o = 0; o < state.outputs.size(); ++o) {
    OutputBase& output = *state.outputs[o];
    const std::size_t size = output.type().size;
    for (std::size_t i = 0; i < output.pending(); ++i) {
      if (state.held[o].size() == state.held_count[o]) state.held[o].push_back({{}, std::vector<std::byte>(size)});
      Held& held = state.held[o][state.held_count[o]++];
      held.stamp = {output.pending_valid(i), now_ + cost, state.sequence[o]++};
      const auto* bytes = static_cast<const std::byte*>(output.pending_value(i));
      std::copy(bytes, bytes + size, held.payload.begin());
    }
    output.clear_pending();
  }
  if (cost.ns > 0) {
    state.busy = true;
    events_.push_back({now_ + cost, event_count_++, Event::Kind::free, node});
    std::push_heap(events_.begin(), events_.end(), Later{});
  } else {
    release(node);
  }
}

void VirtualClock::release(std::size_t node) {
  NodeState& state = states_[node];
  for (std::size_t o = 0; o < state.outputs.size(); ++o) {
    for (std::size_t i = 0; i < state.held_count[o]; ++i) {
      const Held& message = state.held[o][i];
      for (const std::size_t stream : state.streams_out[o]) {
        observer_->on_message(stream, message.stamp, message.payload.data());
      }
      for (const std::size_t edge : state.edges_out[o]) deliver(edge, message.stamp, message.payload.data());
    }
    state.held_count[o] = 0;
  }
}

void VirtualClock::deliver(std::size_t edge, const Stamp& stamp, const std::byte* payload) {
  const PlannedEdge& planned = plan_.edges[edge];
  if (planned.spec.delay.ns == 0) {
    arrive(edge, stamp, payload);
    return;
  }
  edges_[edge].delayed.push_back({stamp, {payload, payload + edges_[edge].input->type().size}});
  events_.push_back({now_ + planned.spec.delay, event_count_++, Event::Kind::arrival, edge});
  std::push_heap(events_.begin(), events_.end(), Later{});
}

void VirtualClock::arrive(std::size_t edge, const Stamp& stamp, const std::byte* payload) {
  EdgeState& state = edges_[edge];
  const PlannedEdge& planned = plan_.edges[edge];
  if (state.input->full() || !state.blocked.empty()) {
    if (state.blocked.empty()) ++states_[planned.from].blocked_edges;
    state.blocked.push_back({stamp, {payload, payload + state.input->type().size}});
    return;
  }
  state.input->push(stamp, payload);
  ++state.delivered;
  if (state.reference) observer_->on_reference(edge, stamp, payload);
  if (planned.triggers) states_[planned.to].triggered = true;
}

void VirtualClock::flush_blocked(std::size_t reader) {
  for (const std::size_t edge : states_[reader].edges_in) {
    EdgeState& state = edges_[edge];
    if (state.blocked.empty()) continue;
    while (!state.blocked.empty() && !state.input->full()) {
      const Held message = std::move(state.blocked.front());
      state.blocked.pop_front();
      state.input->push(message.stamp, message.payload.data());
      ++state.delivered;
      if (state.reference) observer_->on_reference(edge, message.stamp, message.payload.data());
      if (plan_.edges[edge].triggers) states_[reader].triggered = true;
    }
    if (state.blocked.empty()) --states_[plan_.edges[edge].from].blocked_edges;
  }
}

}  // namespace tactor
