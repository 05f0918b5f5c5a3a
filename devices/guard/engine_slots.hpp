// The loop in the engine's process, as the guard's thread sees it: what is believed of it, and what it is told.
#pragma once

#include <atomic>
#include <cstdint>

#include "devices/hardware/guard_share.hpp"

namespace tactor {

/// Takes orders out of shared memory. An order is refused, and the one before goes on to age, where
/// - its record is damaged or not newer than the last one;
/// - it is of the future, or holds for longer than a command may: its clock is another one;
/// - it is of an older epoch: whoever gave it did not know yet that the command was cut, as a process that was stopped
///   and goes on. It is obeyed again when it has seen the cut and has engaged anew (see CommandChannel);
/// - the guard is ending.
class EngineSlots final : public LineOutside {
 public:
  /// `expires_after`: the longest that a command may hold.
  EngineSlots(GuardShare& share, Duration expires_after)
      : orders_(share.orders), reports_(share.reports), expires_after_(expires_after) {}

  void admit(Instant now, LineCycle& cycle) noexcept override;
  void given(const LinkCommand& command) noexcept override;
  void delivered() noexcept override;
  void publish(const LinkReport& report) noexcept override;

  // Any thread.

  /// From now on no order is obeyed, so that the command expires and goes to zero.
  void refuse_all() { refuses_.store(true, std::memory_order_release); }
  /// True where the device has got zero and nothing was given since, or was never given anything.
  [[nodiscard]] bool at_rest() const { return at_rest_.load(std::memory_order_acquire); }
  /// Orders that were refused, but for those after refuse_all.
  [[nodiscard]] std::uint64_t refused() const { return refused_.load(std::memory_order_relaxed); }

 private:
  [[nodiscard]] bool believes(const GuardOrder& order, Instant now) const noexcept;

  SlotReader<GuardOrder> orders_;
  SlotWriter<LinkReport> reports_;
  const Duration expires_after_;
  std::uint64_t epoch_ = 0;  // cuts that were published
  bool gave_zero_ = true;    // last
  std::atomic<bool> refuses_{false};
  std::atomic<bool> at_rest_{true};
  std::atomic<std::uint64_t> refused_{0};
};

}  // namespace tactor
