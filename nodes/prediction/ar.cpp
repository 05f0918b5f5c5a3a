#include "nodes/prediction/ar.hpp"

#include "framework/core/value_error.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace tactor {

namespace {

// Where extrapolation along a line errs as much as a hold, successive differences correlate by 1/2, and 1/2 is then
// the best single coefficient: half-way between the two (a trend damped by 1/2). Written over the samples themselves,
// the same prediction has the coefficients 3/2 and -1/2, whose sum of 1 makes a mean drop out as well.
std::vector<double> default_coefficients(Detrend detrend) {
  return detrend == Detrend::difference ? std::vector<double>{0.5} : std::vector<double>{1.5, -0.5};
}

std::int32_t fill(std::array<double, ArCoefficients::capacity>& phi, const std::vector<double>& given, Detrend detrend,
                  const char* name) {
  const std::vector<double> values = given.empty() ? default_coefficients(detrend) : given;
  if (values.size() > ArCoefficients::max_order) {
    throw ValueError(name, std::string(name) + ": expected at most " + std::to_string(ArCoefficients::max_order) +
                               " coefficients, found " + std::to_string(values.size()) + "; give fewer");
  }
  std::copy(values.begin(), values.end(), phi.begin());
  return static_cast<std::int32_t>(values.size());
}

std::size_t history_size(std::int32_t mean_window) {
  return static_cast<std::size_t>(std::max(mean_window, ArCoefficients::max_order + 1));
}

// Phi_i x.
Vec3 weighed(ModelStructure model_structure, std::span<const double, ArCoefficients::capacity> phi, std::size_t i,
             const Vec3& x) {
  constexpr std::size_t n = ArCoefficients::max_order;
  switch (model_structure) {
    case ModelStructure::per_axis:
      return {phi[i] * x.x, phi[n + i] * x.y, phi[2 * n + i] * x.z};
    case ModelStructure::vector: {
      const double* row = phi.data() + 9 * i;
      return {row[0] * x.x + row[1] * x.y + row[2] * x.z, row[3] * x.x + row[4] * x.y + row[5] * x.z,
              row[6] * x.x + row[7] * x.y + row[8] * x.z};
    }
    default:
      return phi[i] * x;
  }
}

// How many periods of its grid the model is iterated at most to reach the last step.
constexpr int most_steps = 16;

}  // namespace

NodeInfo ArPredictor::declare() {
  Declare<ArPredictor> node("prediction.ar",
                            "Predicts by weighting the last forces with auto-regressive coefficients.");
  node.details(
      "F_{t+1|t} = sum_i phi_i F_{t-i+1}. Torque is predicted in the same way with its own coefficients. With "
      "`detrend: mean`, the sum is over F - m, where m is the mean of the last window, and m is added back. With "
      "`detrend: difference`, the sum is over F_t - F_{t-1}, and F_t is added. A refitter sends with its coefficients "
      "how they were fitted: what was removed, one set for all axes, one per axis or a matrix per lag, and on which "
      "grid of times. The node applies them accordingly; until the first arrive, it uses the fixed ones. If they were "
      "fitted to resampled forces, the history is interpolated linearly at t, t - T, t - 2 T, ..., where T is the "
      "period of the grid. The model is then iterated to the estimated physics periods, 16 T at most. The node holds "
      "if the history is shorter than the order, if the refitter found nothing to fit, or if a result is not finite. A "
      "result beyond the device's limits is shortened to them. Use fixed coefficients for a motion known beforehand "
      "and for comparison; use refitted ones for forces with a texture or a tremor of their own.\nSource: Hou and "
      "Sourina, Real-time Adaptive Prediction Method for Smooth Haptic Rendering, eq. 4.");
  declare_predictor(node)
      .input("coefficients", &ArPredictor::coefficients, {.doc = "refitted coefficients", .required = false})
      .ignored_when([](const Params& p) {
        return p.coefficients == Source::fixed ? std::string("the coefficients are fixed") : std::string();
      })
      .choice("coefficients", &Params::coefficients, {{"fixed", Source::fixed}, {"refit", Source::refit}},
              std::optional(Source::refit), "whether coefficients that arrive replace the fixed ones")
      .reals("force_coefficients", &Params::force_coefficients, 0, std::vector<double>{},
             {.doc = "fixed phi_1, phi_2, ... for force; empty: a trend damped by 1/2"})
      .reals("torque_coefficients", &Params::torque_coefficients, 0, std::vector<double>{},
             {.doc = "fixed phi_1, phi_2, ... for torque; empty: a trend damped by 1/2"})
      .choice("detrend", &Params::detrend,
              {{"none", Detrend::none}, {"mean", Detrend::mean}, {"difference", Detrend::difference}},
              std::optional(Detrend::difference),
              "what is removed from the samples before the fixed coefficients weight them")
      .integer("mean_window", &Params::mean_window,
               {.doc = "number of samples kept for the mean; at least the refitter's window",
                .default_value = 300,
                .min = 1,
                .max = 100000});
  node.warms_up("the first refitted coefficients have come, and the window of the mean is full");
  node.coarser("coefficients", {std::string("fixed")}).cheaper("prediction.linear").cheaper("prediction.hold");
  node.formerly("detrend", "remove");
  return node.info();
}

