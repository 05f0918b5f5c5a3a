// The wrench that acts at a port while the handle goes from one sample to the next.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "framework/core/spatial.hpp"
#include "framework/core/time.hpp"

namespace tactor {

/// Wrenches, each held from its time on until that of the next.
class ActingWrench {
 public:
  /// From `at` on, which is not before the one held last.
  void hold(Time at, const Wrench& wrench) {
    if (count_ == later_.size()) --count_;
    later_[count_++] = {at, wrench};
  }

  /// Over the way between two samples.
  struct Leg {
    Wrench mean;  ///< by time; where one wrench acts all the time it is that one, to the last bit
    /// N s^2 and N m s^2: what acts at most in addition on a way that is not even, per m/s^2 (rad/s^2) of the greatest
    /// acceleration. With both ends of the way given, a place between them is off by at most a t1 t2 / 2, t1 after the
    /// one and t2 before the other; a change of the wrench there counts for that much.
    double uneven_force = 0, uneven_torque = 0;
  };
  /// From the end of the leg before, or from `from`, to `to`.
  [[nodiscard]] Leg leg(Time from, Time to) {
    std::size_t next = 0;
    for (; next < count_ && later_[next].at <= from; ++next) acting_ = later_[next].wrench;
    Leg leg{acting_};
    if (next < count_ && later_[next].at < to) {
      leg.mean = {};
      Time since = from;
      for (; next < count_ && later_[next].at < to; ++next) {
        const auto& [at, wrench] = later_[next];
        leg.mean = leg.mean + share(since, at, from, to) * acting_;
        const Wrench change = wrench - acting_;
        const double off = 0.5 * (at - from).seconds() * (to - at).seconds();
        leg.uneven_force += off * norm(change.force);
        leg.uneven_torque += off * norm(change.torque);
        acting_ = wrench;
        since = at;
      }
      leg.mean = leg.mean + share(since, to, from, to) * acting_;
    }
    std::copy(later_.begin() + static_cast<std::ptrdiff_t>(next), later_.begin() + static_cast<std::ptrdiff_t>(count_),
              later_.begin());
    count_ -= next;
    return leg;
  }

 private:
  struct Held {
    Time at;
    Wrench wrench;
  };
  static double share(Time begin, Time end, Time from, Time to) {
    return (end - begin).seconds() / (to - from).seconds();
  }

  Wrench acting_;
  std::array<Held, 16> later_;  // beyond that the newest takes the place of the one before
  std::size_t count_ = 0;
};

}  // namespace tactor
