#include "nodes/prediction/refit.hpp"

#include <algorithm>
#include <string>

#include "framework/core/value_error.hpp"
#include "nodes/prediction/sample_gate.hpp"

namespace tactor {

namespace {

void refuse_contradictions(const Refitter::Params& p) {
  if (p.model_structure == ModelStructure::vector && p.method != ArMethod::yule_walker) {
    throw ValueError("model_structure",
                     "model_structure: only `method: yule_walker` can fit vector; change one of the two");
  }
  if (p.method != ArMethod::rls) return;
  if (p.detrend == Detrend::mean) {
    throw ValueError("detrend", "detrend: mean needs a window, and `method: rls` has none; use `difference` or `none`");
  }
  if (p.window_time > 0) {
    throw ValueError("window_time", "window_time: `method: rls` has no window; set `forgetting` instead");
  }
}

// Beyond a third of the samples a biased autocovariance is mostly made of samples that are not there. A vector model
// has three regressors a lag. A recursion forgets, so that it holds as many samples as its weights sum to in the end.
int top_order(const Refitter::Params& p) {
  refuse_contradictions(p);
  int highest = p.window / 3;
  std::string bound = "window / 3";
  std::string remedy = "; lower the order or widen the window";
  if (p.model_structure == ModelStructure::vector) {
    highest = std::min(p.window / 9, ArCoefficients::max_vector_order);
    bound = "window / 9 and " + std::to_string(ArCoefficients::max_vector_order);
  } else if (p.method == ArMethod::rls) {
    constexpr double most = ArCoefficients::max_order;
    highest = std::max(1, static_cast<int>(std::min(most, 0.3 / (1.0 - p.forgetting))));
    bound = "0.3 / (1 - forgetting)";
    remedy = "; lower the order or forget more slowly";
  }
  if (p.order > highest) {
    throw ValueError("order", "order: expected at most " + bound + " = " + std::to_string(highest) + ", found " +
                                  std::to_string(p.order) + remedy);
  }
  return p.order > 0 ? p.order : std::min(p.max_order, highest);
}

ArEstimatorOptions estimator_options(const Refitter::Params& p) {
  return {.method = p.method,
          .window = static_cast<std::size_t>(p.window),
          .max_order = top_order(p),
          .remove_mean = p.detrend == Detrend::mean,
          .forgetting = p.forgetting};
}

constexpr const char* refit_details =
    "Fits x_{t+1} = sum_i phi_i x_{t-i+1} to the last `window` samples, or to those of the last `window_time`. Force "
    "and torque are fitted separately. `detrend` says what x is: the samples (as the paper prints it), the samples "
    "about their mean, or their differences.\n`method: yule_walker` solves R phi = r of the biased autocovariances by "
    "Levinson-Durbin. It is always stable, the cheapest, and the paper's method. Its bias shrinks as the window grows, "
    "so it needs 200 samples or more. `burg` minimises forward and backward errors together, with one reflection "
    "coefficient k = 2 sum f.b / sum(|f|^2 + |b|^2) per order. It is always stable, nearly without bias, and good from "
    "30 samples on. `covariance` is least squares over the window. It is exact on a sum of waves without noise, but "
    "not always stable; an unstable fit is replaced by that of Yule-Walker and counted. `rls` is least squares over "
    "the whole past, weighted by `forgetting`^age. It has no edge at which samples leave, follows slow changes, and "
    "remembers an impact for 1 / (1 - forgetting) samples, 100 by default (0.95 to 0.998 is usual). Its unstable fits "
    "are shrunk and counted. Every ridge is 1e-9 of the energy, so the unit does not matter.\n`model_structure: axes` "
    "takes scalar products over the axes: one phi, the same in every rotated frame. `per_axis` fits each axis alone, "
    "for a scene whose axes differ, at three times the cost. `vector` fits a 3x3 matrix per lag by Whittle's "
    "recursion, order 8 at most. It is for axes that drive each other, with windows of 300 or more; in the shipped "
    "scenes it is no better than `axes`.\nThe order is `order`. With 0 it is the order with the smallest criterion, up "
    "to `max_order` and a third of the samples (vector: a ninth). The criterion is FPE s2 (N + p + 1) / (N - p - 1), "
    "AIC N ln s2 + 2 p, or BIC N ln s2 + p ln N, which takes the lowest orders. `resample` interpolates the samples "
    "linearly onto even times, one mean period of the last 64 apart, and tells the predictor to do the same. Use it "
    "for physics with a changing rate. The first coefficients are sent when the window is full; with rls, when it "
    "holds three samples per order. If the samples hold no energy, order 0 is sent and the predictor holds. A sample "
    "that is not finite is left out. `refit.spectral_radius_*` in the report come from at most 128 models of force, "
    "spread evenly over the run.\nSources: Hou and Sourina, Real-time Adaptive Prediction Method for Smooth Haptic "
    "Rendering, eq. 5 to 11; Burg, Maximum entropy spectral analysis (1967), in the form of Vos, A fast implementation "
    "of Burg's method (2013); Kay, Modern Spectral Estimation (1988); Haykin, Adaptive Filter Theory; Whittle, On the "
    "fitting of multivariate autoregressions (1963).";

void declare_refit_parameters(Declare<Refitter>& node) {
  node.integer("window", &Refitter::Params::window,
               {.doc = "most samples (or differences) that are fitted", .default_value = 300, .min = 9, .max = 100000})
      .real("window_time", &Refitter::Params::window_time,
            {.doc = "only samples of this last interval of time are fitted; 0: as many as `window`",
             .unit = "s",
             .default_value = 0,
             .min = 0,
             .max = 1000})
      .integer("order", &Refitter::Params::order,
               {.doc = "order of the model; 0: chosen by `order_by`",
                .default_value = 0,
                .min = 0,
                .max = ArCoefficients::max_order})
      .integer("max_order", &Refitter::Params::max_order,
               {.doc = "highest order that `order_by` may choose",
                .default_value = 20,
                .min = 1,
                .max = ArCoefficients::max_order})
      .choice("order_by", &Refitter::Params::order_by,
              {{"fpe", OrderRule::fpe}, {"aic", OrderRule::aic}, {"bic", OrderRule::bic}},
              std::optional(OrderRule::fpe), "the criterion that chooses the order if `order` is 0")
      .choice("method", &Refitter::Params::method,
              {{"yule_walker", ArMethod::yule_walker},
               {"burg", ArMethod::burg},
               {"covariance", ArMethod::covariance},
               {"rls", ArMethod::rls}},
              std::optional(ArMethod::yule_walker), "how the coefficients are computed")
      .choice(
          "model_structure", &Refitter::Params::model_structure,
          {{"axes", ModelStructure::axes}, {"per_axis", ModelStructure::per_axis}, {"vector", ModelStructure::vector}},
          std::optional(ModelStructure::axes),
          "one set of coefficients for the three axes (axes), one per axis, or matrices (vector)")
      .real("forgetting", &Refitter::Params::forgetting,
            {.doc = "weight of a sample relative to the one after it, for rls",
             .default_value = 0.99,
             .min = 0.9,
             .max = 1})
      .choice("detrend", &Refitter::Params::detrend,
              {{"none", Detrend::none}, {"mean", Detrend::mean}, {"difference", Detrend::difference}},
              std::optional(Detrend::difference), "what is removed from the samples before they are fitted")
      .boolean("resample", &Refitter::Params::resample, false, "interpolate the samples onto even times first")
      .integer("period", &Refitter::Params::period,
               {.doc = "number of samples from one refit to the next", .default_value = 1, .min = 1, .max = 100000})
      .coarser("window", {std::int64_t{200}, std::int64_t{100}, std::int64_t{50}, std::int64_t{30}})
      .coarser("order", {std::int64_t{10}, std::int64_t{5}, std::int64_t{3}, std::int64_t{1}})
      .coarser("max_order", {std::int64_t{10}, std::int64_t{5}, std::int64_t{3}, std::int64_t{1}})
      .unread_when({"max_order"}, [](const Refitter::Params& p,
                                     const ParamUse&) { return std::string(p.order > 0 ? "the order is given" : ""); })
      .coarser("period", {std::int64_t{2}, std::int64_t{4}, std::int64_t{8}, std::int64_t{16}})
      .formerly("detrend", "remove")
      .formerly("model_structure", "products");
}

}  // namespace

std::optional<double> Refitter::radius(double share) const {
  std::vector<double> radii = force_part_.spectral_radii();
  if (radii.empty()) return std::nullopt;
  std::sort(radii.begin(), radii.end());
  return radii[std::min(radii.size() - 1, static_cast<std::size_t>(share * static_cast<double>(radii.size())))];
}

void Refitter::declare_metrics(Declare<Refitter>& node) {
  node.metric("refits", "1", "fits of the coefficients", Better::neither, &Refitter::refits_)
      .metric("refit.rejected", "1", "fits of force or torque of samples that hold no energy: order 0 was sent",
              Better::lower, &Refitter::rejected_)
      .metric("refit.rejected_samples", "1", "samples that were not finite", Better::lower,
              &Refitter::rejected_samples_)
      .metric("refit.unstable", "1", "fits that were not stable, and were replaced or shrunk", Better::lower,
              [](const Refitter& self) { return self.force_part_.unstable() + self.torque_part_.unstable(); })
      .metric("refit.force_order_mean", "1", "order of the model of force, mean of the fits", Better::neither,
              [](const Refitter& self) {
                const auto fits = static_cast<double>(self.refits_);
                return fits > 0 ? std::optional(static_cast<double>(self.order_sum_) / fits) : std::nullopt;
              })
      .missing_where("no fit is made")
      .metric("refit.spectral_radius_median", "1", "spectral radius of the models of force, median", Better::neither,
              [](const Refitter& self) { return self.radius(0.5); })
      .missing_where("no fit is made")
      .metric("refit.spectral_radius_max", "1", "spectral radius of the models of force, largest", Better::neither,
              [](const Refitter& self) { return self.radius(1); })
      .missing_where("no fit is made");
}

NodeInfo Refitter::declare() {
  Declare<Refitter> node("prediction.refit", "Fits auto-regressive coefficients to the last forces.");
  node.details(refit_details)
      .input(
          "force", &Refitter::force,
          {.doc = "the physics force on the device", .trigger = Trigger::yes, .queue = {QueuePolicy::drop_oldest, 512}})
      .output("coefficients", &Refitter::coefficients, "the coefficients fitted to the window")
      .role(Role::prediction)
      .warms_up("its window is full (rls: it has taken 3 / (1 - forgetting) samples)");
  declare_refit_parameters(node);
  declare_metrics(node);
  return node.info();
}

Refitter::Refitter(const Params& params, const NodeContext& context)
    : params_(params),
      torque_(context.torque),
      top_order_(top_order(params)),
      force_part_(estimator_options(params), params.model_structure),
      torque_part_(estimator_options(params), params.model_structure),
      times_(static_cast<std::size_t>(params.window)),
      since_refit_(params.period) {}

void Refitter::take(const Stamped<Wrench>& sample) {
  const Wrench& value = sample.value;
  const Wrench fitted = params_.detrend == Detrend::difference ? value - last_ : value;
  const bool first_difference = params_.detrend == Detrend::difference && !any_;
  last_ = value;
  any_ = true;
  if (first_difference || !is_usable(fitted)) return;
  force_part_.push(fitted.force);
  if (torque_) torque_part_.push(fitted.torque);
  times_.push(sample.stamp.valid);
  ++since_refit_;
  ++taken_;
  if (params_.window_time <= 0) return;
  while (times_.size() > 1 && (times_[0] - times_.oldest()).seconds() > params_.window_time) {
    times_.drop_oldest();
    force_part_.drop_oldest();
    if (torque_) torque_part_.drop_oldest();
    started_ = true;
  }
}

bool Refitter::ready() const {
  if (params_.method == ArMethod::rls) return force_part_.samples() >= 3.0 * top_order_;
  return times_.full();
}

bool Refitter::window_is_full() const {
  if (params_.method != ArMethod::rls || params_.forgetting >= 1) return started_;
  return static_cast<double>(taken_) >= 3.0 / (1.0 - params_.forgetting);
}

void Refitter::step(StepContext& context) {
  Stamped<Wrench> sample;
  Time newest;
  const std::int64_t before = since_refit_;
  while (samples_.next(force, sample)) {
    if (!torque_) sample.value.torque = {};
    if (!is_usable(sample.value)) {
      ++rejected_samples_;
      continue;
    }
    newest = sample.stamp.valid;
    if (!params_.resample) {
      take(sample);
      continue;
    }
    grid_.push(sample);
    while (grid_.next(sample)) take(sample);
  }
  started_ = started_ || ready();
  if (since_refit_ == before || !started_ || since_refit_ < params_.period) return;
  since_refit_ = 0;
  ++refits_;
  ArCoefficients c;
  c.detrend = params_.detrend;
  c.window = static_cast<std::int32_t>(times_.size());
  c.model_structure = params_.model_structure;
  c.grid_period = params_.resample ? grid_.period().seconds() : 0.0;
  // Over differences 0 holds, over samples 1 does, about the mean the mean is as good.
  const double hold = params_.detrend == Detrend::none ? 1.0 : 0.0;
  c.force_order = force_part_.fit(params_.order, params_.order_by, hold, c.force, c.force_error_variance);
  rejected_ += c.force_order == 0;
  order_sum_ += c.force_order;
  if (torque_) {
    c.torque_order = torque_part_.fit(params_.order, params_.order_by, hold, c.torque, c.torque_error_variance);
    rejected_ += c.torque_order == 0;
  }
  coefficients.send(newest, c);
  if (!warm_since_ && window_is_full()) warm_since_ = context.now();
}

}  // namespace tactor
