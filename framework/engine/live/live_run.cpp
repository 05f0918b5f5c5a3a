#include "framework/engine/live/live_run.hpp"

#include <algorithm>
#include <caf/actor_system_config.hpp>
#include <caf/send.hpp>
#include <cstring>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include "framework/core/messages.hpp"
#include "framework/engine/dispatcher.hpp"
#include "framework/engine/live/lane_plan.hpp"
#include "framework/engine/live/lane_scheduler.hpp"
#include "framework/engine/live/realtime_lane.hpp"
#include "framework/engine/live/record_queue.hpp"
#include "framework/engine/live/stall_watch.hpp"
#include "framework/engine/virtual_clock.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "framework/realtime/memory_lock.hpp"
#include "framework/realtime/monotonic_clock.hpp"
#include "framework/realtime/thread_policy.hpp"

namespace tactor {

namespace {

/// Between making the threads and time zero.
constexpr Duration head_start{20'000'000};
/// How long after a tick the engine first looks for what the loop sent, and how often again until it is there.
constexpr Duration look_after{60'000};
constexpr Duration look_again{100'000};
/// How often the calling thread writes the recording and watches for stalls.
constexpr Duration watch_period{20'000'000};
/// How often `go_on` is asked.
constexpr Duration ask_period{100'000'000};
/// How long devices may take to come to rest at the end: more than the longest ramp_down_time that one may have. One
/// that does not tick any more is not waited for so long.
constexpr Duration longest_ramp_down{15'000'000'000};
constexpr Duration longest_without_tick{2'000'000'000};
/// How long steps may take to come back at the end.
constexpr Duration longest_step_at_end{1'000'000'000};
/// What the recording may lag behind before messages are dropped.
constexpr std::size_t record_queue_bytes = std::size_t{64} << 20;
/// In the pool the CPU time of every this many steps is read: reading it is a system call, and two of them would take
/// longer than a message between light nodes. A prime, so that it falls in step with no pattern of a graph.
constexpr std::uint64_t steps_a_measurement = 7;
/// The engine's own thread: below devices, above the pool.
constexpr ThreadSettings bridge_settings{SchedulingPolicy::fifo, 70, std::nullopt};

}  // namespace

class LiveRun::Engine final : public RunObserver, public ExternalInputs {
 public:
  explicit Engine(const Plan& plan);
  void run(RunObserver& observer, const std::function<bool(const LiveStatus&)>& go_on);

  PlanNodes nodes;
  std::optional<std::string> failure;
  bool abandoned = false;
  LiveStatus status;
  std::vector<NodeFigures> node_figures;
  std::function<bool()> stop_asked = [] { return false; };

 private:
  // What the dispatcher tells, under the lock.
  void on_message(std::size_t stream, const Stamp& stamp, const void* payload) override;
  void on_arrival(std::size_t edge, const Stamp& stamp, const void* payload) override;
  void on_phase(Phase phase) override;

  void make_lanes();
  void make_actors();
  void start_threads();
  void granted(const ThreadGrant& grant);

  [[nodiscard]] Time clock() const { return Time{} + (MonotonicClock::now() - origin_); }
  // Under the lock:
  [[nodiscard]] Time next_instant() const { return std::max(clock(), dispatcher_->now() + Duration{1}); }
  void catch_up(Time t);
  void handle_events_before(Time t);
  void begin_stop();
  void begin_ready();
  void drain_loops();
  [[nodiscard]] Time next_look(Time now) const;
  void fail(const std::string& why);
  void look_for_stalls();
  void look_for_failure(std::size_t node);
  [[nodiscard]] std::int64_t steps_ended(std::size_t node) const;
  [[nodiscard]] std::vector<std::size_t> devices_not_at_rest() const;
  [[nodiscard]] std::vector<std::size_t> busy_nodes() const;
  /// `whole`: with the histograms.
  LiveStatus snapshot(bool whole);

  void wake(const std::vector<std::size_t>& nodes_to_step);
  void step(std::size_t node);
  void bridge();
  void watch(RunObserver& observer, const std::function<bool(const LiveStatus&)>& go_on);
  /// Runs the recording and the watch for stalls until `done` or the time is over.
  void attend(RunObserver& observer, Duration longest, const std::function<bool()>& done);
  void wind_down(RunObserver& observer);
  void drain_record(RunObserver& observer);

  const Plan& plan_;
  const Time end_;
  LanePlan lanes_;
  RecordQueue record_{record_queue_bytes};
  std::vector<std::unique_ptr<RealtimeLane>> loops_;    // by node, null outside of the real-time lane
  std::vector<std::unique_ptr<LatencyHistogram>> age_;  // by edge, written by its reader's steps

  PriorityMutex mutex_;  // over all down to `woken_`
  PriorityCondition bridge_condition_;
  std::unique_ptr<Dispatcher> dispatcher_;
  bool ended_ = false;  // no step begins any more
  bool bridge_ended_ = false;
  Time bridge_waits_until_;
  std::vector<Dispatcher::Begun> begun_;  // by node: the step it is making
  std::vector<bool> at_rest_;             // by node: of a device outside of the real-time lane
  std::vector<bool> failed_;              // by node
  StallWatch stalls_;
  std::vector<std::string> missing_;
  std::vector<std::optional<SafetyState>> safety_;  // by node: what its gate said last
  std::vector<std::size_t> woken_;                  // nodes that begun and whose actors are to be asked

  Instant origin_;
  std::optional<MemoryLock> memory_;
  caf::actor_system_config config_;
  std::unique_ptr<caf::actor_system> system_;
  const caf::message step_message_ = caf::make_message(LaneActor::Step::value);  // one for all, so none is allocated
  std::vector<caf::actor> actors_;
  std::thread bridge_;
};

LiveRun::Engine::Engine(const Plan& plan)
    : nodes(plan),
      node_figures(plan.nodes.size()),
      plan_(plan),
      end_(Time{} + plan.graph.duration),
      lanes_(plan_lanes(plan)),
      begun_(plan.nodes.size()),
      at_rest_(plan.nodes.size(), false),
      failed_(plan.nodes.size(), false),
      stalls_(plan.nodes.size(), plan.graph.live.stall_timeout),
      safety_(plan.nodes.size()) {
  check_privileges(plan_, lanes_, bridge_settings);
  for (std::size_t e = 0; e < plan.edges.size(); ++e) age_.push_back(std::make_unique<LatencyHistogram>());
}

// Starting.

void LiveRun::Engine::run(RunObserver& observer, const std::function<bool(const LiveStatus&)>& go_on) {
  make_lanes();
  dispatcher_->start();
  make_actors();
  start_threads();
  watch(observer, go_on);
  wind_down(observer);
}

void LiveRun::Engine::make_lanes() {
  std::vector<bool> external;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    external.push_back(lanes_.realtime[n].has_value());
    loops_.push_back(nullptr);
  }
  dispatcher_ = std::make_unique<Dispatcher>(nodes, *this, external, this);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (lanes_.realtime[n]) loops_[n] = std::make_unique<RealtimeLane>(nodes, n, *lanes_.realtime[n]);
    // The live view shows the state of every safety gate, recorded or not.
    const NodeInfo& info = *plan_.nodes[n].info;
    for (const OutputInfo& output : info.outputs) {
      if (info.actuator && output.type == &message_type<SafetyState>()) output.access(nodes[n]).set_wanted(true);
    }
  }
}

void LiveRun::Engine::make_actors() {
  // Everything that will run is in memory by now.
  memory_.emplace();
  if (memory_->refused()) missing_.push_back(describe(*memory_->refused()));
  config_.module_factories.push_back([this](caf::actor_system& system) -> caf::actor_system::module* {
    return new LaneScheduler(system, lanes_.lanes, [this](const LaneSpec& lane) {
      granted(apply_thread_settings(lane.settings, lane.name));
    });
  });
  system_ = std::make_unique<caf::actor_system>(config_);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    actors_.emplace_back();
    if (loops_[n]) continue;
    actors_[n] = system_->spawn<LaneActor>(lanes_.lane_of[n], std::function<void()>([this, n] { step(n); }));
  }
}

void LiveRun::Engine::granted(const ThreadGrant& grant) {
  const std::scoped_lock lock(mutex_);
  for (const Refusal& refusal : grant.refused) {
    const std::string text = describe(refusal);
    if (std::find(missing_.begin(), missing_.end(), text) == missing_.end()) missing_.push_back(text);
  }
}

void LiveRun::Engine::start_threads() {
  origin_ = MonotonicClock::now() + head_start;
  for (const auto& loop : loops_) {
    if (loop) granted(loop->start(origin_));
  }
  bridge_ = std::thread([this] { bridge(); });
}

// Steps.

void LiveRun::Engine::on_message(std::size_t stream, const Stamp& stamp, const void* payload) {
  const PlannedStream& planned = plan_.streams[stream];
  record_.put_message(stream, stamp, payload, plan_.nodes[planned.node].info->outputs[planned.output].type->size);
}

void LiveRun::Engine::on_arrival(std::size_t edge, const Stamp& stamp, const void* payload) {
  loops_[plan_.edges[edge].to]->put(edge, stamp, payload);
}

void LiveRun::Engine::on_phase(Phase phase) {
  for (const auto& loop : loops_) {
    if (loop) loop->set_phase(phase);
  }
}

void LiveRun::Engine::catch_up(Time t) {
  if (t >= end_ && dispatcher_->phase() != Phase::stopping) {
    handle_events_before(end_);
    dispatcher_->move_to(end_);
    begin_stop();
  }
  handle_events_before(t);
  dispatcher_->move_to(t);
}

void LiveRun::Engine::handle_events_before(Time t) {
  // Ticks and delayed messages that came before `t` happen before what happens at `t`.
  for (auto next = dispatcher_->next_event(); next && *next < t; next = dispatcher_->next_event()) {
    dispatcher_->move_to(*next);
    dispatcher_->handle_due();
    begin_ready();
  }
}

void LiveRun::Engine::begin_stop() {
  // What the run is judged by ends here; the ramp-down is not part of it.
  status = snapshot(true);
  dispatcher_->stop();
}

void LiveRun::Engine::begin_ready() {
  if (ended_) return;
  while (const auto begun = dispatcher_->begin_next()) {
    begun_[begun->node] = *begun;
    woken_.push_back(begun->node);
  }
}

void LiveRun::Engine::wake(const std::vector<std::size_t>& nodes_to_step) {
  for (const std::size_t n : nodes_to_step) caf::anon_send(actors_[n], step_message_);
}

void LiveRun::Engine::step(std::size_t node) {
  Dispatcher::Begun begun;
  bool measured = true;
  {
    const std::scoped_lock lock(mutex_);
    begun = begun_[node];
    measured = lanes_.lane_of[node] != 0 || dispatcher_->steps(node) % steps_a_measurement == 0;
  }
  const Time starts = clock();
  for (const std::size_t edge : dispatcher_->edges_into(node)) {
    if (const auto produced = dispatcher_->newest_produced(edge)) age_[edge]->record(starts - *produced);
  }
  StepContext context(begun.now, begun.phase);
  std::string error;
  const std::int64_t cpu = measured ? thread_cpu_ns() : 0;
  try {
    nodes.step(node, context);
  } catch (const std::exception& e) {
    error = e.what();
  }
  if (measured) {
    const std::int64_t cpu_ns = std::min<std::int64_t>(thread_cpu_ns() - cpu, UINT32_MAX);
    node_figures[node].cpu_ns.push_back(static_cast<std::uint32_t>(cpu_ns));
  }

  std::vector<std::size_t> woken;
  {
    const std::scoped_lock lock(mutex_);
    const Time now = next_instant();
    catch_up(now);
    if (error.empty()) {
      if (begun.phase == Phase::stopping) at_rest_[node] = context.at_rest();
      dispatcher_->ran(node);
      dispatcher_->free(node);
      if (dispatcher_->phase() != Phase::stopping) record_.put_step(node, begun.now, now - begun.now);
      begin_ready();
    } else {
      // It stays busy and never steps again; the rest goes on while the devices ramp down.
      failed_[node] = true;
      fail(error);
      dispatcher_->failed(node);
      begin_ready();
    }
    woken.swap(woken_);
    const auto next = dispatcher_->next_event();
    if (next && *next < bridge_waits_until_) bridge_condition_.notify_one();
  }
  wake(woken);
}

void LiveRun::Engine::fail(const std::string& why) {
  if (!failure) failure = why;
  // At once, and not when the calling thread next looks: a disk or a terminal may hold that up.
  if (dispatcher_->phase() != Phase::stopping) begin_stop();
}

// The bridge: keeps the time for ticks, and carries out what the loops send.

void LiveRun::Engine::bridge() {
  granted(apply_thread_settings(bridge_settings, "bridge"));
  mutex_.lock();
  while (!bridge_ended_) {
    drain_loops();
    const Time now = next_instant();
    catch_up(now);
    if (dispatcher_->phase() != Phase::stopping && stop_asked()) begin_stop();
    std::vector<std::size_t> woken;
    woken.swap(woken_);
    if (!woken.empty()) {
      mutex_.unlock();
      wake(woken);
      mutex_.lock();
      continue;  // what came meanwhile is looked at before it waits
    }
    bridge_waits_until_ = next_look(now);
    if (const auto next = dispatcher_->next_event()) bridge_waits_until_ = std::min(bridge_waits_until_, *next);
    if (now < end_) bridge_waits_until_ = std::min(bridge_waits_until_, end_);
    bridge_condition_.wait_until(mutex_, (origin_ + (bridge_waits_until_ - Time{})).ns);
  }
  mutex_.unlock();
}

void LiveRun::Engine::drain_loops() {
  for (const auto& loop : loops_) {
    if (!loop) continue;
    const std::size_t n = loop->node();
    RealtimeLane::Out out;
    while (loop->take(out)) {
      const Time now = next_instant();
      catch_up(now);
      if (out.port == RealtimeLane::step_done) {
        dispatcher_->passed(n);
        if (dispatcher_->phase() != Phase::stopping) record_.put_step(n, out.valid, now - out.valid);
      } else {
        const auto port = static_cast<std::size_t>(out.port);
        dispatcher_->publish(n, port, out.valid, out.payload);
        if (plan_.nodes[n].info->outputs[port].type == &message_type<SafetyState>()) {
          std::memcpy(&safety_[n].emplace(), out.payload, sizeof(SafetyState));
        }
        begin_ready();
      }
    }
  }
}

Time LiveRun::Engine::next_look(Time now) const {
  Time look = now + watch_period;
  for (const auto& loop : loops_) {
    if (!loop) continue;
    const std::int64_t due = loop->schedule().last_due(now);
    const LoopFigures& figures = loop->loop().figures();
    const Time next_tick = loop->schedule().deadline(due + 1);
    // A tick that is due and has not been made yet is looked for soon, the next one when it will have been made.
    const bool awaited = due >= 0 && figures.ended.value() + figures.missed.value() <= due;
    look = std::min(look, awaited ? std::min(now + look_again, next_tick) : next_tick + look_after);
  }
  return look;
}

// Watching.

void LiveRun::Engine::watch(RunObserver& observer, const std::function<bool(const LiveStatus&)>& go_on) {
  Time next_ask;
  attend(observer, plan_.graph.duration + head_start, [&] {
    LiveStatus now;
    {
      const std::scoped_lock lock(mutex_);
      if (dispatcher_->phase() == Phase::stopping || clock() >= end_) return true;
      if (clock() < next_ask) return false;
      now = snapshot(false);
    }
    next_ask = now.now + ask_period;
    try {
      return !go_on(now);
    } catch (const std::exception& e) {
      const std::scoped_lock lock(mutex_);
      fail(e.what());
      return true;
    }
  });
}

void LiveRun::Engine::attend(RunObserver& observer, Duration longest, const std::function<bool()>& done) {
  const Time until = clock() + longest;
  while (clock() < until && !done()) {
    drain_record(observer);
    {
      const std::scoped_lock lock(mutex_);
      look_for_stalls();
    }
    MonotonicClock::sleep_until(origin_ + (std::min(clock() + watch_period, until) - Time{}));
  }
}

void LiveRun::Engine::drain_record(RunObserver& observer) {
  try {
    record_.drain(observer);
  } catch (const std::exception& e) {
    const std::scoped_lock lock(mutex_);
    fail(e.what());
  }
}

void LiveRun::Engine::look_for_stalls() {
  const Time now = clock();
  stalls_.begin(now);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (failed_[n]) continue;
    if (loops_[n]) look_for_failure(n);
    const bool idle = loops_[n] ? !loops_[n]->loop().running() : !dispatcher_->busy(n);
    const StallWatch::Node& watched = stalls_.look(n, steps_ended(n), idle);
    if (watched.stalled && plan_.graph.live.on_stall == OnStall::stop) {
      fail("node " + plan_.nodes[n].name + " (" + plan_.nodes[n].info->type + ") has stalled: a step of about " +
           std::to_string(watched.moved.seconds()) + " s has not come back for " +
           std::to_string((now - watched.moved).seconds()) + " s; live.stall_timeout of the graph is " +
           std::to_string(plan_.graph.live.stall_timeout.seconds()) + " s");
    }
  }
}

void LiveRun::Engine::look_for_failure(std::size_t node) {
  const std::exception_ptr thrown = loops_[node]->loop().failure();
  if (!thrown) return;
  failed_[node] = true;
  try {
    std::rethrow_exception(thrown);
  } catch (const std::exception& e) {
    fail(e.what());
  }
}

LiveStatus LiveRun::Engine::snapshot(bool whole) {
  LiveStatus s;
  s.now = clock();
  s.phase = dispatcher_->phase();
  if (s.phase == Phase::starting) s.waiting_for = dispatcher_->waiting_for();
  s.missing = missing_;
  s.record_dropped = record_.dropped();
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    s.nodes.push_back({dispatcher_->steps(n), dispatcher_->missed_ticks(n), stalls_.stalled(n)});
    if (!loops_[n]) continue;
    const RealtimeLane& loop = *loops_[n];
    const LoopFigures& figures = loop.loop().figures();
    LiveDevice device;
    device.node = n;
    device.ticks = static_cast<std::uint64_t>(figures.ended.value());
    device.missed = static_cast<std::uint64_t>(figures.missed.value());
    device.wake_latency = figures_of(figures.wake_latency, whole);
    device.body_time = figures_of(figures.body_time, whole);
    device.body_sum = Duration{figures.body_ns.value()};
    device.end_to_end = figures_of(loop.end_to_end(), whole);
    if (heap_calls_are_counted()) device.heap_calls = static_cast<std::uint64_t>(figures.heap_calls.value());
    device.page_faults = static_cast<std::uint64_t>(figures.page_faults.value());
    device.dropped = loop.dropped_out();
    device.safety = safety_[n];
    s.nodes.back().steps = device.ticks;
    s.nodes.back().missed_ticks = device.missed;
    s.devices.push_back(device);
  }
  for (std::size_t e = 0; e < plan_.edges.size(); ++e) {
    const auto& loop = loops_[plan_.edges[e].to];
    LiveEdge edge{dispatcher_->edge_figures(e), figures_of(loop ? *loop->age(e) : *age_[e], whole)};
    if (loop) edge.figures.dropped += loop->dropped_in(e);
    s.edges.push_back(edge);
  }
  return s;
}

// Ending.

std::int64_t LiveRun::Engine::steps_ended(std::size_t node) const {
  const auto& loop = loops_[node];
  return loop ? loop->loop().figures().ended.value() : static_cast<std::int64_t>(dispatcher_->steps(node));
}

std::vector<std::size_t> LiveRun::Engine::devices_not_at_rest() const {
  std::vector<std::size_t> devices;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (!plan_.nodes[n].info->actuator || failed_[n]) continue;
    if (!(loops_[n] ? loops_[n]->at_rest() : at_rest_[n])) devices.push_back(n);
  }
  return devices;
}

