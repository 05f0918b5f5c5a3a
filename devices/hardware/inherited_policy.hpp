// The scheduling policy that one thread takes over from another.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "framework/realtime/privilege.hpp"

namespace tactor {

/// Gives a thread the policy of the one that it serves, one priority below it where that is a real-time one.
class InheritedPolicy {
 public:
  /// The thread that is served: remembers its policy at the first call. Wait-free.
  void remember() noexcept {
    if (!told_) tell();
  }
  /// The serving thread: takes the policy over once it is known, and names the thread. Returns what the system refused.
  std::vector<Refusal> take(const std::string& thread_name);

 private:
  void tell() noexcept;

  bool told_ = false;  // the served thread's
  // Written by it before the flag; policy as the system numbers them.
  int policy_ = 0, priority_ = 0, nice_ = 0;
  std::atomic<bool> known_{false};
  bool taken_ = false;  // the serving thread's
};

}  // namespace tactor
