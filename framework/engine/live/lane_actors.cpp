#include "framework/engine/live/lane_actors.hpp"

#include <caf/logger.hpp>
#include <caf/send.hpp>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

/// The thread that makes an actor system keeps a share of its logger until the thread ends, and the end of the system
/// waits for all shares: on another thread for ever, where the first goes on.
struct LoggerOfThread {
  LoggerOfThread() = default;
  LoggerOfThread(const LoggerOfThread&) = delete;
  LoggerOfThread& operator=(const LoggerOfThread&) = delete;
  ~LoggerOfThread() { caf::logger::set_current_actor_system(nullptr); }
};

}  // namespace

void LaneActors::make(const LanePlan& lanes, const LaneScheduler::OnThread& on_thread,
                      const std::function<void(std::size_t node)>& step) {
  config_.module_factories.push_back(
      [lanes = lanes.lanes, on_thread](caf::actor_system& system) -> caf::actor_system::module* {
        return new LaneScheduler(system, lanes, on_thread);
      });
  const LoggerOfThread given_back;
  system_ = std::make_unique<caf::actor_system>(config_);
  const auto& refused = dynamic_cast<const LaneScheduler&>(system_->scheduler()).refused();
  if (refused) throw RunError(*refused);
  for (std::size_t n = 0; n < lanes.lane_of.size(); ++n) {
    actors_.emplace_back();
    if (lanes.realtime[n]) continue;
    actors_[n] = system_->spawn<LaneActor>(lanes.lane_of[n], std::function<void()>([step, n] { step(n); }));
  }
}

void LaneActors::ask(const std::vector<std::size_t>& nodes) {
  for (const std::size_t n : nodes) caf::anon_send(actors_[n], step_message_);
}

void LaneActors::end() {
  for (const caf::actor& actor : actors_) {
    if (actor) caf::anon_send_exit(actor, caf::exit_reason::user_shutdown);
  }
  actors_.clear();
  system_.reset();
}

}  // namespace tactor
