#include "nodes/experiment/felt_force.hpp"

#include <algorithm>
#include <limits>

namespace tactor {

namespace {

constexpr double lever = 0.05;  // m

/// A device that displays less than this part of a force that is wanted, and by more than `faded_force` less, limits
/// it; a torque likewise, where `faded_force` at the lever is 5 mN m.
constexpr double limited_below = 0.99;

bool is_less(double shown, double asked, double least) {
  return shown < limited_below * asked && shown < asked - least;
}

}  // namespace

double size_of(const Wrench& wrench) {
  return std::max(norm(wrench.force), norm(wrench.torque) / lever);
}

void FeltForce::begin(std::size_t interval, bool connected) {
  intervals_[interval] = {.connected = connected};
}

FeltForce::Comparison FeltForce::compare(const Stamped<Wrench>& shown, Input<Wrench>& wanted) {
  // What the device would display without its limits, at the same tick.
  while (!wanted_ || wanted_->stamp.valid < shown.stamp.valid) {
    Stamped<Wrench> next;
    if (!wanted.pop(next)) break;
    wanted_ = next;
  }
  if (!wanted_ || wanted_->stamp.valid != shown.stamp.valid) return Comparison::none;
  const Wrench& asked = wanted_->value;
  const bool less = is_less(norm(shown.value.force), norm(asked.force), faded_force) ||
                    is_less(norm(shown.value.torque), norm(asked.torque), faded_force * lever);
  return less ? Comparison::less : Comparison::enough;
}

void FeltForce::read(Input<Wrench>& felt, Input<Wrench>& wanted, std::optional<std::size_t> interval) {
  Stamped<Wrench> shown;
  while (felt.pop(shown)) {
    newest_ = size_of(shown.value);
    const Comparison comparison = compare(shown, wanted);
    if (!interval) continue;
    Interval& now = intervals_[*interval];
    now.peak = std::max(now.peak, norm(shown.value.force));
    now.ticks += comparison != Comparison::none ? 1 : 0;
    now.limited += comparison == Comparison::less ? 1 : 0;
  }
}

double FeltForce::peak(std::size_t interval) const {
  return intervals_[interval].connected ? intervals_[interval].peak : std::numeric_limits<double>::quiet_NaN();
}

double FeltForce::limited_share(std::size_t interval) const {
  const Interval& of = intervals_[interval];
  return of.ticks > 0 ? static_cast<double>(of.limited) / of.ticks : std::numeric_limits<double>::quiet_NaN();
}

bool FeltForce::is_limited() const {
  return std::any_of(intervals_.begin(), intervals_.end(), [](const Interval& one) { return one.limited > 0; });
}

}  // namespace tactor
