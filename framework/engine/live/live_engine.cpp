#include "framework/engine/live/live_engine.hpp"

#include <algorithm>
#include <exception>
#include <mutex>
#include <utility>

#include "framework/core/clock.hpp"
#include "framework/engine/live/dead_man.hpp"
#include "framework/realtime/make_thread.hpp"
#include "framework/realtime/thread_policy.hpp"

namespace tactor {

namespace {

/// In the pool the CPU time of every this many steps is read: reading it is a system call, and two of them would take
/// longer than a message between light nodes. A prime, so that it falls in step with no pattern of a graph.
constexpr std::uint64_t steps_a_measurement = 7;
/// The engine's own thread: below devices, above the pool.
constexpr ThreadSettings timer_settings{SchedulingPolicy::fifo, 70, std::nullopt};

}  // namespace

LiveEngine::LiveEngine(const Plan& plan, const EngineOptions& options)
    : plan_(plan),
      flight_(plan),
      nodes_(plan, nullptr, flight_.ring()),
      step_times_(plan),
      lanes_(plan_lanes(plan)),
      steps_(plan),
      stalls_(plan.nodes.size(), plan.graph.live.stall_timeout) {
  check_dead_man(nodes_, options.without_dead_man);
  const std::string refused = check_privileges(plan_, lanes_, timer_settings);
  if (!refused.empty()) nodes_.note(refused);
  if (!flight_.refused().empty()) nodes_.note(flight_.refused());
  make_lanes();
  if (options.keeps_step_times) step_times_.keep(*dispatcher_);
  for (std::size_t e = 0; e < plan.edges.size(); ++e) age_.push_back(std::make_unique<LatencyHistogram>());
}

LiveEngine::~LiveEngine() {
  if (timer_.thread.joinable() && !abandoned_) finish({});
}

void LiveEngine::with_dispatcher(const std::function<void(Dispatcher&)>& work) {
  const std::scoped_lock lock(mutex_);
  work(*dispatcher_);
}

// Starting.

void LiveEngine::start() {
  dispatcher_->start();
  for (const auto& loop : loops_) loop->count_from(*dispatcher_);
  try {
    make_actors();
    start_threads();
  } catch (...) {
    // Nothing has moved: no step has been made, so every device is disengaged.
    for (const auto& loop : loops_) static_cast<void>(loop->stop(longest_step_at_end));
    end_threads();
    throw;
  }
}

void LiveEngine::make_lanes() {
  const Chains& chains = lanes_.chains;
  ExternalInputs* const lanes = this;
  dispatcher_ = std::make_unique<Dispatcher>(nodes_, chains, lanes);
  for (std::size_t c = 0; c < chains.nodes.size(); ++c) {
    const ThreadSettings& settings = lanes_.realtime[chains.nodes[c].front()].value();
    loops_.push_back(std::make_unique<RealtimeLane>(nodes_, chains, c, settings, flight_.ring()));
  }
}

void LiveEngine::make_actors() {
  // Everything that will run is in memory by now.
  memory_.emplace();
  if (memory_->refused()) missing_.push_back(describe(*memory_->refused()));
  actors_.make(
      lanes_, [this](const LaneSpec& lane) { granted(apply_thread_settings(lane.settings, lane.name)); },
      [this](std::size_t node) { step(node); });
}

void LiveEngine::granted(const ThreadGrant& grant) {
  const std::scoped_lock lock(mutex_);
  for (const Refusal& refusal : grant.refused) {
    const std::string text = describe(refusal);
    if (std::find(missing_.begin(), missing_.end(), text) == missing_.end()) missing_.push_back(text);
  }
}

void LiveEngine::start_threads() {
  origin_ = MonotonicClock::now() + head_start;
  flight_.start(origin_);
  for (const auto& loop : loops_) granted(loop->start(origin_));
  // Last, because it lets the first steps begin.
  timer_.thread = make_thread("timer", [this] { keep_time(); });
}

// Steps.

void LiveEngine::on_arrival(std::size_t edge, const Stamp& stamp, const void* payload) {
  const std::size_t reader = plan_.edges[edge].to;
  (*loop_of(reader))[reader].put(edge, stamp, payload);
}

void LiveEngine::on_phase(Phase phase) {
  for (const auto& loop : loops_) loop->set_phase(phase);
}

void LiveEngine::catch_up(Time t) {
  if (t >= end() && dispatcher_->phase() != Phase::stopping) {
    handle_events_before(end());
    dispatcher_->move_to(end());
    begin_stop(false);
  }
  handle_events_before(t);
  dispatcher_->move_to(t);
}

void LiveEngine::handle_events_before(Time t) {
  // Ticks and delayed messages that came before `t` happen before what happens at `t`.
  for (auto next = dispatcher_->next_event(); next && *next < t; next = dispatcher_->next_event()) {
    dispatcher_->move_to(*next);
    dispatcher_->handle_due();
    steps_.begin_ready(*dispatcher_);
  }
}

Time LiveEngine::next_instant() const {
  Time t = std::max(clock(), dispatcher_->now() + Duration{1});
  // At no instant at which something is due, so that a replay does not have to know which came first.
  while (dispatcher_->has_event_at(t)) t = t + Duration{1};
  return t;
}

void LiveEngine::begin_stop(bool failed) {
  // What the run is judged by ends here; the ramp-down is not part of it.
  status_ = counters();
  dispatcher_->stop(failed);
  add_latencies(status_, true);
}

void LiveEngine::step(std::size_t node) {
  Dispatcher::StepRequest request;
  bool measured = true;
  ActorSteps::Params tuned;
  {
    const std::scoped_lock lock(mutex_);
    request = steps_[node].request;
    tuned.swap(steps_[node].to_tune);
    measured = lanes_.lane_of[node] != 0 || dispatcher_->steps(node) % steps_a_measurement == 1;
  }
  const Time starts = clock();
  for (const std::size_t edge : dispatcher_->edges_into(node)) {
    if (const auto produced = dispatcher_->newest_produced(edge)) age_[edge]->record(starts - *produced);
  }
  StepContext context(request.now, request.phase);
  std::string error;
  const Duration cpu = measured ? clock_time(CLOCK_THREAD_CPUTIME_ID) : Duration{};
  try {
    const SteppingNode stepping(node);
    for (const auto& params : tuned) nodes_.set(node, params.get());
    nodes_.step(node, context);
    flight_.stepped(node, nodes_);
  } catch (const std::exception& e) {
    error = e.what();
  }
  const Duration cpu_time = measured ? clock_time(CLOCK_THREAD_CPUTIME_ID) - cpu : Duration{};

  const std::scoped_lock lock(mutex_);
  // A step that comes back when the run has given it up finds its metrics taken.
  if (timer_.ended) return;
  if (measured) steps_[node].statistics.add_cpu(cpu_time);
  const Time now = next_instant();
  catch_up(now);
  if (error.empty()) {
    if (request.phase == Phase::stopping) steps_[node].at_rest = context.at_rest();
    if (!steps_.hold(node, context.work(), dispatcher_->now())) dispatcher_->complete(node);
  } else {
    // It stays busy and never steps again; the rest goes on while the devices ramp down.
    steps_[node].failed = true;
    fail(error, node);
    dispatcher_->failed(node);
  }
  steps_.begin_ready(*dispatcher_);
  wake_others();
}

void LiveEngine::wake_others() {
  // Under the lock, where whoever waits for it lends this thread its priority: these may be nodes of a higher lane,
  // whose ticks were due, and without the lock this thread may not be let run for a long time.
  actors_.ask(steps_.woken());
  steps_.woken().clear();
  const auto next = dispatcher_->next_event(), held = steps_.held_until();
  const bool earlier = (next && *next < timer_.waits_until) || (held && *held < timer_.waits_until);
  if (earlier) timer_.condition.notify_one();
}

bool LiveEngine::feed(std::size_t node, std::optional<Time> valid, std::span<const FedValue> values) {
  const std::scoped_lock lock(mutex_);
  if (timer_.ended) return true;
  const Time now = next_instant();
  catch_up(now);
  const bool has_room = !dispatcher_->is_blocked(node);
  for (const FedValue& fed : has_room ? values : std::span<const FedValue>{}) {
    dispatcher_->publish(node, fed.output, valid.value_or(now), fed.value);
  }
  steps_.begin_ready(*dispatcher_);
  wake_others();
  return has_room;
}

void LiveEngine::set(std::size_t node, std::shared_ptr<const void> params, const SetEvent& event) {
  const std::scoped_lock lock(mutex_);
  if (timer_.ended) return;
  const Time now = next_instant();
  catch_up(now);
  RealtimeLane* const loop = loop_of(node);
  if (loop == nullptr) {
    steps_[node].tuned.push_back(std::move(params));
  } else if (!(*loop)[node].tune(std::move(params))) {
    throw RunError("node " + plan_.nodes[node].name + " is given parameters faster than it ticks");
  }
  dispatcher_->tell_set(now, event);
  flight_.set(event);
  wake_others();
}

bool LiveEngine::is_set(std::size_t node) {
  const std::scoped_lock lock(mutex_);
  if (RealtimeLane* const loop = loop_of(node)) return (*loop)[node].is_tuned();
  // A node at rest takes them with its next step, whenever that is.
  return steps_[node].to_tune.empty() && (steps_[node].tuned.empty() || !dispatcher_->busy(node));
}

void LiveEngine::release_held() {
  for (auto until = steps_.held_until(); until && *until <= clock(); until = steps_.held_until()) {
    const std::size_t node = steps_.release();
    // Each at an instant of its own, so that a replay knows which came first.
    catch_up(next_instant());
    dispatcher_->complete(node);
    steps_.begin_ready(*dispatcher_);
  }
}

void LiveEngine::fail(const std::string& why, std::optional<std::size_t> node) {
  flight_.failed(why, node);
  if (!failure_) failure_ = why;
  // At once, and not when the calling thread next looks: a disk or a terminal may hold that up.
  if (dispatcher_->phase() != Phase::stopping) begin_stop(true);
}

// The timer thread: keeps the time for ticks, and carries out what the loops send.

void LiveEngine::keep_time() {
  granted(apply_thread_settings(timer_settings, "timer"));
  Time next_watch;
  mutex_.lock();
  while (!timer_.ended) {
    drain_loops();
    release_held();
    const Time now = next_instant();
    catch_up(now);
    if (dispatcher_->phase() != Phase::stopping && stop_asked_()) begin_stop(false);
    if (now >= next_watch) {
      // Here, because a step that spins in the pool may keep the calling thread from running.
      look_for_stalls();
      next_watch = now + watch_period;
    }
    std::vector<std::size_t> woken;
    woken.swap(steps_.woken());
    if (!woken.empty()) {
      mutex_.unlock();
      actors_.ask(woken);
      mutex_.lock();
      continue;  // what came meanwhile is looked at before it waits
    }
    Time& until = timer_.waits_until;
    until = next_look(now);
    if (const auto next = dispatcher_->next_event()) until = std::min(until, *next);
    if (const auto held = steps_.held_until()) until = std::min(until, *held);
    if (now < end()) until = std::min(until, end());
    timer_.condition.wait_until(mutex_, (origin_ + (until - Time{})).ns);
  }
  mutex_.unlock();
}

void LiveEngine::drain_loops() {
  for (const auto& loop : loops_) {
    while (loop->take_tick()) publish_tick(*loop);
  }
}

void LiveEngine::publish_tick(RealtimeLane& loop) {
  // All that it sent becomes visible at one instant, so that a replay knows what came before it and what after.
  const Time now = next_instant();
  catch_up(now);
  for (const RealtimeLane::Out& out : loop.sent()) dispatcher_->publish(out.node, out.port, out.valid, out.payload);
  dispatcher_->tell_tick(loop.deadline(), now, loop.event());
  dispatcher_->passed(static_cast<std::size_t>(loop.event().node), loop.deadline());
  steps_.begin_ready(*dispatcher_);
}

Time LiveEngine::next_look(Time now) const {
  Time look = now + watch_period;
  for (const auto& loop : loops_) look = std::min(look, loop->next_look(now));
  return look;
}

}  // namespace tactor