std::vector<std::size_t> LiveRun::Engine::busy_nodes() const {
  std::vector<std::size_t> busy;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    if (dispatcher_->busy(n) && !failed_[n]) busy.push_back(n);
  }
  return busy;
}

void LiveRun::Engine::wind_down(RunObserver& observer) {
  {
    const std::scoped_lock lock(mutex_);
    catch_up(next_instant());
    if (dispatcher_->phase() != Phase::stopping) begin_stop();
  }
  std::vector<std::int64_t> steps(nodes.size(), -1);
  Time ticked = clock();
  attend(observer, longest_ramp_down, [&] {
    const std::scoped_lock lock(mutex_);
    const std::vector<std::size_t> moving = devices_not_at_rest();
    for (const std::size_t n : moving) {
      const std::int64_t before = std::exchange(steps[n], steps_ended(n));
      if (before != steps[n]) ticked = clock();
    }
    return moving.empty() || clock() - ticked > longest_without_tick;
  });
  for (const auto& loop : loops_) {
    if (!loop || loop->stop(longest_step_at_end)) continue;
    abandoned = true;
    const std::scoped_lock lock(mutex_);
    fail("device node " + plan_.nodes[loop->node()].name + " does not come back from its step");
  }
  attend(observer, longest_step_at_end, [this] {
    const std::scoped_lock lock(mutex_);
    ended_ = true;
    return busy_nodes().empty();
  });
  {
    const std::scoped_lock lock(mutex_);
    for (const std::size_t n : busy_nodes()) {
      abandoned = true;
      fail("node " + plan_.nodes[n].name + " (" + plan_.nodes[n].info->type + ") does not come back from its step");
    }
    for (const std::size_t n : devices_not_at_rest()) {
      fail("device node " + plan_.nodes[n].name + " has not come to rest: its last force may still act");
    }
    drain_loops();
    bridge_ended_ = true;
    bridge_condition_.notify_one();
  }
  bridge_.join();
  drain_record(observer);
  status.record_dropped = record_.dropped();
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    node_figures[n].steps = status.nodes[n].steps;
    node_figures[n].missed_ticks = status.nodes[n].missed_ticks;
  }
  if (abandoned) return;
  for (const caf::actor& actor : actors_) {
    if (actor) caf::anon_send_exit(actor, caf::exit_reason::user_shutdown);
  }
  actors_.clear();
  system_.reset();
}

// The interface.

LiveRun::LiveRun(const Plan& plan) : engine_(std::make_unique<Engine>(plan)) {}
LiveRun::~LiveRun() = default;

void LiveRun::stop_when(std::function<bool()> asked) {
  engine_->stop_asked = std::move(asked);
}
void LiveRun::run(RunObserver& observer, const std::function<bool(const LiveStatus&)>& go_on) {
  engine_->run(observer, go_on);
}
const std::optional<std::string>& LiveRun::failure() const {
  return engine_->failure;
}
bool LiveRun::is_abandoned() const {
  return engine_->abandoned;
}
PlanNodes& LiveRun::nodes() {
  return engine_->nodes;
}
const LiveStatus& LiveRun::status() const {
  return engine_->status;
}
const NodeFigures& LiveRun::node_figures(std::size_t node) const {
  return engine_->node_figures[node];
}

}  // namespace tactor
