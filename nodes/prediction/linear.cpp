#include "nodes/prediction/linear.hpp"

#include <algorithm>

namespace tactor {

NodeInfo LinearPredictor::declare() {
  Declare<LinearPredictor> node("prediction.linear", "Extrapolates the last two forces in time.");
  node.details(
      "F_{t+1|t} = F_t + (F_t - F_{t-1}) T / (t_t - t_{t-1}), where t are the stamps of the samples and T is the "
      "estimated physics period. So it takes an uneven period into account. It holds after a sample that is not "
      "finite, and before the second good one.");
  return declare_predictor(node).cheaper("prediction.hold").info();
}

void LinearPredictor::take(const Stamped<Wrench>& sample) {
  const double interval = (sample.stamp.valid - last_.stamp.valid).seconds();
  rate_ = seen_ > 0 && interval > 0 ? (1.0 / interval) * (sample.value - last_.value) : Wrench{};
  last_ = sample;
  seen_ = std::min(seen_ + 1, 2);
}

Predictor::Outcome LinearPredictor::predict(Duration horizon, std::span<Wrench> predicted) {
  if (seen_ < 2) return Outcome::warm_up;
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    predicted[i] = last_.value + (static_cast<double>(i + 1) * horizon.seconds()) * rate_;
  }
  return Outcome::predicted;
}

}  // namespace tactor
