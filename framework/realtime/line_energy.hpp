// The energy that the motors of a device give, counted on its line by axis, and a bound on it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "framework/core/time.hpp"
#include "framework/realtime/axis_values.hpp"

namespace tactor {

/// What was counted on a line.
struct LineTotals {
  double generated_J = 0;    ///< the most that the motors had given, net, at any time
  double allowed_J = 0;      ///< the strict bound: max |F| D + max |F . dx| over the cycles
  double changed_share = 0;  ///< of the cycles with an effort, those in which the bound changed it
  bool counted = false;      ///< a way of the handle was
};

/// How a LineEnergy counts.
struct LineEnergyOptions {
  int axes = 3;
  AxisValues lever = every_axis(1);  ///< m that the handle goes for a m or rad of the axis, at least; above 0
  AxisValues step{};                 ///< m or rad, of the encoders
  Duration period{1'000'000};        ///< of the cycles
  Duration delay_in;                 ///< from reading the encoders to `take`, at most
  Duration delay_out;                ///< from giving an effort to its acting
  Duration held{2'000'000};          ///< so long an effort is foreseen to act at most; at least a period
  bool lets_go = false;              ///< the motors do let go of it then
  double acceleration = 60;          ///< m/s^2, the greatest of the handle
  double slew = 2000;                ///< N/s, by which a force may have to come down
  double start = 2e-5;               ///< J, that may be given before any has come
  double kept = 0.02;                ///< J, of what has come, that are kept at any force
  double stiffness = 50;             ///< N/m, of the softest spring that is displayed
  double share = 0.5;                ///< of the strict bound: so much may be given before it has come
  bool bounds = false;               ///< false: it counts alone
};

/// E -= effort . dq: over each way from one sample of the encoders to the next, the effort that was in force meanwhile.
/// The line gave them, and is told their delay. Where several were in force, the way is shared by time, and what an
/// uneven way could have given in addition, at the greatest acceleration, is taken off. Where the motors have let go on
/// the way, the part before that is taken from the velocity that the handle had.
///
/// The bound is that of passivity.energy_bound: an effort is scaled down until it gives no more than is there, over the
/// longest time for which it may be held, and on its way down to zero at the slew limit, whatever a handle within that
/// acceleration does, after all efforts that are still on their way. Of what has come no more is kept than `kept` and
/// what the softest spring holds at the effort; the verdict is of the whole net energy.
///
/// The tool's weight gives back what lifting it took, so its part of the efforts is not counted. One thread; nothing in
/// it allocates or waits.
class LineEnergy {
 public:
  explicit LineEnergy(const LineEnergyOptions& options);

  /// The efforts that are given now: `wanted`, or less where the bound says so, on no axis more or the other way.
  /// `weight` is the part of `wanted` that displays the tool's weight; it is not scaled.
  AxisValues give(Time now, const AxisValues& wanted, const AxisValues& weight);
  /// The encoders, as they were at `read`, later than the time before. Other samples are left out.
  void take(Time read, const AxisValues& q);
  /// The motors have let go of everything at that time, of what is on its way too.
  void let_go(Time at);
  /// The line was closed meanwhile: the way to the next sample is not counted.
  void reopen() { any_ = false; }

  [[nodiscard]] LineTotals totals() const;

 private:
  struct Given {
    Time from;
    AxisValues effort{};  // without the weight
  };
  /// J, the strict bound so far.
  [[nodiscard]] double allowed() const { return of_rounding_ + of_cycle_; }
  /// When an effort ends that the next one takes over from at `next`.
  [[nodiscard]] Time end_of(const Given& one, Time next) const {
    return options_.lets_go ? std::min(next, one.from + options_.held) : next;
  }
  void remember(Time from, const AxisValues& effort);
  [[nodiscard]] std::size_t place(std::size_t back) const { return (newest_ + given_.size() - back) % given_.size(); }
  [[nodiscard]] const Given& given(std::size_t back) const { return given_[place(back)]; }
  [[nodiscard]] double share_of(Time from, const AxisValues& wanted) const;
  [[nodiscard]] double size_of(const AxisValues& effort) const;
  [[nodiscard]] double most(const AxisValues& effort) const;
  [[nodiscard]] double farther(double after, double lasts) const;
  [[nodiscard]] double expected(const AxisValues& effort, double after, double lasts) const;

  const LineEnergyOptions options_;
  std::vector<Given> given_;  // a ring; the newest may begin later than the newest sample
  std::size_t newest_ = 0;
  std::size_t count_ = 0;

  bool any_ = false;      // a sample has come, since the line was opened
  bool counted_ = false;  // a way was
  Time read_;
  AxisValues q_{};
  AxisValues velocity_{};  // the mean over the last way
  double over_ = 0;        // s, that way
  double energy_;          // J, capped
  double net_ = 0;         // J, since the start
  double generated_ = 0, of_rounding_ = 0, of_cycle_ = 0;
  std::uint64_t wanted_ = 0, changed_ = 0;
};

}  // namespace tactor
