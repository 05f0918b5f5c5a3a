#include "nodes/interpolation/rollout_fallback.hpp"

#include <utility>

#include "nodes/interpolation/blended_force.hpp"
#include "nodes/interpolation/forecast_curve.hpp"
#include "nodes/physics/mechanics/coupling_wrench.hpp"
#include "nodes/physics/mechanics/eigen.hpp"

namespace tactor {

void RolloutFallback::take_result(const LocalModel& result) {
  held_result_ = limited(result.wrench_result, result.coupling);
}

void RolloutFallback::begin(const LocalRollout& rollout) {
  held_ = coupling_wrench(rollout.model().coupling, rollout.state(), torque_);
}

void RolloutFallback::keep(const ForceState& shown, const Pose& X_WD, const LocalRollout& rollout) {
  kept_ = shown;
  kept_X_WD_ = X_WD;
  begin(rollout);
  touching_ = rollout.state().contacts > 0;
}

ForceState RolloutFallback::by_jacobian(const DeviceState& handle, const CouplingParameters& coupling) {
  const auto change = [this](const Vec3& translation, const Vec3& turn) {
    Eigen::Matrix<double, 6, 1> displacement;
    displacement << eigen(translation), eigen(turn);
    const Eigen::Matrix<double, 6, 1> by = jacobian_ * displacement;
    return Wrench{plain(by.head<3>()), torque_ ? plain(by.tail<3>()) : Vec3{}};
  };
  const Vec3 turn = to_rotation_vector(handle.X_WD.R * inverse(kept_X_WD_.R));
  ForceState state{kept_.value + change(handle.X_WD.p - kept_X_WD_.p, turn), change(handle.V_WD.v, handle.V_WD.w), {}};
  // A contact that is left does not pull.
  const Vec3& before = kept_.value.force;
  const double along = dot(state.value.force, before), square = dot(before, before);
  if (along < 0 && square > 0) {
    state.value.force -= (along / square) * before;
    state.rate.force -= (dot(state.rate.force, before) / square) * before;
  }
  state.value = limited(state.value, coupling);
  held_ = state.value;
  return state;
}

ForceState RolloutFallback::of_forecast(const Stamped<Forecast>& forecast, Time now,
                                        const CouplingParameters& coupling) const {
  ForceState state = ForecastCurve(forecast, CurveShape::linear).at(now);
  state.value = limited(state.value, coupling);
  if (!torque_) state.value.torque = state.rate.torque = {};
  return state;
}

bool RolloutFallback::is_new(const Stamped<Forecast>& forecast) {
  return std::exchange(forecast_shown_, forecast.stamp.sequence) != forecast.stamp.sequence;
}

}  // namespace tactor
