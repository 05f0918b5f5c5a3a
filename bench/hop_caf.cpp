#include "bench/hop_caf.hpp"

#include <caf/all.hpp>
#include <thread>

#include "framework/realtime/thread_policy.hpp"

CAF_ALLOW_UNSAFE_MESSAGE_TYPE(tactor::Wrench)

namespace tactor::bench {

namespace {

using Tick = caf::atom_constant<caf::atom("tick")>;

constexpr Duration period{1'000'000};

class Sender final : public caf::event_based_actor {
 public:
  Sender(caf::actor_config& config, caf::actor receiver, const HopMeter& meter)
      : caf::event_based_actor(config), receiver_(std::move(receiver)), meter_(meter) {}
  caf::behavior make_behavior() override {
    return {[this](Tick) { send(receiver_, meter_.message()); }};
  }

 private:
  caf::actor receiver_;
  const HopMeter& meter_;
};

class Receiver final : public caf::event_based_actor {
 public:
  Receiver(caf::actor_config& config, HopMeter& meter) : caf::event_based_actor(config), meter_(meter) {}
  caf::behavior make_behavior() override {
    return {[this](const Wrench& message) { meter_.received(message); }};
  }

 private:
  HopMeter& meter_;
};

void configure(caf::actor_system_config& config, CafScheduler scheduler, int workers) {
  if (scheduler == CafScheduler::defaults) return;
  config.set("scheduler.max-threads", static_cast<std::size_t>(workers));
  if (scheduler == CafScheduler::sharing) {
    config.set("scheduler.policy", caf::atom("sharing"));
    return;
  }
  config.set("work-stealing.aggressive-poll-attempts", std::size_t{1});
  config.set("work-stealing.moderate-poll-attempts", std::size_t{0});
  config.set("work-stealing.relaxed-sleep-duration", caf::timespan(std::chrono::milliseconds(100)));
}

void tick(const caf::actor& sender, const ThreadSettings& settings, Duration duration) {
  apply_thread_settings(settings, "timer");
  const Instant begin = MonotonicClock::now() + period;
  for (Instant due = begin; due - begin < duration; due = due + period) {
    MonotonicClock::sleep_until(due);
    caf::anon_send(sender, Tick::value);
  }
}

}  // namespace

void hop_by_caf(CafScheduler scheduler, bool detached, int workers, const ThreadSettings& threads,
                const ThreadSettings& timer, Duration duration, HopMeter& meter) {
  // CAF's threads inherit the policy of the thread that makes the system.
  std::thread home([&] {
    apply_thread_settings(threads, "caf");
    caf::actor_system_config config;
    configure(config, scheduler, workers);
    caf::actor_system system(config);
    const caf::actor receiver = system.spawn<Receiver>(meter);
    const caf::actor sender =
        detached ? system.spawn<Sender, caf::detached>(receiver, meter) : system.spawn<Sender>(receiver, meter);
    std::thread(tick, sender, timer, duration).join();
    caf::anon_send_exit(sender, caf::exit_reason::user_shutdown);
    caf::anon_send_exit(receiver, caf::exit_reason::user_shutdown);
  });
  home.join();
}

}  // namespace tactor::bench
