#include "framework/realtime/pose_filter.hpp"

#include <cmath>

namespace tactor {

namespace {

constexpr double longest_gap = 1;  // s

/// Calls `action` with the filter there is.
template <class Variant, class Action>
void with(Variant& filter, const Action& action) {
  if (auto* mixed = std::get_if<MixedFilter>(&filter)) action(*mixed);
  if (auto* chains = std::get_if<MotionFilter>(&filter)) action(*chains);
}

std::variant<std::monostate, MixedFilter, MotionFilter> make(VelocityFilter kind, double departure, double noise,
                                                             double interval) {
  if (kind == VelocityFilter::mixed && interval <= MixedFilter::longest) return MixedFilter(departure, noise, interval);
  return MotionFilter(departure, noise, kind == VelocityFilter::one);
}

}  // namespace

PoseFilter::PoseFilter(const VelocityParams& params, double noise, double noise_angle, double interval, bool rotate)
    : mixed_asked_(params.velocity_filter == VelocityFilter::mixed),
      translation_(make(params.velocity_filter, params.velocity_departure, noise, interval)) {
  if (rotate) rotation_ = make(params.velocity_filter, params.velocity_departure_angle, noise_angle, interval);
}

void PoseFilter::take(const Pose& X_WD, Time now) {
  const Quat& R = X_WD.R;
  // It would never be forgotten again.
  if (!is_finite(X_WD.p) || !std::isfinite(R.w + R.x + R.y + R.z)) return;
  const double interval = (now - last_).seconds();
  if (!started_ || interval > longest_gap) {
    started_ = true;
    last_ = now;
    with(translation_, [&](auto& filter) { filter.start(X_WD.p); });
    with(rotation_, [&](auto& filter) { filter.start({}); });
    R_ = X_WD.R;
    return;
  }
  if (interval <= 0) return;
  last_ = now;
  with(translation_, [&](auto& filter) { filter.take(interval, X_WD.p); });
  ++samples_;
  const auto* mixed = std::get_if<MixedFilter>(&translation_);
  if (mixed != nullptr && mixed->mixes()) ++mixed_;
  with(rotation_, [&](auto& filter) {
    // Values are the turn from R_.
    filter.take(interval, to_rotation_vector(X_WD.R * inverse(R_)));
    R_ = from_rotation_vector(filter.value()) * R_;
    filter.count_from(filter.value());
  });
}

Twist PoseFilter::velocity() const {
  Twist V_WD;
  with(translation_, [&](const auto& filter) { V_WD.v = filter.rate(); });
  with(rotation_, [&](const auto& filter) { V_WD.w = filter.rate(); });
  return V_WD;
}

std::optional<double> PoseFilter::mixed_share() const {
  if (!mixed_asked_ || samples_ == 0) return std::nullopt;
  return static_cast<double>(mixed_) / static_cast<double>(samples_);
}

}  // namespace tactor
