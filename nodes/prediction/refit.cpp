#include "nodes/prediction/refit.hpp"

#include <algorithm>
#include <string>

#include "nodes/prediction/sample_gate.hpp"

namespace tactor {

namespace {

// Beyond a third of the window a biased autocovariance is mostly made of samples that are not there.
int top_order(const Refitter::Params& p) {
  const int highest = p.window / 3;
  if (p.order > highest) {
    throw InputError("order: expected at most window / 3 = " + std::to_string(highest) + ", found " +
                     std::to_string(p.order) + "; lower the order or widen the window");
  }
  return p.order > 0 ? p.order : std::min(p.max_order, highest);
}

std::size_t lags(const Refitter::Params& p) {
  return static_cast<std::size_t>(top_order(p)) + 1;
}

}  // namespace

NodeInfo Refitter::declare() {
  return Declare<Refitter>("prediction.refit", "Fits auto-regressive coefficients to the last forces.")
      .details(
          "Biased autocovariances of the last `window` samples, with scalar products over the axes, give the "
          "Yule-Walker equations R phi = r, solved by Levinson-Durbin; force and torque apart. The order is `order`, "
          "or "
          "with 0 the one of Akaike's smallest final prediction error s2 (N + p + 1) / (N - p - 1) up to `max_order` "
          "and "
          "a third of the window. `remove` says what is fitted: the samples (as the paper prints it), the samples "
          "about "
          "their mean, or their differences. The first coefficients are sent when the window is full. Where the "
          "samples "
          "hold no energy, order 0 is sent and the predictor holds. A sample that is not finite is left out.\n"
          "Source: Hou and Sourina, Real-time Adaptive Prediction Method for Smooth Haptic Rendering, eq. 5 to 11.")
      .input(
          "force", &Refitter::force,
          {.doc = "the physics force on the device", .trigger = Trigger::yes, .queue = {QueuePolicy::drop_oldest, 512}})
      .output("coefficients", &Refitter::coefficients, "the coefficients fitted to the window")
      .integer("window", &Params::window,
               {.doc = "samples (or differences) that are fitted", .default_value = 300, .min = 9, .max = 100000})
      .integer("order", &Params::order,
               {.doc = "order of the model; 0: by the final prediction error",
                .default_value = 0,
                .min = 0,
                .max = ArCoefficients::max_order})
      .integer("max_order", &Params::max_order,
               {.doc = "highest order the final prediction error may choose",
                .default_value = 20,
                .min = 1,
                .max = ArCoefficients::max_order})
      .choice("method", &Params::method, {{"yule_walker", Method::yule_walker}}, std::optional(Method::yule_walker),
              "how the coefficients are computed")
      .choice("remove", &Params::remove,
              {{"none", Removal::none}, {"mean", Removal::mean}, {"difference", Removal::difference}},
              std::optional(Removal::difference), "what is left out of the samples before they are fitted")
      .integer("period", &Params::period,
               {.doc = "samples from one refit to the next", .default_value = 1, .min = 1, .max = 100000})
      .info();
}

Refitter::Refitter(const Params& params, const NodeContext& context)
    : params_(params),
      torque_(context.torque),
      top_order_(top_order(params)),
      force_window_(static_cast<std::size_t>(params.window), lags(params), params.remove == Removal::mean),
      torque_window_(static_cast<std::size_t>(params.window), lags(params), params.remove == Removal::mean),
      since_refit_(params.period) {}

ArFit Refitter::fit(AutocovarianceWindow& window) {
  std::array<double, ArCoefficients::max_order + 1> storage{};
  const std::span<double> r = std::span(storage).first(static_cast<std::size_t>(top_order_) + 1);
  window.covariances(r);
  ArFit result;
  if (has_energy(r[0], window.noise())) {
    result = fit_yule_walker(r, {.max_order = top_order_, .by_fpe = params_.order == 0, .samples = params_.window});
  }
  if (result.order == 0) ++rejected_;
  return result;
}

void Refitter::step(StepContext&) {
  Stamped<Wrench> sample;
  Time newest;
  bool taken = false;
  while (samples_.next(force, sample)) {
    Wrench value = sample.value;
    if (!torque_) value.torque = {};
    if (!is_usable(value)) {
      ++rejected_samples_;
      continue;
    }
    const Wrench fitted = params_.remove == Removal::difference ? value - last_ : value;
    const bool first_difference = params_.remove == Removal::difference && !any_;
    last_ = value;
    any_ = true;
    newest = sample.stamp.valid;
    if (first_difference || !is_usable(fitted)) continue;
    force_window_.push(fitted.force);
    if (torque_) torque_window_.push(fitted.torque);
    ++since_refit_;
    taken = true;
  }
  if (!taken || !force_window_.full() || since_refit_ < params_.period) return;
  since_refit_ = 0;
  ++refits_;
  ArCoefficients c;
  c.removal = params_.remove;
  c.window = params_.window;
  const ArFit force_fit = fit(force_window_);
  c.force_order = force_fit.order;
  c.force = force_fit.phi;
  c.force_error_variance = force_fit.error_variance;
  order_sum_ += force_fit.order;
  if (torque_) {
    const ArFit torque_fit = fit(torque_window_);
    c.torque_order = torque_fit.order;
    c.torque = torque_fit.phi;
    c.torque_error_variance = torque_fit.error_variance;
  }
  coefficients.send(newest, c);
}

void Refitter::report(Report& report) const {
  report.set("refits", static_cast<double>(refits_));
  report.set("refit.rejected", static_cast<double>(rejected_));
  report.set("refit.rejected_samples", static_cast<double>(rejected_samples_));
  if (refits_ > 0) {
    report.set("refit.force_order_mean", static_cast<double>(order_sum_) / static_cast<double>(refits_));
  }
}

}  // namespace tactor
