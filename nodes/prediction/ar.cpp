#include "nodes/prediction/ar.hpp"

#include <algorithm>
#include <string>

namespace tactor {

namespace {

// Where extrapolation along a line errs as much as a hold, successive differences correlate by 1/2, and 1/2 is then
// the best single coefficient: half-way between the two (a trend damped by 1/2). Written over the samples themselves,
// the same prediction has the coefficients 3/2 and -1/2, whose sum of 1 makes a mean drop out as well.
std::vector<double> default_coefficients(Removal removal) {
  return removal == Removal::difference ? std::vector<double>{0.5} : std::vector<double>{1.5, -0.5};
}

std::int32_t fill(std::array<double, ArCoefficients::max_order>& phi, const std::vector<double>& given, Removal removal,
                  const char* name) {
  const std::vector<double> values = given.empty() ? default_coefficients(removal) : given;
  if (values.size() > phi.size()) {
    throw InputError(std::string(name) + ": expected at most " + std::to_string(phi.size()) + " coefficients, found " +
                     std::to_string(values.size()) + "; give fewer");
  }
  std::copy(values.begin(), values.end(), phi.begin());
  return static_cast<std::int32_t>(values.size());
}

std::size_t history_size(std::int32_t mean_window) {
  return static_cast<std::size_t>(std::max(mean_window, ArCoefficients::max_order + 1));
}

}  // namespace

NodeInfo ArPredictor::declare() {
  Declare<ArPredictor> node("prediction.ar", "Weighs the last forces by auto-regressive coefficients.");
  node.details(
      "F_{t+1|t} = sum_i phi_i F_{t-i+1}; torque likewise with coefficients of its own. With `remove: mean` the sum is "
      "over F - m, m the mean of the last window, and m is added back; with `remove: difference` it is over "
      "F_t - F_{t-1} and F_t is added. Coefficients that a refitter sends say how they were fitted and are applied so; "
      "until the first arrive, the fixed ones serve. It holds where the history is shorter than the order, where the "
      "refitter found nothing to fit, and where a result is not finite; a result beyond the device's limits is "
      "shortened to them.\n"
      "Source: Hou and Sourina, Real-time Adaptive Prediction Method for Smooth Haptic Rendering, eq. 4.");
  declare_predictor(node)
      .input("coefficients", &ArPredictor::coefficients, {.doc = "refitted coefficients", .required = false})
      .ignored_when([](const Params& p) {
        return p.coefficients == Source::fixed ? std::string("the coefficients are fixed") : std::string();
      })
      .choice("coefficients", &Params::coefficients, {{"fixed", Source::fixed}, {"refit", Source::refit}},
              std::optional(Source::refit), "whether those that arrive replace the fixed ones")
      .reals("force_coefficients", &Params::force_coefficients, 0, std::vector<double>{},
             {.doc = "fixed phi_1, phi_2, ... for force; none given: a trend damped by 1/2"})
      .reals("torque_coefficients", &Params::torque_coefficients, 0, std::vector<double>{},
             {.doc = "fixed phi_1, phi_2, ... for torque; none given: a trend damped by 1/2"})
      .choice("remove", &Params::remove,
              {{"none", Removal::none}, {"mean", Removal::mean}, {"difference", Removal::difference}},
              std::optional(Removal::difference),
              "what the fixed coefficients leave out of the samples before they weigh them")
      .integer("mean_window", &Params::mean_window,
               {.doc = "samples kept for the mean; no fewer than the refitter's window",
                .default_value = 300,
                .min = 1,
                .max = 100000});
  return node.info();
}

ArPredictor::ArPredictor(const Params& params, const NodeContext& context)
    : params_(params),
      guard_(params, context.torque),
      period_(params),
      force_history_(history_size(params.mean_window)),
      torque_history_(history_size(params.mean_window)) {
  model_.removal = params.remove;
  model_.window = params.mean_window;
  model_.force_order = fill(model_.force, params.force_coefficients, params.remove, "force_coefficients");
  model_.torque_order = fill(model_.torque, params.torque_coefficients, params.remove, "torque_coefficients");
}

ArPredictor::Outcome ArPredictor::predict(const SampleWindow& history, std::span<const double> phi,
                                          Vec3& predicted) const {
  if (phi.empty()) return Outcome::nothing_fitted;
  const bool difference = model_.removal == Removal::difference;
  if (history.size() < phi.size() + (difference ? 1 : 0)) return Outcome::warm_up;
  const Vec3 mean =
      model_.removal == Removal::mean ? history.mean(static_cast<std::size_t>(std::max(model_.window, 1))) : Vec3{};
  predicted = difference ? history[0] : mean;
  for (std::size_t i = 0; i < phi.size(); ++i) {
    predicted += phi[i] * (history[i] - (difference ? history[i + 1] : mean));
  }
  return Outcome::predicted;
}

void ArPredictor::step(StepContext&) {
  if (params_.coefficients == Source::refit) {
    if (const Stamped<ArCoefficients>* newest = coefficients.latest()) model_ = newest->value;
  }
  Stamped<Wrench> sample;
  bool any = false;
  bool usable = false;
  while (samples_.next(force, sample)) {
    any = true;
    usable = guard_.accept(sample.value);
    period_.update(sample.stamp.valid);
    if (!usable) continue;
    force_history_.push(sample.value.force);
    if (guard_.torque()) torque_history_.push(sample.value.torque);
  }
  if (!any) return;
  Forecast f{sample.value, sample.value, period_.value().seconds()};
  bool held = !usable;
  if (usable) {
    const std::span<const double> force_phi(model_.force.data(), static_cast<std::size_t>(model_.force_order));
    const std::span<const double> torque_phi(model_.torque.data(), static_cast<std::size_t>(model_.torque_order));
    const Outcome force_outcome = predict(force_history_, force_phi, f.predicted_D_W.force);
    const Outcome torque_outcome =
        guard_.torque() ? predict(torque_history_, torque_phi, f.predicted_D_W.torque) : Outcome::predicted;
    if (force_outcome == Outcome::warm_up || torque_outcome == Outcome::warm_up) {
      guard_.count_warm_up();
      held = true;
    } else if (force_outcome == Outcome::nothing_fitted || torque_outcome == Outcome::nothing_fitted) {
      guard_.count_held();
      held = true;
    }
  }
  const bool mended = guard_.mend(f.current_D_W, f.predicted_D_W);
  f.fallback = held || mended ? 1 : 0;
  forecast.send(sample.stamp.valid, f);
}

}  // namespace tactor
