#include "nodes/prediction/linear_position.hpp"

#include <algorithm>

namespace tactor {

NodeInfo LinearPositionPredictor::declare() {
  Declare<LinearPositionPredictor> node("prediction.linear_position", "Extrapolates the force along the device's way.");
  node.details(
      "F = F_n + (F_n - F_m) s with s = (P - P_n) . (P_n - P_m) / |P_n - P_m|^2: the force changes along the "
      "device's way as it did from sample m to sample n, F_n being the newest. P is the device's position at the "
      "forecast's time, or the newest where that is still to come; P_n and P_m are those at the stamps of the "
      "samples. Torque likewise over rotation vectors. m is the sample before n, or an older one where the device "
      "has moved by less than `min_displacement` since; |s| is at most `reach`. So encoder noise is not divided by, "
      "a device at rest is held, and what a contact's beginning suggests ends soon. Unlike `prediction.linear` it "
      "knows the hand's motion after the last physics sample. For a smooth surface and physics faster than the hand "
      "by so much that two samples see the same contact; it does not know the direction that the hand turns to. "
      "`min_displacement` is a few encoder steps (20 to 100 um), `reach` 1 to 3.\n"
      "Sources: Picinbono and Lombardo, Extrapolation: a solution for force feedback? (1999); Picinbono, Lombardo, "
      "Delingette, Ayache, Improving realism of a surgery simulator (2002).");
  declare_device_track(declare_predictor(node))
      .real("min_displacement", &Params::min_displacement,
            {.doc = "the shortest way that a change of force is divided by",
             .unit = "m",
             .default_value = 50e-6,
             .min = 0,
             .max = 0.1,
             .above_min = true})
      .real("min_rotation", &Params::min_rotation,
            {.doc = "the smallest rotation that a change of torque is divided by",
             .unit = "rad",
             .default_value = 1e-3,
             .min = 0,
             .max = 1,
             .above_min = true})
      .real("reach", &Params::reach,
            {.doc = "how many times the way behind it is extrapolated at most",
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
