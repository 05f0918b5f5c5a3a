// Watching a live run: its progress, steps that do not come back, and the way to its end.
#include <algorithm>
#include <exception>
#include <mutex>
#include <utility>

#include "framework/core/clock.hpp"
#include "framework/engine/live/live_engine.hpp"
#include "framework/graph/texts.hpp"
#include "framework/realtime/allocation_watch.hpp"

namespace tactor {

namespace {

/// How long devices may take to come to rest at the end: more than the longest ramp_down_time that one may have. One
/// that does not tick any more is not waited for so long.
constexpr Duration longest_ramp_down{15'000'000'000};
constexpr Duration longest_without_tick{2'000'000'000};

}  // namespace

bool LiveEngine::is_running() {
  const std::scoped_lock lock(mutex_);
  return dispatcher_->phase() != Phase::stopping && clock() < end();
}

void LiveEngine::stop(const std::string& why) {
  const std::scoped_lock lock(mutex_);
  if (!why.empty()) return fail(why);
  catch_up(next_instant());
  if (dispatcher_->phase() != Phase::stopping) begin_stop(false);
}

EngineStatus LiveEngine::status() {
  if (finished_) return status_;
  EngineStatus now;
  {
    const std::scoped_lock lock(mutex_);
    now = counters();
  }
  add_latencies(now, false);
  return now;
}

std::optional<std::string> LiveEngine::failure() const {
  const std::scoped_lock lock(mutex_);
  return failure_;
}

Duration LiveEngine::cpu_time() const {
  return clock_time(CLOCK_PROCESS_CPUTIME_ID);
}

bool LiveEngine::attend(const Attendance& attendance) {
  bool served = true;
  const auto attempt = [this](const auto& work) {
    try {
      work();
    } catch (const std::exception& error) {
      stop(error.what());
    } catch (...) {
      stop("something that is no exception was thrown beside the run");
    }
  };
  // First, so that no disk of a reader holds up the muting of a force.
  attempt([&] { served = attendance.serve(); });
  attempt([&] { attendance.read(); });
  attempt([this] { step_times_.take(); });
  return served;
}

void LiveEngine::advance(Duration duration, const Attendance& attendance) {
  const Instant until = MonotonicClock::now() + duration;
  while (is_running() && MonotonicClock::now() < until) {
    const Duration pause = attend(attendance) ? watch_period : waiting_period;
    MonotonicClock::sleep_until(std::min(MonotonicClock::now() + pause, until));
  }
  attend(attendance);
}

void LiveEngine::attend_until(const Attendance& attendance, Duration longest, const std::function<bool()>& done) {
  const Time until = clock() + longest;
  while (clock() < until && !done()) {
    attend(attendance);
    MonotonicClock::sleep_until(origin_ + (std::min(clock() + watch_period, until) - Time{}));
  }
}

void LiveEngine::look_for_stalls() {
  const Time now = clock();
  stalls_.begin(now);
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (steps_[n].failed) continue;
    const RealtimeLane* const loop = loop_of(n);
    if (loop != nullptr) look_for_failure(n);
    const bool idle =
        loop != nullptr ? !loop->loop().running() || loop->stepping() != n : !dispatcher_->busy(n) || steps_.is_held(n);
    const StallWatch::Node& watched = stalls_.look(n, steps_ended(n), idle);
    flight_.watch(n, watched.stalled, watched.moved);
    if (watched.stalled && plan_.graph.live.on_stall == OnStall::stop) {
      // To the period of the looks, which is all that is known.
      const auto rounded = [](Duration d) { return duration_text(Duration{d.ns / 10'000'000 * 10'000'000}); };
      fail("node " + plan_.nodes[n].name + " (" + plan_.nodes[n].info->type + ") has stalled: its step, begun " +
               rounded(watched.moved - Time{}) + " after the start of the run, has not come back for " +
               rounded(now - watched.moved) + "; live.stall_timeout of the graph is " +
               duration_text(plan_.graph.live.stall_timeout) + shared_text(n),
           n);
    }
  }
}

void LiveEngine::look_for_failure(std::size_t node) {
  const std::exception_ptr thrown = loop_of(node)->failure(node);
  if (!thrown) return;
  steps_[node].failed = true;
  try {
    std::rethrow_exception(thrown);
  } catch (const std::exception& e) {
    fail(e.what(), node);
  }
}

std::string LiveEngine::shared_text(std::size_t node) const {
  if (!lanes_.chains.of[node]) return {};
  std::vector<std::size_t> others = lanes_.chains.nodes[*lanes_.chains.of[node]];
  std::erase(others, node);
  return others.empty() ? "" : "; it shares its loop with " + node_names(plan_, others);
}

EngineStatus LiveEngine::counters() const {
  const Time now = clock();
  EngineStatus s = dispatcher_->status();
  s.now = now;
  s.missing = missing_;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    s.nodes[n].stalled = stalls_.stalled(n);
    s.nodes[n].failed = steps_[n].failed;
    const RealtimeLane* const loop = loop_of(n);
    if (loop == nullptr) continue;
    const LoopStatistics& metrics = loop->loop().metrics();
    DeviceStatus device;
    device.node = n;
    device.ticks = static_cast<std::uint64_t>(metrics.ended.value());
    device.missed = static_cast<std::uint64_t>(metrics.missed.value());
    device.body_sum = (*loop)[n].body_sum();
    if (heap_calls_are_counted()) device.heap_calls = static_cast<std::uint64_t>(metrics.heap_calls.value());
    device.page_faults = static_cast<std::uint64_t>(metrics.page_faults.value());
    device.dropped = loop->dropped_out();
    s.nodes[n].steps = device.ticks;
    s.nodes[n].missed_ticks = device.missed;
    s.devices.push_back(device);
  }
  return s;
}

void LiveEngine::add_latencies(EngineStatus& s, bool whole) const {
  for (DeviceStatus& device : s.devices) {
    const RealtimeLane& loop = *loop_of(device.node);
    const LaneNode& node = loop[device.node];
    device.wake_latency = metrics_of(loop.loop().metrics().wake_latency, whole);
    device.body_time = metrics_of(node.body_time(), whole);
    device.end_to_end = metrics_of(node.end_to_end(), whole);
  }
  for (std::size_t e = 0; e < plan_.edges.size(); ++e) {
    const std::size_t reader = plan_.edges[e].to;
    const RealtimeLane* const loop = loop_of(reader);
    s.edges[e].age = metrics_of(loop != nullptr ? *(*loop)[reader].age(e) : *age_[e], whole);
  }
}

// Ending.

std::int64_t LiveEngine::steps_ended(std::size_t node) const {
  const RealtimeLane* const loop = loop_of(node);
  return loop != nullptr ? loop->loop().metrics().ended.value()
                         : static_cast<std::int64_t>(dispatcher_->steps(node)) - (dispatcher_->busy(node) ? 1 : 0);
}

std::vector<std::size_t> LiveEngine::devices_not_at_rest() const {
  std::vector<std::size_t> devices;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (!plan_.nodes[n].info->actuator || steps_[n].failed) continue;
    const RealtimeLane* const loop = loop_of(n);
    if (!(loop != nullptr ? (*loop)[n].at_rest() : steps_[n].at_rest)) devices.push_back(n);
  }
  return devices;
}

