#include "framework/realtime/line_energy.hpp"

#include <algorithm>
#include <cmath>

#include "framework/core/check.hpp"
#include "framework/core/energy_ramp.hpp"

namespace tactor {

namespace {

double work(const AxisValues& effort, const AxisValues& way) {
  double sum = 0;
  for (std::size_t a = 0; a < max_axes; ++a) sum += effort[a] * way[a];
  return sum;
}

bool is_finite(const AxisValues& values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

}  // namespace

LineEnergy::LineEnergy(const LineEnergyOptions& options)
    : options_(options),
      // All that are on their way or acted on a way whose end has not come, and some more for cycles that come late.
      given_(16 + static_cast<std::size_t>((options.delay_in + options.delay_out).ns / options.period.ns)),
      energy_(options.start) {
  TACTOR_DEMAND(options.axes >= 1 && options.axes <= max_axes && options.held >= options.period);
}

/// N at the handle, of efforts by their levers: no way of the handle of 1 m takes or gives more J.
double LineEnergy::size_of(const AxisValues& effort) const {
  double sum = 0;
  for (std::size_t a = 0; a < max_axes; ++a) sum += std::pow(effort[a] / options_.lever[a], 2);
  return std::sqrt(sum);
}

/// J, that are kept of what has come.
double LineEnergy::most(const AxisValues& effort) const {
  const double size = size_of(effort);
  return options_.kept + size * size / (2 * options_.stiffness);
}

/// m, that the handle may go beyond the way at its mean velocity, over `lasts` s, `after` s after the newest sample.
/// With |acceleration| <= a the velocity then differs from the mean over the last way by a (after + half of that way's
/// time) at most.
double LineEnergy::farther(double after, double lasts) const {
  return options_.acceleration * lasts * (after + 0.5 * lasts + 0.5 * over_);
}

/// J, that an effort gives at most in that time. A step of an encoder hides as much as its size, in the place and in
/// the mean velocity.
double LineEnergy::expected(const AxisValues& effort, double after, double lasts) const {
  double step = 0;
  for (std::size_t a = 0; a < max_axes; ++a) step = std::max(step, options_.lever[a] * options_.step[a]);
  const double hidden = over_ > 0 ? step * (1 + lasts / over_) : step;
  return lasts * work(effort, velocity_) + size_of(effort) * (hidden + farther(after, lasts));
}

double LineEnergy::share_of(Time from, const AxisValues& wanted) const {
  const double size = size_of(wanted);
  if (!(size > 0)) return 1;
  double energy = energy_ + options_.share * allowed();
  // What is on its way, and what acts now.
  Time end = from;
  for (std::size_t back = 0; back < count_ && end > read_; ++back) {
    const Given& one = given(back);
    const Time begin = std::max(one.from, read_), until = end_of(one, end);
    if (until > begin) energy -= expected(one.effort, (begin - read_).seconds(), (until - begin).seconds());
    end = std::min(end, one.from);
  }
  energy = std::max(0.0, energy);
  const double after = std::max(0.0, (from - read_).seconds()), lasts = options_.held.seconds();
  const double gives = std::max(0.0, expected(wanted, after, lasts));
  const double period = options_.period.seconds();
  const double along = expected(wanted, after, period) / size;
  const double ramp = given_on_ramp(size, period * options_.slew, along, options_.acceleration * period * period);
  return share_within(gives, ramp, energy);
}

void LineEnergy::remember(Time from, const AxisValues& effort) {
  newest_ = (newest_ + 1) % given_.size();
  given_[newest_] = {from, effort};
  count_ = std::min(count_ + 1, given_.size());
}

AxisValues LineEnergy::give(Time now, const AxisValues& wanted, const AxisValues& weight) {
  const Time from = now + options_.delay_out;
  AxisValues counted{};
  const bool acts = wanted != AxisValues{};
  if (acts) {
    for (std::size_t a = 0; a < max_axes; ++a) counted[a] = wanted[a] - weight[a];
    ++wanted_;
  }
  AxisValues given = wanted;
  if (acts && options_.bounds && any_) {
    const double share = share_of(from, counted);
    if (share < 1) {
      ++changed_;
      for (std::size_t a = 0; a < max_axes; ++a) {
        // A weight that the gate has not let through yet is not put to the handle by this either.
        given[a] = std::clamp(share * counted[a] + weight[a], std::min(0.0, wanted[a]), std::max(0.0, wanted[a]));
        counted[a] = given[a] - weight[a];
      }
    }
  }
  remember(from, counted);
  return given;
}

void LineEnergy::let_go(Time at) {
  // What would begin later never does.
  for (std::size_t back = 0; back < count_; ++back) {
    Given& one = given_[place(back)];
    if (one.from < at) break;
    one.effort = {};
  }
  remember(at, {});
}

void LineEnergy::take(Time read, const AxisValues& q) {
  if (!is_finite(q) || (any_ && read <= read_)) return;
  if (!any_) {
    any_ = true;
    read_ = read;
    q_ = q;
    return;
  }
  AxisValues way{};
  for (std::size_t a = 0; a < static_cast<std::size_t>(options_.axes); ++a) way[a] = q[a] - q_[a];
  const double dt = (read - read_).seconds();
  // From the newest effort back to the one that acted when the way began.
  constexpr double long_way = 2.5;  // periods
  const bool cut = options_.lets_go && dt > long_way * options_.period.seconds();
  double gave = 0, more = 0, rounding = 0;
  Time end = read;
  AxisValues after{};
  bool any_after = false;
  for (std::size_t back = 0; back < count_ && end > read_; ++back) {
    const Given& one = given(back);
    if (one.from >= end) continue;
    const Time begin = std::max(one.from, read_), until = end_of(one, end);
    const double lasts = std::max(0.0, (until - begin).seconds());
    if (cut) {
      gave += lasts * work(one.effort, velocity_);
      more += size_of(one.effort) * farther((begin - read_).seconds(), lasts);
    } else {
      gave += lasts / dt * work(one.effort, way);
      if (any_after && after != one.effort) {
        AxisValues change{};
        for (std::size_t a = 0; a < max_axes; ++a) change[a] = after[a] - one.effort[a];
        const double off = 0.5 * (until - read_).seconds() * (read - until).seconds();
        more += options_.acceleration * off * size_of(change);
      }
    }
    after = one.effort;
    any_after = true;
    double size = 0;
    for (std::size_t a = 0; a < max_axes; ++a) size = std::hypot(size, options_.step[a] * one.effort[a]);
    rounding = std::max(rounding, size);
    end = begin;
  }
  counted_ = true;
  net_ -= gave;
  generated_ = std::max(generated_, -net_);
  energy_ = std::min(energy_ - gave - more, most(given(0).effort));
  // A cycle that came late explains no more than one that is foreseen.
  of_cycle_ = std::max(of_cycle_, std::abs(gave) * (cut ? 1 : std::min(1.0, options_.held.seconds() / dt)));
  of_rounding_ = std::max(of_rounding_, rounding);
  for (std::size_t a = 0; a < max_axes; ++a) velocity_[a] = way[a] / dt;
  over_ = dt;
  read_ = read;
  q_ = q;
}

LineTotals LineEnergy::totals() const {
  const auto cycles = static_cast<double>(std::max<std::uint64_t>(1, wanted_));
  return {generated_, allowed(), static_cast<double>(changed_) / cycles, counted_};
}

}  // namespace tactor