ArPredictor::ArPredictor(const Params& params, const NodeContext& context)
    : Predictor(params, context), params_(params), history_(history_size(params.mean_window)) {
  model_.detrend = params.detrend;
  model_.window = params.mean_window;
  model_.force_order = fill(model_.force, params.force_coefficients, params.detrend, "force_coefficients");
  model_.torque_order = fill(model_.torque, params.torque_coefficients, params.detrend, "torque_coefficients");
}

void ArPredictor::read_inputs() {
  if (params_.coefficients == Source::fixed) return;
  if (const Stamped<ArCoefficients>* newest = coefficients.latest()) model_ = newest->value;
}

bool ArPredictor::is_warm() const {
  if (params_.coefficients == Source::refit && coefficients.connected() && coefficients.latest() == nullptr) {
    return false;
  }
  return model_.detrend != Detrend::mean ||
         history_.size() >= std::min(history_.capacity(), static_cast<std::size_t>(std::max(model_.window, 1)));
}

std::size_t ArPredictor::gather(std::size_t count, std::span<Wrench> past) const {
  const std::size_t wanted = std::min(count, past.size());
  if (model_.grid_period <= 0) {
    const std::size_t there = std::min(wanted, history_.size());
    for (std::size_t i = 0; i < there; ++i) past[i] = history_[i].value;
    return there;
  }
  const Time newest = history_[0].stamp.valid;
  SamplePlace place;
  for (std::size_t i = 0; i < wanted; ++i) {
    const Time t = newest - Duration::from_seconds(static_cast<double>(i) * model_.grid_period);
    if (!find_place(history_, t, place)) return i;
    past[i] = history_[place.age].value;
    if (place.age > 0) past[i] = between(past[i], history_[place.age - 1].value, place.share);
  }
  return wanted;
}

Wrench ArPredictor::mean() const {
  const std::size_t n = std::min(history_.size(), static_cast<std::size_t>(std::max(model_.window, 1)));
  Wrench sum;
  for (std::size_t age = 0; age < n; ++age) sum = sum + history_[age].value;
  return (1.0 / static_cast<double>(n)) * sum;
}

Predictor::Outcome ArPredictor::predict(Duration horizon, std::span<Wrench> predicted) {
  const int order = std::max(model_.force_order, torque() ? model_.torque_order : 0);
  const bool difference = model_.detrend == Detrend::difference;
  constexpr std::size_t capacity = ArCoefficients::max_order + 1;
  if (order < 1) return Outcome::held;
  const std::size_t needed = static_cast<std::size_t>(order) + (difference ? 1 : 0);
  std::array<Wrench, capacity> newest_first;
  if (gather(needed, newest_first) < needed) return Outcome::warm_up;
  const Wrench level = model_.detrend == Detrend::mean ? mean() : Wrench{};
  // Newest last, so that what the model foresees can be appended.
  std::array<Wrench, capacity + most_steps> past;
  for (std::size_t i = 0; i < needed; ++i) past[needed - 1 - i] = newest_first[i];

  // On a grid a step is a number of its periods, on samples as they come it is one.
  const double per_step = model_.grid_period > 0 ? horizon.seconds() / model_.grid_period : 1.0;
  const auto reach = [per_step](std::size_t i) {
    return std::min<double>(static_cast<double>(i + 1) * per_step, most_steps);
  };
  const auto whole = static_cast<std::size_t>(std::ceil(reach(predicted.size() - 1)));
  for (std::size_t step = 0; step < whole; ++step) {
    const std::size_t now = needed - 1 + step;
    Wrench next = difference ? past[now] : level;
    const auto sum = [&](std::int32_t n, const std::array<double, ArCoefficients::capacity>& phi, Vec3 Wrench::*part) {
      if (n < 1) next.*part = past[now].*part;
      for (std::size_t i = 0; i < static_cast<std::size_t>(std::max(n, 0)); ++i) {
        const Vec3& base = difference ? past[now - i - 1].*part : level.*part;
        next.*part += weighed(model_.model_structure, phi, i, past[now - i].*part - base);
      }
    };
    sum(model_.force_order, model_.force, &Wrench::force);
    if (torque()) sum(model_.torque_order, model_.torque, &Wrench::torque);
    past[now + 1] = next;
  }
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    const auto next = static_cast<std::size_t>(std::ceil(reach(i)));
    const Wrench& end = past[needed - 1 + next];
    const Wrench& before = past[needed + next - 2];
    predicted[i] = end + (static_cast<double>(next) - reach(i)) * (before - end);
  }
  return model_.force_order < 1 || (torque() && model_.torque_order < 1) ? Outcome::held : Outcome::predicted;
}

}  // namespace tactor
