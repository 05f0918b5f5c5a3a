// The force that a device displays in the intervals of a trial, beside the force that was wanted.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "framework/core/messages.hpp"
#include "framework/node/port.hpp"

namespace tactor {

/// A force, or a torque at 50 mm, that counts as faded away, N.
inline constexpr double faded_force = 0.1;
/// The force, or what makes the torque at a lever of 50 mm, whichever is larger, N.
double size_of(const Wrench& wrench);

class FeltForce {
 public:
  /// Interval 0 or 1 begins; `connected`: something tells what the device displays.
  void begin(std::size_t interval, bool connected);
  /// Reads both inputs. `interval`: the one that goes on, if any.
  void read(Input<Wrench>& felt, Input<Wrench>& wanted, std::optional<std::size_t> interval);
  /// The newest force, N.
  [[nodiscard]] double newest() const { return newest_; }
  /// The largest force in the interval, N; NaN where nothing tells it.
  [[nodiscard]] double peak(std::size_t interval) const;
  /// The share of ticks at which the device displayed less than was wanted; NaN where none was compared.
  [[nodiscard]] double limited_share(std::size_t interval) const;
  /// True where it did so in one of the two intervals.
  [[nodiscard]] bool is_limited() const;

 private:
  struct Interval {
    double peak = 0;             // N
    int ticks = 0, limited = 0;  // that were compared, and those at which it displayed less than was wanted
    bool connected = false;
  };
  enum class Comparison { none, enough, less };
  [[nodiscard]] Comparison compare(const Stamped<Wrench>& shown, Input<Wrench>& wanted);

  std::array<Interval, 2> intervals_;
  double newest_ = 0;  // N
  std::optional<Stamped<Wrench>> wanted_;
};

}  // namespace tactor
