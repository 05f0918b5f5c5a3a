// A predictor: it goes on along the parabola through the last three physics forces.
#include <algorithm>
#include <array>

#include "framework/node/register_nodes.hpp"
#include "nodes/prediction/predictor.hpp"

namespace example_nodes {

class Parabola final : public tactor::Predictor {
 public:
  using Params = tactor::PredictorParams;
  Parabola(const Params& params, const tactor::NodeContext& context) : tactor::Predictor(params, context) {}

  static tactor::NodeInfo declare() {
    tactor::Declare<Parabola> node("example.parabola", "Goes on along the parabola through the last three forces.");
    return tactor::declare_predictor(node).info();
  }

 private:
  void take(const tactor::Stamped<tactor::Wrench>& sample) override {
    last_[2] = last_[1];
    last_[1] = last_[0];
    last_[0] = sample;
    seen_ = std::min(seen_ + 1, 3);
  }

  // Lagrange's polynomial through the samples, by their own times: physics is late and uneven.
  Outcome predict(tactor::Duration horizon, std::span<tactor::Wrench> predicted) override {
    const auto age = [this](int i) { return (last_[i].stamp.valid - last_[0].stamp.valid).seconds(); };
    if (seen_ < 3 || age(1) >= 0 || age(2) >= age(1)) return Outcome::warm_up;
    for (std::size_t step = 0; step < predicted.size(); ++step) {
      const double t = static_cast<double>(step + 1) * horizon.seconds();
      tactor::Wrench sum;
      for (int i = 0; i < 3; ++i) {
        double weight = 1;
        for (int j = 0; j < 3; ++j) {
          if (j != i) weight *= (t - age(j)) / (age(i) - age(j));
        }
        sum = sum + weight * last_[i].value;
      }
      predicted[step] = sum;
    }
    return Outcome::predicted;
  }

  std::array<tactor::Stamped<tactor::Wrench>, 3> last_;  // the newest first
  int seen_ = 0;
};

}  // namespace example_nodes

TACTOR_NODES(registry) {
  registry.add<example_nodes::Parabola>();
}
