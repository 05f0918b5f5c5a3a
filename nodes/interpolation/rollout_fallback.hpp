// The forces that are displayed instead of a rollout's.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "framework/core/messages.hpp"
#include "nodes/interpolation/force_state.hpp"
#include "nodes/physics/mechanics/local_rollout.hpp"

namespace tactor {

/// Keeps the last trusted force of a rollout, and makes of it, of results and of forecasts what can be displayed.
/// Forces are within the device's limits.
class RolloutFallback {
 public:
  explicit RolloutFallback(bool torque) : torque_(torque) {}

  /// Keeps the force of a physics result, N and N m.
  void take_result(const LocalModel& result);
  /// Holds the coupling's wrench of where the rollout begins.
  void begin(const LocalRollout& rollout);
  /// Keeps `shown`, the force of a rollout that is trusted, with the handle at `X_WD`.
  void keep(const ForceState& shown, const Pose& X_WD, const LocalRollout& rollout);

  /// How the kept force changes with the handle's place, in m and rad.
  void set_jacobian(const Eigen::Matrix<double, 6, 6>& jacobian) { jacobian_ = jacobian; }
  /// The kept force and its change by the Jacobian to where the handle is now, as long as it does not pull. Held later.
  ForceState by_jacobian(const DeviceState& handle, const CouplingParameters& coupling);
  /// m, of the handle from where the force was kept.
  [[nodiscard]] double distance(const DeviceState& handle) const { return norm(handle.X_WD.p - kept_X_WD_.p); }

  [[nodiscard]] ForceState of_forecast(const Stamped<Forecast>& forecast, Time now,
                                       const CouplingParameters& coupling) const;
  /// True once for each forecast.
  bool is_new(const Stamped<Forecast>& forecast);

  /// The force of the newest model, or the last one displayed while it was trusted.
  [[nodiscard]] const Wrench& held() const { return held_; }
  [[nodiscard]] const Wrench& held_result() const { return held_result_; }
  /// The tool touched something when a force was kept last.
  [[nodiscard]] bool touching() const { return touching_; }

 private:
  bool torque_;
  Wrench held_result_;  // of physics' newest result
  Wrench held_;
  ForceState kept_;
  Pose kept_X_WD_;
  bool touching_ = false;
  Eigen::Matrix<double, 6, 6> jacobian_ = Eigen::Matrix<double, 6, 6>::Zero();
  std::uint64_t forecast_shown_ = ~std::uint64_t{0};  // its sequence number
};

}  // namespace tactor
