#include "nodes/interpolation/rollout_trust.hpp"

#include <algorithm>
#include <span>

namespace tactor {

namespace {

/// N, differences from physics that count as none.
constexpr double estimate_noise = 0.01;

}  // namespace

RolloutTrust::RolloutTrust(const TrustOptions& options)
    : options_(options),
      time_(options.trust_time),
      estimate_({.memory = options.estimate_time, .worse = options.worse, .noise = estimate_noise, .results = 8}) {}

void RolloutTrust::note(Time time, const Vec3& p_WT, const Forces& forces) {
  past_[noted_++ % past_.size()] = {time, p_WT, forces};
}

void RolloutTrust::learn(const Stamped<LocalModel>& result, Duration interval) {
  note_interval(interval);
  const PastState* then = known_at(result.stamp.valid);
  if (then == nullptr) return;
  estimate_.take(result.stamp.valid, result.value.wrench_result.force, then->forces, result.value.law_error);
}

bool RolloutTrust::disagrees(const Stamped<LocalModel>& result) {
  const PastState* then = known_at(result.stamp.valid);
  if (then == nullptr) return false;
  const Vec3 apart = result.value.p_WT_result - then->p_WT;
  if (!(norm(apart) < options_.trust_distance)) {
    ++disagreements_;
    return true;
  }
  const bool beyond = norm(apart) > options_.disagreement;
  if (!beyond || !apart_now_ || dot(apart, apart_) < 0.5 * dot(apart_, apart_)) {
    apart_now_ = beyond;
    apart_ = apart;
    apart_since_ = result.stamp.valid;
    return false;
  }
  if (result.stamp.valid - apart_since_ < options_.patience) return false;
  ++disagreements_;
  return true;
}

/// Where the rollout was at a sample; null where it was not there or it is too long ago.
const RolloutTrust::PastState* RolloutTrust::known_at(Time time) const {
  const std::span noted = std::span(past_).first(std::min(noted_, past_.size()));
  const auto then = std::find_if(noted.begin(), noted.end(), [&](const PastState& s) { return s.time == time; });
  return then == noted.end() ? nullptr : &*then;
}

void RolloutTrust::note_interval(Duration interval) {
  // An interval beyond trust_time_max is a failure, and not slow physics.
  if (!(interval < options_.trust_time_max)) return;
  intervals_[interval_count_++ % intervals_.size()] = interval;
  const Duration longest = *std::max_element(intervals_.begin(), intervals_.end());
  time_ = std::max(options_.trust_time, std::min(Duration{3 * longest.ns}, options_.trust_time_max));
}

}  // namespace tactor
