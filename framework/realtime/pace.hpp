// What a loop waits for in place of its deadlines: something that comes at a pace of its own.
#pragma once

#include <atomic>
#include <cstdint>

#include "framework/realtime/monotonic_clock.hpp"

namespace tactor {

/// The beats of one thread, for which another one waits. Neither locks or allocates.
class Pace {
 public:
  /// `between_processes`: it lies in memory that two processes share.
  explicit Pace(bool between_processes = false) noexcept : between_processes_(between_processes) {}
  /// The thread that sets the pace. A system call only where the other one waits.
  void beat() noexcept;

  /// Beats so far.
  [[nodiscard]] std::uint32_t beats() const noexcept { return beats_.load(std::memory_order_acquire); }
  /// When the newest beat came.
  [[nodiscard]] Instant newest() const noexcept { return {newest_ns_.load(std::memory_order_relaxed)}; }
  /// Returns where there are other than `seen` beats, or at `end`, or sooner. One thread waits.
  void wait(std::uint32_t seen, Instant end) noexcept;

 private:
  const bool between_processes_;
  std::atomic<std::uint32_t> beats_{0};
  std::atomic<bool> waits_{false};
  std::atomic<std::int64_t> newest_ns_{0};
};

}  // namespace tactor
