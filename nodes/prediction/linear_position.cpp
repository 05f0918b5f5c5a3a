#include "nodes/prediction/linear_position.hpp"

#include <algorithm>

namespace tactor {

NodeInfo LinearPositionPredictor::declare() {
  Declare<LinearPositionPredictor> node("prediction.linear_position",
                                        "Extrapolates the force along the device's displacement.");
  node.details(
      "F = F_n + (F_n - F_m) s with s = (P - P_n) . (P_n - P_m) / |P_n - P_m|^2. The force changes along the device's "
      "displacement as it did from sample m to the newest sample n. P is the device's position at the forecast's time, "
      "or the newest position if that time is still to come. P_n and P_m are the positions at the stamps of the "
      "samples. Torque is predicted likewise over rotation vectors. m is the sample before n, or an older one if the "
      "device has moved by less than `min_displacement` since. |s| is at most `reach`. So the node never divides by "
      "encoder noise, holds the force of a device at rest, and soon ends the trend of a beginning contact. Unlike "
      "`prediction.linear`, it knows the hand's motion after the last physics sample. Use it for a smooth surface, "
      "with physics so much faster than the hand that two samples see the same contact. It does not know the direction "
      "that the hand turns to. Choose `min_displacement` as a few encoder steps (20 to 100 um), and `reach` from 1 to "
      "3.\nSources: Picinbono and Lombardo, Extrapolation: a solution for force feedback? (1999); Picinbono, Lombardo, "
      "Delingette, Ayache, Improving realism of a surgery simulator (2002).");
  declare_device_track(declare_predictor(node))
      .real("min_displacement", &Params::min_displacement,
            {.doc = "smallest displacement that a change of force is divided by",
             .unit = "m",
             .default_value = 50e-6,
             .min = 0,
             .max = 0.1,
             .above_min = true})
      .real("min_rotation", &Params::min_rotation,
            {.doc = "smallest rotation that a change of torque is divided by",
             .unit = "rad",
             .default_value = 1e-3,
             .min = 0,
             .max = 1,
             .above_min = true})
      .real("reach", &Params::reach,
            {.doc = "longest extrapolation, as a multiple of the displacement from m to n",
             .default_value = 2,
             .min = 0,
             .max = 100});
  return node.cheaper("prediction.linear").cheaper("prediction.hold").info();
}

void LinearPositionPredictor::Secant::take(const Vec3& value, const Vec3& way) {
  if (!based_) {
    base_ = value;
    since_base_ = {};
    based_ = true;
    return;
  }
  since_base_ += way;
  if (norm(since_base_) < shortest_) return;
  rise_ = value - base_;
  run_ = since_base_;
  known_ = true;
  base_ = value;
  since_base_ = {};
}

Vec3 LinearPositionPredictor::Secant::change(const Vec3& way, double reach) const {
  return std::clamp(dot(way, run_) / dot(run_, run_), -reach, reach) * rise_;
}

void LinearPositionPredictor::take(const Stamped<Wrench>& sample) {
  const Pose before = X_WD_;
  newest_ = sample;
  const bool was_placed = placed_;
  placed_ = track_.at(sample.stamp.valid, X_WD_);
  if (!placed_ || !was_placed) {
    force_secant_.forget();
    torque_secant_.forget();
  }
  if (!placed_) return;
  const Wrench way = was_placed ? displacement(before, X_WD_) : Wrench{};
  force_secant_.take(sample.value.force, way.force);
  if (torque()) torque_secant_.take(sample.value.torque, way.torque);
}

Predictor::Outcome LinearPositionPredictor::predict(Duration horizon, std::span<Wrench> predicted) {
  if (!force_secant_.known() && !torque_secant_.known()) return Outcome::warm_up;
  Time t = newest_.stamp.valid;
  for (Wrench& step : predicted) {
    t = t + horizon;
    Pose ahead;
    if (!track_.at(t, ahead)) return Outcome::held;
    const Wrench way = displacement(X_WD_, ahead);
    if (force_secant_.known()) step.force += force_secant_.change(way.force, reach_);
    if (torque_secant_.known()) step.torque += torque_secant_.change(way.torque, reach_);
  }
  return Outcome::predicted;
}

}  // namespace tactor
