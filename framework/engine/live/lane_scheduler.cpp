#include "framework/engine/live/lane_scheduler.hpp"

#include <mutex>

#include "framework/core/check.hpp"
#include "framework/realtime/make_thread.hpp"

namespace tactor {

namespace {

/// Only what asks for a timeout or a delayed message gets here, and nothing in a live run does.
[[noreturn]] void not_asked_for() {
  TACTOR_DEMAND(!"a live run has no timeouts and no delayed messages");
  std::abort();
}

}  // namespace

void NoTimeouts::set_ordinary_timeout(time_point, caf::abstract_actor*, caf::atom_value, std::uint64_t) {
  not_asked_for();
}
void NoTimeouts::set_multi_timeout(time_point, caf::abstract_actor*, caf::atom_value, std::uint64_t) {
  not_asked_for();
}
void NoTimeouts::set_request_timeout(time_point, caf::abstract_actor*, caf::message_id) {
  not_asked_for();
}
void NoTimeouts::schedule_message(time_point, caf::strong_actor_ptr, caf::mailbox_element_ptr) {
  not_asked_for();
}
void NoTimeouts::schedule_message(time_point, caf::group, caf::strong_actor_ptr, caf::message) {
  not_asked_for();
}
// Every actor cancels its timeouts when it ends, whether it had any or not.
void NoTimeouts::cancel_ordinary_timeout(caf::abstract_actor*, caf::atom_value) {}
void NoTimeouts::cancel_request_timeout(caf::abstract_actor*, caf::message_id) {}
void NoTimeouts::cancel_timeouts(caf::abstract_actor*) {}
void NoTimeouts::cancel_all() {}

LaneActor::LaneActor(caf::actor_config& config, std::size_t lane, std::function<void()> step)
    : caf::event_based_actor(config), lane_(lane), step_(std::move(step)) {}

caf::behavior LaneActor::make_behavior() {
  return {[this](Step) { step_(); }};
}

struct LaneScheduler::Lane {
  LaneSpec spec;
  PriorityMutex mutex;
  PriorityCondition condition;
  std::deque<caf::resumable*> jobs;  // each with a reference of the queue's
  bool ended = false;
  std::vector<std::unique_ptr<Worker>> workers;
};

class LaneScheduler::Worker final : public caf::execution_unit {
 public:
  Worker(LaneScheduler& scheduler, Lane& lane)
      : caf::execution_unit(&scheduler.system()),
        scheduler_(scheduler),
        lane_(lane),
        thread_(make_thread(lane.spec.name, [this] { run(); })) {}
  ~Worker() override { thread_.join(); }

  void exec_later(caf::resumable* job) override { scheduler_.enqueue(job); }
  /// The lane that the calling thread works on; null where it is no worker.
  static const Lane* current_lane() { return current_lane_; }

 private:
  void run() {
    current_lane_ = &lane_;
    system().thread_started();
    scheduler_.on_thread_(lane_.spec);
    while (caf::resumable* job = next()) {
      switch (job->resume(this, scheduler_.max_throughput())) {
        case caf::resumable::resume_later:
          scheduler_.enqueue(job);
          break;
        case caf::resumable::done:
        case caf::resumable::awaiting_message:
        case caf::resumable::shutdown_execution_unit:
          caf::intrusive_ptr_release(job);
          break;
      }
    }
    system().thread_terminates();
  }
  caf::resumable* next() {
    const std::scoped_lock lock(lane_.mutex);
    while (lane_.jobs.empty() && !lane_.ended) lane_.condition.wait(lane_.mutex);
    if (lane_.jobs.empty()) return nullptr;
    caf::resumable* job = lane_.jobs.front();
    lane_.jobs.pop_front();
    return job;
  }

  static thread_local const Lane* current_lane_;

  LaneScheduler& scheduler_;
  Lane& lane_;
  std::thread thread_;
};

thread_local const LaneScheduler::Lane* LaneScheduler::Worker::current_lane_ = nullptr;

LaneScheduler::LaneScheduler(caf::actor_system& system, std::vector<LaneSpec> lanes, OnThread on_thread)
    : caf::scheduler::abstract_coordinator(system), on_thread_(std::move(on_thread)) {
  for (LaneSpec& spec : lanes) {
    lanes_.push_back(std::make_unique<Lane>());
    lanes_.back()->spec = std::move(spec);
  }
}

LaneScheduler::~LaneScheduler() = default;

void LaneScheduler::start() {
  // CAF's own start would spawn its printer, a detached actor: nothing here prints through CAF.
  max_throughput_ = 1;
  try {
    for (const auto& lane : lanes_) {
      for (int i = 0; i < lane->spec.workers; ++i) lane->workers.push_back(std::make_unique<Worker>(*this, *lane));
    }
  } catch (const RunError& error) {
    refused_ = error.what();
  }
}

void LaneScheduler::stop() {
  for (const auto& lane : lanes_) {
    {
      const std::scoped_lock lock(lane->mutex);
      lane->ended = true;
    }
    lane->condition.notify_all();
  }
  for (const auto& lane : lanes_) lane->workers.clear();
  for (const auto& lane : lanes_) {
    for (caf::resumable* job : lane->jobs) cleanup_and_release(job);
    lane->jobs.clear();
  }
}

void LaneScheduler::enqueue(caf::resumable* job) {
  const auto* actor = dynamic_cast<const LaneActor*>(job);
  Lane& lane = *lanes_[actor == nullptr ? 0 : actor->lane()];
  bool by_another = false;
  {
    const std::scoped_lock lock(lane.mutex);
    lane.jobs.push_back(job);
    // A worker asks for steps at the end of one, and takes the first of them itself sooner than another would wake up.
    by_another = lane.jobs.size() > 1 || Worker::current_lane() != &lane;
  }
  if (by_another) lane.condition.notify_one();
}

}  // namespace tactor