std::vector<std::size_t> LiveEngine::busy_nodes() const {
  std::vector<std::size_t> busy;
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (dispatcher_->busy(n) && !steps_[n].failed && !steps_.is_held(n)) busy.push_back(n);
  }
  return busy;
}

void LiveEngine::finish(const Attendance& attendance) {
  stop("");
  std::vector<std::int64_t> steps(nodes_.size(), -1);
  Time ticked = clock();
  attend_until(attendance, longest_ramp_down, [&] {
    const std::scoped_lock lock(mutex_);
    const std::vector<std::size_t> moving = devices_not_at_rest();
    for (const std::size_t n : moving) {
      const std::int64_t before = std::exchange(steps[n], steps_ended(n));
      if (before != steps[n]) ticked = clock();
    }
    return moving.empty() || clock() - ticked > longest_without_tick;
  });
  for (const auto& loop : loops_) {
    if (loop->stop(longest_step_at_end)) continue;
    abandoned_ = true;
    const std::scoped_lock lock(mutex_);
    const std::size_t n = loop->stepping();
    fail("node " + plan_.nodes[n].name + " does not come back from its step" + shared_text(n), n);
  }
  attend_until(attendance, longest_step_at_end, [this] {
    const std::scoped_lock lock(mutex_);
    steps_.end();
    return busy_nodes().empty();
  });
  {
    const std::scoped_lock lock(mutex_);
    for (const std::size_t n : busy_nodes()) {
      abandoned_ = true;
      fail("node " + plan_.nodes[n].name + " (" + plan_.nodes[n].info->type + ") does not come back from its step", n);
    }
    for (const std::size_t n : devices_not_at_rest()) {
      // Beside whatever else was wrong, since a person has it in the hand.
      const std::string text = "device node " + plan_.nodes[n].name + " has not stopped: its last force may still act";
      fail(failure_ ? std::exchange(failure_, std::nullopt).value() + "; " + text : text, n);
    }
    drain_loops();
  }
  end_timer();
  attend(attendance);
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    steps_[n].statistics.steps = status_.nodes[n].steps;
    steps_[n].statistics.missed_ticks = status_.nodes[n].missed_ticks;
  }
  finished_ = true;
  flight_.end(failure_.has_value());
  if (!abandoned_) end_threads();
}

void LiveEngine::end_timer() {
  {
    const std::scoped_lock lock(mutex_);
    timer_.ended = true;
    timer_.condition.notify_one();
  }
  if (timer_.thread.joinable()) timer_.thread.join();
}

void LiveEngine::end_threads() {
  end_timer();
  actors_.end();
}

}  // namespace tactor
