#include "nodes/prediction/kalman.hpp"

#include <algorithm>

namespace tactor {

NodeInfo KalmanPredictor::declare() {
  Declare<KalmanPredictor> node("prediction.kalman", "Filters the force and its rate, and extrapolates them.");
  node.details(
      "F_{t+1|t} = F + T F', or F + T F' + T^2/2 F'' with `model: constant_acceleration`; T is the estimated period. F "
      "and its derivatives come from a Kalman filter whose highest derivative is driven by white noise. The covariance "
      "of that noise is exact for every interval between stamps, the gain is the same for the three axes, and the "
      "covariance is updated in Joseph form. `force_noise` is the standard deviation of a sample (0.001 to 0.02 N). "
      "`force_departure` tells how far the force leaves its trend within 10 ms, as a standard deviation (0.01 to 0.2 "
      "N). A high departure follows fast and is rough; a low one is smooth and late. With departure far above noise, "
      "the result is that of `prediction.linear`. A sample beyond `gate` standard deviations, such as contact that "
      "begins or ends, restarts the filter and is counted. Use it with uneven physics and noisy forces. The current "
      "force that is sent stays the sample itself.\nSource: Bar-Shalom, Li, Kirubarajan, Estimation with Applications "
      "to Tracking and Navigation (2001), 6.2.");
  declare_predictor(node)
      .metric("prediction.restarts", "1", "times that a sample beyond `gate` started the filter anew", Better::neither,
              [](const KalmanPredictor& self) { return self.force_.restarts() + self.torque_.restarts(); })
      .choice(
          "model", &Params::model,
          {{"constant_velocity", Trend::constant_velocity}, {"constant_acceleration", Trend::constant_acceleration}},
          std::optional(Trend::constant_velocity),
          "the derivative of the force that stays constant apart from noise: first or second")
      .real("force_noise", &Params::force_noise,
            {.doc = "standard deviation of a sample about the force, per axis",
             .unit = "N",
             .default_value = 0.02,
             .min = 1e-9,
             .max = 1e9})
      .real("force_departure", &Params::force_departure,
            {.doc = "how far the force leaves its trend within 10 ms, as a standard deviation per axis",
             .unit = "N",
             .default_value = 0.04,
             .min = 1e-9,
             .max = 1e9})
      .real("torque_noise", &Params::torque_noise,
            {.doc = "standard deviation of a sample about the torque, per axis",
             .unit = "N m",
             .default_value = 0.0005,
             .min = 1e-9,
             .max = 1e9})
      .real("torque_departure", &Params::torque_departure,
            {.doc = "how far the torque leaves its trend within 10 ms, as a standard deviation per axis",
             .unit = "N m",
             .default_value = 0.001,
             .min = 1e-9,
             .max = 1e9})
      .real("gate", &Params::gate,
            {.doc = "number of standard deviations from the expected value beyond which a sample restarts the filter",
             .default_value = 10,
             .min = 1,
             .max = 1e6});
  return node.cheaper("prediction.linear").cheaper("prediction.hold").info();
}

KalmanPredictor::KalmanPredictor(const Params& params, const NodeContext& context)
    : Predictor(params, context),
      force_(params.model, params.force_departure, params.force_noise, params.gate),
      torque_(params.model, params.torque_departure, params.torque_noise, params.gate) {}

void KalmanPredictor::take(const Stamped<Wrench>& sample) {
  const double interval = std::max(0.0, (sample.stamp.valid - last_).seconds());
  last_ = std::max(last_, sample.stamp.valid);
  force_.take(interval, sample.value.force);
  if (torque()) torque_.take(interval, sample.value.torque);
  ++seen_;
}

Predictor::Outcome KalmanPredictor::predict(Duration horizon, std::span<Wrench> predicted) {
  if (seen_ < 2) return Outcome::warm_up;
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    const double ahead = static_cast<double>(i + 1) * horizon.seconds();
    predicted[i].force = force_.ahead(ahead);
    if (torque()) predicted[i].torque = torque_.ahead(ahead);
  }
  return Outcome::predicted;
}

}  // namespace tactor
