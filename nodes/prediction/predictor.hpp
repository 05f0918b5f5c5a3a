// The base of all force predictors: it takes samples in and sends one forecast per step.
#pragma once

#include <optional>
#include <span>

#include "framework/core/messages.hpp"
#include "framework/core/refusals.hpp"
#include "framework/node/new_messages.hpp"
#include "framework/node/period_parameters.hpp"
#include "nodes/prediction/sample_gate.hpp"

namespace tactor {

/// The parameters of a predictor of the next physics periods.
struct PredictorParams : PeriodOptions, ForceLimits {
  std::int32_t steps = 3;  ///< periods ahead, 1 to Forecast::capacity
};

/// The base of a predictor. It takes all new samples, drops those that are not finite, estimates the period, holds the
/// steps that the derived class does not predict, and limits the forecast to the device's limits. A forecast carries
/// the stamp of the newest usable sample. Before there is one, it forecasts zero with the stamp of the newest message.
class Predictor : public Node, public Refusing {
 public:
  void step(StepContext& context) final;
  [[nodiscard]] const ForecastGuard& guard() const { return guard_; }
  [[nodiscard]] const Refusals& refusals() const final { return guard_.refusals(); }
  [[nodiscard]] std::optional<Time> warm_since() const final { return warm_since_; }

  Input<Wrench> force;
  Output<Forecast> forecast;

 protected:
  enum class Outcome {
    predicted,
    warm_up,  ///< held, because too little has been seen
    held,     ///< held, because nothing better could be computed
  };

  Predictor(const PredictorParams& params, const NodeContext& context)
      : guard_(params, context.torque), period_(params), steps_(params.steps) {}

  /// Called at the start of each step, before the samples: the place to read other inputs.
  virtual void read_inputs() {}
  /// A usable sample, in the order of arrival; its torque is zero in a translation-only scene.
  virtual void take(const Stamped<Wrench>& sample) = 0;
  /// Writes to predicted[i - 1] the force expected i `horizon` after the sample taken last. All entries start as that
  /// sample, so an entry that is not written is held. Returns whether any entry had to be held.
  virtual Outcome predict(Duration horizon, std::span<Wrench> predicted) = 0;

  /// Whether the predictor has seen enough samples to predict as it will from then on. Asked after each sample.
  [[nodiscard]] virtual bool is_warm() const { return true; }

  [[nodiscard]] bool torque() const { return guard_.torque(); }

 private:
  ForecastGuard guard_;
  PeriodEstimate period_;
  std::int32_t steps_;
  std::optional<Time> taken_;  ///< stamp of the newest usable sample
  std::optional<Time> warm_since_;
  NewMessages<Wrench> samples_;
};

/// Adds the input `force`, the output `forecast`, the device's limits, the period estimate and the guard's metrics.
template <class N>
Declare<N>& declare_predictor(Declare<N>& node) {
  using P = typename N::Params;
  ForecastGuard::declare(node);
  // A pointer to a member of the base does not deduce as one of N.
  node.role(Role::prediction)
      .realtime_safe()
      .input(
          "force", static_cast<Input<Wrench> N::*>(&N::force),
          {.doc = "the physics force on the device", .trigger = Trigger::yes, .queue = {QueuePolicy::drop_oldest, 64}})
      .output("forecast", static_cast<Output<Forecast> N::*>(&N::forecast),
              "the physics force and the forces expected at the next physics periods")
      .integer("steps", static_cast<std::int32_t P::*>(&P::steps),
               {.doc = "number of physics periods that are predicted. A force is displayed from one period after its "
                       "stamp to two, or longer if the next force is late",
                .default_value = 3,
                .min = 1,
                .max = Forecast::capacity})
      .real("force_max", static_cast<double P::*>(&P::force_max),
            {.doc = "the device's largest force; longer current and predicted forces are shortened to it",
             .unit = "N",
             .default_value = 8.0,
             .min = 0,
             .above_min = true})
      .real("torque_max", static_cast<double P::*>(&P::torque_max),
            {.doc = "the device's largest torque; longer current and predicted torques are shortened to it",
             .unit = "N m",
             .default_value = 0.3,
             .min = 0,
             .above_min = true});
  return declare_period(node);
}

}  // namespace tactor
