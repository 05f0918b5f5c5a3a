// A line whose answers a test scripts, and what was sent over it.
#pragma once

#include <sched.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "devices/hardware/link.hpp"

namespace tactor::test {

/// Waits, with a patience that no loaded machine uses up, until `condition` holds; whether it did.
inline bool eventually(const std::function<bool()>& condition) {
  for (int i = 0; i < 30'000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

/// What test and line share; it outlives the line.
struct LinkScript {
  std::atomic<bool> opens{true};    ///< whether the line can be opened
  std::atomic<int> fails{0};        ///< cycles yet to fail
  std::atomic<bool> reopen{false};  ///< whether a failure ends the connection
  std::atomic<LinkError> error{LinkError::timeout};
  std::atomic<double> q{0};  ///< what the axis shows
  std::atomic<std::uint32_t> faults{0};
  std::atomic<double> effort{0};  ///< given last
  std::atomic<int> cycles{0}, openings{0}, closings{0}, attempts{0};
  std::atomic<int> policy{-1}, priority{-1};  ///< of the thread in the newest cycle
  std::atomic<bool> slow{false};              ///< a cycle takes 30 ms
  LinkPace pace = LinkPace::deadlines;
  LinkLimits limits;  ///< that it says of itself

  std::mutex mutex;
  std::vector<double> efforts;                                ///< all that were given, and -1000 at each opening
  std::vector<std::chrono::steady_clock::time_point> begins;  ///< of the cycles
  [[nodiscard]] std::vector<double> given() {
    const std::scoped_lock lock(mutex);
    return efforts;
  }
};
inline constexpr double opening_mark = -1000;

class ScriptedLink final : public Link {
 public:
  explicit ScriptedLink(LinkScript& script) : script_(script) {}
  [[nodiscard]] std::string name() const override { return "test rig at port 7"; }
  bool open(LinkFailure& failure) override {
    ++script_.attempts;
    if (!script_.opens) {
      failure = {LinkError::disconnected, "nobody answers", true};
      return false;
    }
    ++script_.openings;
    const std::scoped_lock lock(script_.mutex);
    script_.efforts.push_back(opening_mark);
    return true;
  }
  [[nodiscard]] LinkLimits limits() const override { return script_.limits; }
  [[nodiscard]] LinkPace pace() const override { return script_.pace; }
  bool exchange(const LinkCommand& command, LinkSample& sample, LinkFailure& failure) override {
    {
      const std::scoped_lock lock(script_.mutex);
      script_.begins.push_back(std::chrono::steady_clock::now());
    }
    if (script_.slow) std::this_thread::sleep_for(std::chrono::milliseconds(30));
    if (script_.fails > 0) {
      --script_.fails;
      failure = {script_.error, "no answer within 5 ms", script_.reopen};
      return false;
    }
    sched_param parameter{};
    sched_getparam(0, &parameter);
    script_.policy = sched_getscheduler(0);
    script_.priority = parameter.sched_priority;
    ++script_.cycles;
    script_.effort = command.effort[0];
    {
      const std::scoped_lock lock(script_.mutex);
      script_.efforts.push_back(command.effort[0]);
    }
    sample.q[0] = script_.q;
    sample.faults = script_.faults;
    if (sample.faults != 0) failure.text = "it is too hot";
    return true;
  }
  void close() override { ++script_.closings; }

 private:
  LinkScript& script_;
};

}  // namespace tactor::test
