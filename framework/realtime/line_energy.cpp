#include "framework/realtime/line_energy.hpp"

#include <algorithm>
#include <cmath>

#include "framework/core/check.hpp"
#include "framework/math/energy_ramp.hpp"

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

LineEnergy::LineEnergy(const LineEnergyOptions& options) : options_(options), energy_(options.start) {
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

/// J, that an effort gives at most over `lasts` s, `after` s after the newest sample. With |acceleration| <= a the
/// velocity then differs from the mean over the last way by a (after + half of that way's time) at most. A step of an
/// encoder hides as much as its size.
double LineEnergy::expected(const AxisValues& effort, double after, double lasts) const {
  double hidden = 0;
  for (std::size_t a = 0; a < max_axes; ++a) hidden = std::max(hidden, options_.lever[a] * options_.step[a]);
  const double farther = hidden + options_.acceleration * lasts * (after + 0.5 * lasts + 0.5 * over_);
  return lasts * work(effort, velocity_) + size_of(effort) * farther;
}

double LineEnergy::share_of(Time from, const AxisValues& wanted) const {
  const double size = size_of(wanted);
  if (!(size > 0)) return 1;
  double energy = std::max(0.0, energy_) + options_.share * allowed();
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
  newest_ = (newest_ + 1) % most_given;
  given_[newest_] = {from, effort};
  count_ = std::min(count_ + 1, most_given);
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
        counted[a] *= share;
        given[a] = counted[a] + weight[a];
      }
    }
  }
  remember(from, counted);
  return given;
}

void LineEnergy::let_go(Time at) {
  // What would begin later never does.
  for (std::size_t back = 0; back < count_; ++back) {
    Given& one = given_[(newest_ + most_given - back) % most_given];
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
  double gave = 0, uneven = 0, largest = 0;
  Time end = read;
  AxisValues after{};
  bool any_after = false;
  for (std::size_t back = 0; back < count_ && end > read_; ++back) {
    const Given& one = given(back);
    if (one.from >= end) continue;
    const auto piece = [&](Time begin, Time until, const AxisValues& effort) {
      gave += (until - begin).seconds() / dt * work(effort, way);
      if (any_after && after != effort) {
        AxisValues change{};
        for (std::size_t a = 0; a < max_axes; ++a) change[a] = after[a] - effort[a];
        uneven += 0.5 * size_of(change) * (until - read_).seconds() * (read - until).seconds();
      }
      after = effort;
      any_after = true;
    };
    const Time begin = std::max(one.from, read_), until = end_of(one, end);
    if (until < end) piece(std::max(until, read_), end, {});
    if (until > begin) piece(begin, until, one.effort);
    double rounding = 0;
    for (std::size_t a = 0; a < max_axes; ++a) rounding += std::pow(options_.step[a] * one.effort[a], 2);
    largest = std::max(largest, std::sqrt(rounding));
    end = begin;
  }
  const AxisValues& newest = given(0).effort;
  net_ -= gave;
  generated_ = std::max(generated_, -net_);
  energy_ = std::min(energy_ - gave - options_.acceleration * uneven, most(count_ > 0 ? newest : AxisValues{}));
  of_cycle_ = std::max(of_cycle_, std::abs(gave));
  of_rounding_ = std::max(of_rounding_, largest);
  for (std::size_t a = 0; a < max_axes; ++a) velocity_[a] = way[a] / dt;
  over_ = dt;
  read_ = read;
  q_ = q;
}

LineTotals LineEnergy::totals() const {
  return {generated_, allowed(),
          static_cast<double>(changed_) / static_cast<double>(std::max<std::uint64_t>(1, wanted_))};
}

}  // namespace tactor
