#include "framework/core/stability.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

/// The sequence less the line that fits it best by least squares.
std::vector<double> without_line(const std::vector<double>& t, const std::vector<double>& x) {
  const auto n = static_cast<double>(t.size());
  double mean_t = 0, mean_x = 0;
  for (std::size_t i = 0; i < t.size(); ++i) mean_t += t[i] / n, mean_x += x[i] / n;
  double tt = 0, tx = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    tt += (t[i] - mean_t) * (t[i] - mean_t);
    tx += (t[i] - mean_t) * (x[i] - mean_x);
  }
  const double slope = tt > 0 ? tx / tt : 0;
  std::vector<double> rest(t.size());
  for (std::size_t i = 0; i < t.size(); ++i) rest[i] = x[i] - mean_x - slope * (t[i] - mean_t);
  return rest;
}

template <class... Values>
std::string format(const char* pattern, Values... values) {
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(), pattern, values...);
  return text.data();
}

}  // namespace

const char* name_of(StabilityVerdict verdict) {
  switch (verdict) {
    case StabilityVerdict::stable:
      return "stable";
    case StabilityVerdict::limit_cycle:
      return "limit_cycle";
    case StabilityVerdict::pushed_through:
      return "pushed_through";
    case StabilityVerdict::energy:
      return "energy";
    case StabilityVerdict::not_finite:
      return "not_finite";
    case StabilityVerdict::refused:
      return "refused";
  }
  return "";
}

void PeakToPeak::see(double x) {
  if (!begun_) low_ = high_ = x;
  begun_ = true;
  low_ = std::min(low_, x);
  high_ = std::max(high_, x);
  rise_ = std::max(rise_, x - low_);
  fall_ = std::max(fall_, high_ - x);
}

double oscillation_frequency(const std::vector<double>& t, const std::vector<double>& x) {
  TACTOR_DEMAND(t.size() == x.size());
  if (t.size() < 3) return 0;
  const std::vector<double> y = without_line(t, x);
  double largest = 0;
  for (const double v : y) largest = std::max(largest, std::abs(v));
  const double beyond = largest / 4;
  // Where the line was crossed last, and whether the side after it has been taken for good.
  double crossed = 0, first = 0, last = 0;
  int count = 0, side = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    if (i > 0 && (y[i] > 0) != (y[i - 1] > 0)) {
      crossed = t[i - 1] + (t[i] - t[i - 1]) * y[i - 1] / (y[i - 1] - y[i]);
    }
    if (std::abs(y[i]) <= beyond) continue;
    const int now = y[i] > 0 ? 1 : -1;
    if (side != 0 && now != side) {
      if (count == 0) first = crossed;
      last = crossed;
      ++count;
    }
    side = now;
  }
  if (count < 3 || !(last > first)) return 0;
  return 0.5 * (count - 1) / (last - first);
}

StabilityJudge::StabilityJudge(StabilityLimits limits, std::vector<StabilityRest> rests)
    : limits_(limits), rests_(std::move(rests)), at_rest_(rests_.size()) {}

void StabilityJudge::add_stored(double energy) {
  extra_ += energy;
  came_in_ += energy;
}

bool StabilityJudge::see(const StabilitySample& sample) {
  const bool was_finite = finite_;
  finite_ = finite_ && sample.finite && is_finite(sample.p_WT) && is_finite(sample.arm) &&
            std::isfinite(sample.stored) && std::isfinite(sample.given) && std::isfinite(sample.released);
  if (was_finite && !finite_) not_finite_at_ = sample.t;
  if (!finite_) return false;
  if (!begun_) {
    begun_ = true;
    start_ = sample.stored + extra_;
  } else {
    given_ += sample.given;
    came_in_ += std::max(0.0, sample.given) + sample.released;
    const double surplus = sample.stored - start_ - given_;
    if (surplus > surplus_) surplus_ = surplus, surplus_at_ = sample.t;
  }
  peak_ = std::max(peak_, sample.stored);
  see_rest(sample);
  return true;
}

void StabilityJudge::see_rest(const StabilitySample& sample) {
  for (std::size_t k = 0; k < rests_.size(); ++k) {
    if (sample.t < rests_[k].begin || sample.t > rests_[k].end + 1e-9) continue;
    AtRest& found = at_rest_[k];
    found.t.push_back(sample.t);
    for (int i = 0; i < 6; ++i) {
      const double x = i < 3 ? sample.p_WT[i] : sample.arm[i - 3];
      found.peak_to_peak[i].see(x);
      found.x[i].push_back(x);
    }
    found.last = sample.p_WT;
  }
}

void StabilityJudge::refuse(std::string why) {
  refusal_ = why.empty() ? "the run ended early" : std::move(why);
}

void StabilityJudge::judge_rests(StabilityFinding& finding, bool& through) const {
  for (std::size_t k = 0; k < rests_.size(); ++k) {
    const AtRest& found = at_rest_[k];
    if (found.t.empty()) continue;
    for (int i = 0; i < 6; ++i) {
      if (found.peak_to_peak[i].size() <= finding.peak_to_peak_m) continue;
      finding.peak_to_peak_m = found.peak_to_peak[i].size();
      finding.frequency_Hz = oscillation_frequency(found.t, found.x[i]);
    }
    const StabilityRest& rest = rests_[k];
    if (!rest.p_WT) continue;
    const Vec3 off = found.last - *rest.p_WT;
    const double error = norm({off.x * rest.known.x, off.y * rest.known.y, off.z * rest.known.z});
    finding.off_m = std::max(finding.off_m.value_or(0), error);
    through = through || error > rest.tolerance;
  }
  finding.amplitude_m = 0.5 * finding.peak_to_peak_m;
}

StabilityFinding StabilityJudge::finish() const {
  StabilityFinding finding;
  finding.peak_energy_J = begun_ ? peak_ : 0;
  finding.generated_J = surplus_;
  finding.generated_share = came_in_ > 0 ? surplus_ / came_in_ : 0;
  bool through = false;
  judge_rests(finding, through);
  if (!refusal_.empty()) {
    finding.verdict = StabilityVerdict::refused;
    finding.reason = refusal_;
  } else if (!finite_) {
    finding.verdict = StabilityVerdict::not_finite;
    finding.reason = format("a signal was not finite at %.6g s", not_finite_at_);
  } else if (surplus_ > limits_.generated_min && surplus_ > limits_.generated_share * came_in_) {
    finding.verdict = StabilityVerdict::energy;
    finding.reason = format("%.3g J came from nowhere by %.6g s, and %.3g J came in", surplus_, surplus_at_, came_in_);
  } else if (through) {
    finding.verdict = StabilityVerdict::pushed_through;
    finding.reason = format("at rest the tool was %.3g m from where forces balance", *finding.off_m);
  } else if (finding.peak_to_peak_m > limits_.peak_to_peak_max) {
    finding.verdict = StabilityVerdict::limit_cycle;
    finding.reason = format("at rest the tool oscillated by %.3g m from peak to peak at %.3g Hz",
                            finding.peak_to_peak_m, finding.frequency_Hz);
  }
  return finding;
}

}  // namespace tactor
