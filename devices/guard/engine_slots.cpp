#include "devices/guard/engine_slots.hpp"

#include <algorithm>

namespace tactor {

bool EngineSlots::believes(const GuardOrder& order, Instant now) const noexcept {
  if (order.epoch != epoch_) return false;
  if (order.produced > now || order.zeroed > order.produced) return false;
  return order.deadline >= order.produced && order.deadline - order.produced <= expires_after_;
}

void EngineSlots::admit(Instant now, LineCycle& cycle) noexcept {
  GuardOrder order;
  const SlotFound found = orders_.take(order);
  if (found == SlotFound::nothing || refuses_.load(std::memory_order_acquire)) return;
  // It may have been given between the reading of the clock and here.
  const Instant latest = std::max(now, MonotonicClock::now());
  if (found == SlotFound::damaged || !believes(order, latest)) {
    refused_.store(refused_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    return;
  }
  // An order that ends sooner than a command may counts as an older one.
  cycle.pass_on(order.deadline - expires_after_, order.command, order.zeroed);
}

void EngineSlots::given(const LinkCommand& command) noexcept {
  gave_zero_ = command.is_zero();
  if (!gave_zero_) at_rest_.store(false, std::memory_order_release);
}

void EngineSlots::delivered() noexcept {
  if (gave_zero_) at_rest_.store(true, std::memory_order_release);
}

void EngineSlots::publish(const LinkReport& report) noexcept {
  epoch_ = report.cuts;
  reports_.put(report);
}

}  // namespace tactor
