// A simulated observer of known threshold, which answers in the place of a person.
#pragma once

#include <boost/random/mersenne_twister.hpp>
#include <cstdint>
#include <optional>
#include <vector>

#include "framework/node/info.hpp"
#include "nodes/experiment/messages.hpp"

namespace tactor {

/// How the share of right answers rises with the level x.
enum class PsychometricShape : std::uint8_t {
  logistic,  ///< F(x) = 1 / (1 + exp(-(x - threshold) / spread))
  weibull,   ///< F(x) = 1 - exp(-(x / threshold)^slope)
};

struct Psychometric {
  PsychometricShape shape = PsychometricShape::weibull;
  double threshold = 1;
  double spread = 1;  ///< of the logistic, in the unit of the level
  double slope = 3;   ///< of the Weibull
  double lapse = 0;   ///< the share of answers that have nothing to do with the level, half of them wrong
};

/// P(right | x) of two intervals: 1/2 + (1/2 - lapse / 2) F(x).
double share_right(const Psychometric& observer, double level);
/// The level at which it is p; F must reach it: 1/2 <= p < 1 - lapse / 2.
double level_at(const Psychometric& observer, double p);

/// experiment.observer, see declare().
class Observer final : public Node {
 public:
  struct Params {
    PsychometricShape shape = PsychometricShape::weibull;
    double threshold = 1, spread = 1, slope = 3, lapse = 0;
    std::vector<double> worths;
    Duration response_time;
    double rate = 0;
  };
  Observer(const Params& params, const NodeContext& context);
  static NodeInfo declare();
  void step(StepContext& context) override;

  Input<ExperimentQuestion> question;
  Output<ExperimentAnswer> answer;

 private:
  /// The interval that it chooses.
  [[nodiscard]] int choose(const ExperimentQuestion& asked);

  Params params_;
  Psychometric psychometric_;
  boost::random::mt19937_64 random_;
  std::optional<ExperimentQuestion> asked_;
  bool answered_ = false;
  Time due_;
};

}  // namespace tactor
