#include "nodes/prediction/multirate.hpp"

#include <algorithm>

namespace tactor {

namespace {

Vec3 part_of(const Vec3& x, int axis) {
  return {x[axis], 0, 0};
}

void shift_in(std::span<Vec3> newest_first, const Vec3& x) {
  std::copy_backward(newest_first.begin(), newest_first.end() - 1, newest_first.end());
  newest_first[0] = x;
}

}  // namespace

NodeInfo MultiratePredictor::declare() {
  Declare<MultiratePredictor> node("prediction.multirate", "Learns during the run how the force follows the device.");
  node.details(
      "y(k) = sum_{i=1..n} a_i y(k - i) + sum_{j=0..m-1} b_j u(k - j), where n is `order` and m is `input_order`. y is "
      "the change of force from one physics sample to the next, and u the device's displacement in the same interval. "
      "Both are changes, so neither the origin nor a constant force matters. a and b are fitted at the physics' rate "
      "by recursive least squares in information form with `forgetting`, from forces within the device's limits. The "
      "forecast is F_n + y(n + 1), where u(n + 1) is the device's displacement from the last sample to the forecast's "
      "time, or to now if that time is still to come. Further steps continue from there. Torque is predicted likewise "
      "over rotation vectors. `model_structure: per_axis`, as in the source, fits each axis of the world alone. `axes` "
      "shares a and b, is the same in every rotated frame and learns faster, but assumes that a surface is equally "
      "stiff in all directions. The node holds until it has seen three samples per parameter, and while the roots of a "
      "are not inside the unit circle. Use it for pressing and sliding against few, compliant surfaces. It must learn "
      "a new contact anew, in about 1 / (1 - `forgetting`) samples (0.95 to 0.995 is usual). n and m of 1 to 3 "
      "suffice.\nSource: Lee and Lee, Real-time haptic rendering using multi-rate output-estimation with ARMAX model, "
      "ICCAS 2007; least squares over changes, where the source has a noise model and positions.");
  declare_device_track(declare_predictor(node))
      .integer("order", &Params::order,
               {.doc = "number of past changes of force in the model", .default_value = 2, .min = 1, .max = max_terms})
      .integer(
          "input_order", &Params::input_order,
          {.doc = "number of displacements of the device in the model", .default_value = 2, .min = 1, .max = max_terms})
      .real("forgetting", &Params::forgetting,
            {.doc = "weight of a sample relative to the one after it", .default_value = 0.98, .min = 0.9, .max = 1})
      .choice("model_structure", &Params::model_structure, {{"axes", Shared::axes}, {"per_axis", Shared::per_axis}},
              std::optional(Shared::per_axis), "one set of parameters for the three axes (axes), or one per axis");
  return node
      .warms_up(
          "it has learnt from 3 / (1 - forgetting) samples, which hold 95 % of the weight, and from 3 samples per "
          "parameter")
      .coarser("order", {std::int64_t{4}, std::int64_t{2}, std::int64_t{1}})
      .coarser("input_order", {std::int64_t{4}, std::int64_t{2}, std::int64_t{1}})
      .cheaper("prediction.linear")
      .cheaper("prediction.hold")
      .formerly("model_structure", "products")
      .info();
}

MultiratePredictor::MultiratePredictor(const Params& params, const NodeContext& context)
    : Predictor(params, context), params_(params) {
  const int models = params.model_structure == Shared::per_axis ? 3 : 1;
  for (int i = 0; i < models; ++i) {
    force_part_.models.emplace_back(params.order + params.input_order, params.forgetting);
    torque_part_.models.emplace_back(params.order + params.input_order, params.forgetting);
  }
}

std::array<Vec3, 2 * MultiratePredictor::max_terms + 1> MultiratePredictor::terms(const Vec3& target,
                                                                                  const Vec3* changes,
                                                                                  const Vec3* ways) const {
  std::array<Vec3, 2 * max_terms + 1> z;
  z[0] = target;
  std::copy_n(changes, params_.order, z.begin() + 1);
  std::copy_n(ways, params_.input_order, z.begin() + 1 + params_.order);
  return z;
}

void MultiratePredictor::learn(Part& part, const Vec3& change, const Vec3& way) {
  shift_in(part.changes, change);
  shift_in(part.ways, way);
  if (seen_ <= std::max(params_.order + 1, params_.input_order)) return;
  const auto z = terms(part.changes[0], part.changes.data() + 1, part.ways.data());
  const std::size_t used = static_cast<std::size_t>(params_.order + params_.input_order) + 1;
  if (part.models.size() == 1) {
    part.models.front().add(std::span<const Vec3>(z).first(used));
    return;
  }
  for (int axis = 0; axis < 3; ++axis) {
    std::array<Vec3, 2 * max_terms + 1> own;
    for (std::size_t i = 0; i < used; ++i) own[i] = part_of(z[i], axis);
    part.models[static_cast<std::size_t>(axis)].add(std::span<const Vec3>(own).first(used));
  }
}

Predictor::Outcome MultiratePredictor::foresee(const Part& part, std::span<const Wrench> ways, Vec3 Wrench::*member,
                                               std::span<Wrench> predicted) const {
  const int parameters = params_.order + params_.input_order;
  const bool shared = part.models.size() == 1;
  Outcome outcome = Outcome::predicted;
  for (std::size_t m = 0; m < part.models.size(); ++m) {
    const RecursiveEquations& model = part.models[m];
    // A force that does not change is held, and nothing needs to be known of it.
    if (!has_energy(model.energy(), 0)) continue;
    if (model.samples() < std::min(3.0 * parameters, 0.9 / (1.0 - params_.forgetting))) {
      outcome = Outcome::warm_up;
      continue;
    }
    constexpr double ridge = 1e-6;
    const ArFit fit = model.equations().solve(ridge, {.max_order = parameters, .samples = model.samples()});
    if (fit.order < parameters || !is_stable(fit.coefficients().first(static_cast<std::size_t>(params_.order)))) {
      outcome = Outcome::held;
      continue;
    }
    Terms changes = part.changes;
    Terms inputs = part.ways;
    Vec3 sum;
    for (std::size_t step = 0; step < predicted.size(); ++step) {
      shift_in(inputs, ways[step].*member);
      const auto z = terms({}, changes.data(), inputs.data());
      Vec3 change;
      for (std::size_t i = 0; i < static_cast<std::size_t>(parameters); ++i) change += fit.phi[i] * z[i + 1];
      shift_in(changes, change);
      sum += change;
      Vec3& next = predicted[step].*member;
      if (shared) {
        next += sum;
      } else {
        next[static_cast<int>(m)] += sum[static_cast<int>(m)];
      }
    }
  }
  return outcome;
}

void MultiratePredictor::take(const Stamped<Wrench>& sample) {
  const Pose before = X_WD_;
  const Wrench last = newest_.value;
  // What the device cannot display need not be known, and would be remembered for long.
  newest_ = {sample.stamp,
             {limited(sample.value.force, params_.force_max), limited(sample.value.torque, params_.torque_max)}};
  if (!track_.at(sample.stamp.valid, X_WD_)) {
    seen_ = 0;
    return;
  }
  if (seen_++ == 0) return;
  seen_ = std::min(seen_, 2 * max_terms);
  const Wrench way = displacement(before, X_WD_);
  ++learnt_;
  learn(force_part_, newest_.value.force - last.force, way.force);
  if (torque()) learn(torque_part_, newest_.value.torque - last.torque, way.torque);
}

bool MultiratePredictor::is_warm() const {
  const double parameters = params_.order + params_.input_order;
  const double remembered = params_.forgetting < 1 ? 1.0 / (1.0 - params_.forgetting) : 0;
  return static_cast<double>(learnt_) >= 3.0 * std::max(parameters, remembered);
}

Predictor::Outcome MultiratePredictor::predict(Duration horizon, std::span<Wrench> predicted) {
  if (seen_ <= std::max(params_.order, params_.input_order)) return Outcome::warm_up;
  std::array<Wrench, Forecast::capacity> ways;
  Pose from = X_WD_;
  Time t = newest_.stamp.valid;
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    t = t + horizon;
    Pose to;
    if (!track_.at(t, to)) return Outcome::held;
    ways[i] = displacement(from, to);
    from = to;
  }
  const Outcome of_force = foresee(force_part_, ways, &Wrench::force, predicted);
  const Outcome of_torque = torque() ? foresee(torque_part_, ways, &Wrench::torque, predicted) : Outcome::predicted;
  return of_force != Outcome::predicted ? of_force : of_torque;
}

}  // namespace tactor
