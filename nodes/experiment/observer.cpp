#include "nodes/experiment/observer.hpp"

#include <algorithm>
#include <boost/random/exponential_distribution.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <cmath>

#include "framework/core/check.hpp"
#include "framework/node/declare.hpp"

namespace tactor {

double share_right(const Psychometric& observer, double level) {
  const double F = observer.shape == PsychometricShape::logistic
                       ? 1 / (1 + std::exp(-(level - observer.threshold) / observer.spread))
                       : 1 - std::exp(-std::pow(std::max(0.0, level) / observer.threshold, observer.slope));
  return 0.5 + 0.5 * (1 - observer.lapse) * F;
}

double level_at(const Psychometric& observer, double p) {
  const double F = (p - 0.5) / (0.5 * (1 - observer.lapse));
  if (observer.shape == PsychometricShape::logistic) {
    return observer.threshold + observer.spread * std::log(F / (1 - F));
  }
  return observer.threshold * std::pow(-std::log(1 - F), 1 / observer.slope);
}

NodeInfo Observer::declare() {
  return Declare<Observer>("experiment.observer", "Answers in the place of a person, by a psychometric function.")
      .details(
          "Use it to try out an experiment before a person takes part. Of two intervals it finds the comparison with "
          "the probability 1/2 + 1/2 (1 - lapse) F(level), where F is logistic or Weibull. Of a pair it prefers the "
          "condition i to j with the probability w_i / (w_i + w_j), where w are its `worths`. It feels nothing: the "
          "protocol tells it the level.")
      .input("question", &Observer::question, {.doc = "the question of the protocol"})
      .output("answer", &Observer::answer, "the interval that it chooses")
      .choice("shape", &Params::shape,
              {{"weibull", PsychometricShape::weibull}, {"logistic", PsychometricShape::logistic}},
              std::optional(PsychometricShape::weibull),
              "F: 1 - exp(-(x / threshold)^slope), or 1 / (1 + exp(-(x - threshold) / spread))")
      .real("threshold", &Params::threshold,
            {.doc = "threshold of F, in the unit of the level", .default_value = 1, .min = 0, .above_min = true})
      .real("spread", &Params::spread,
            {.doc = "spread of the logistic function, in the unit of the level",
             .default_value = 1,
             .min = 0,
             .above_min = true})
      .real("slope", &Params::slope,
            {.doc = "slope of the Weibull function", .default_value = 3, .min = 0, .above_min = true})
      .real("lapse", &Params::lapse,
            {.doc = "share of answers given regardless of what was felt; half of them are wrong",
             .default_value = 0,
             .min = 0,
             .max = 0.5})
      .reals("worths", &Params::worths, 0, std::vector<double>{},
             {.doc = "worths of the conditions, in the order of the protocol; empty: all equal",
              .min = 0,
              .above_min = true})
      .real("response_time", &Params::response_time,
            {.doc = "mean time to an answer, half of it fixed and half exponential",
             .unit = "s",
             .default_value = 0.4,
             .min = 0.02,
             .max = 60})
      .rate("rate", &Params::rate, {.doc = "how often it looks for a question, per second", .default_value = 100})
      .role(Role::other)
      .info();
}

Observer::Observer(const Params& params, const NodeContext& context)
    : params_(params),
      psychometric_{params.shape, params.threshold, params.spread, params.slope, params.lapse},
      random_(context.seed) {}

int Observer::choose(const ExperimentQuestion& asked) {
  double p = share_right(psychometric_, asked.level);
  if (asked.condition != asked.other) {
    const auto worth = [this](std::int32_t condition) {
      if (params_.worths.empty()) return 1.0;
      const auto i = static_cast<std::size_t>(condition);
      if (i < params_.worths.size()) return params_.worths[i];
      throw InputError("worths: expected one for each condition, found " + std::to_string(params_.worths.size()));
    };
    p = worth(asked.condition) / (worth(asked.condition) + worth(asked.other));
  }
  boost::random::uniform_real_distribution<double> chance(0, 1);
  const bool comparison = chance(random_) < p;
  return comparison ? asked.comparison : 1 - asked.comparison;
}

void Observer::step(StepContext& context) {
  const auto* newest = question.latest();
  if (newest != nullptr && (!asked_ || newest->value.number != asked_->number)) {
    asked_ = newest->value;
    boost::random::exponential_distribution<double> rest(2 / params_.response_time.seconds());
    due_ = context.now() + Duration::from_seconds(0.5 * params_.response_time.seconds() + rest(random_));
    answered_ = false;
  }
  if (!asked_ || answered_ || context.now() < due_) return;
  answered_ = true;
  answer.send(context.now(), {asked_->number, asked_->begins != 0 ? 0 : choose(*asked_)});
}

}  // namespace tactor
