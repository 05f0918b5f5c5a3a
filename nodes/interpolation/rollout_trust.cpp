#include "nodes/interpolation/rollout_trust.hpp"

#include <algorithm>
#include <span>

#include "framework/core/between_samples.hpp"

namespace tactor {

namespace {

/// N, differences from physics that count as none.
constexpr double estimate_noise = 0.01;

/// Samples farther apart than this tell nothing of the time between them.
constexpr Duration longest_gap{20'000'000};

}  // namespace

RolloutTrust::RolloutTrust(const TrustOptions& options)
    : options_(options),
      time_(options.trust_time),
      estimate_({.memory = options.estimate_time, .worse = options.worse, .noise = estimate_noise, .results = 8}) {}

void RolloutTrust::note(Time time, const Vec3& p_WT, const Forces& forces) {
  past_[noted_++ % past_.size()] = {time, p_WT, forces};
}

void RolloutTrust::learn(const Stamped<LocalModel>& result, Duration interval) {
  const LocalModel& model = result.value;
  const std::optional<double> law = model.law_unknown != 0 ? std::nullopt : std::optional(model.law_error);
  learn(result.stamp.valid, model.wrench_result.force, law, interval);
}

void RolloutTrust::learn(Time valid, const Vec3& force, std::optional<double> law_error, Duration interval) {
  note_interval(interval);
  const std::optional<PastState> then = known_at(valid);
  if (!then) return;
  estimate_.take(valid, force, then->forces, law_error);
}

bool RolloutTrust::disagrees(Time valid, const Vec3& p_WT_result) {
  const std::optional<PastState> then = known_at(valid);
  if (!then) return false;
  const Vec3 apart = p_WT_result - then->p_WT;
  if (!(norm(apart) < options_.trust_distance)) {
    ++disagreements_;
    return true;
  }
  const bool beyond = norm(apart) > options_.disagreement;
  if (!beyond || !apart_now_ || dot(apart, apart_) < 0.5 * dot(apart_, apart_)) {
    apart_now_ = beyond;
    apart_ = apart;
    apart_since_ = valid;
    return false;
  }
  if (valid - apart_since_ < options_.patience) return false;
  ++disagreements_;
  return true;
}

/// Where the rollout was at that time, be it between two samples; none where it was not there yet or any more.
std::optional<RolloutTrust::PastState> RolloutTrust::known_at(Time time) const {
  const std::span noted = std::span(past_).first(std::min(noted_, past_.size()));
  const PastState *before = nullptr, *after = nullptr;
  for (const PastState& s : noted) {
    if (s.time == time) return s;
    if (s.time < time && (before == nullptr || s.time > before->time)) before = &s;
    if (s.time > time && (after == nullptr || s.time < after->time)) after = &s;
  }
  if (before == nullptr || after == nullptr || after->time - before->time > longest_gap) return std::nullopt;
  const double share = share_between(before->time, after->time, time);
  PastState then{time, between(before->p_WT, after->p_WT, share), {}};
  for (std::size_t i = 0; i < then.forces.size(); ++i) {
    then.forces[i] = between(before->forces[i], after->forces[i], share);
  }
  return then;
}

void RolloutTrust::note_interval(Duration interval) {
  // An interval beyond trust_time_max is a failure, and not slow physics.
  if (!(interval < options_.trust_time_max)) return;
  intervals_[interval_count_++ % intervals_.size()] = interval;
  const Duration longest = *std::max_element(intervals_.begin(), intervals_.end());
  time_ = std::max(options_.trust_time, std::min(Duration{3 * longest.ns}, options_.trust_time_max));
}

}  // namespace tactor
