// What every predictor does around its own formula: bad samples are kept out, outputs stay within the device's limits.
#pragma once

#include <cstdint>
#include <span>

#include "framework/core/refusals.hpp"
#include "framework/core/spatial.hpp"
#include "framework/node/declare.hpp"

namespace tactor {

/// The device's limits on force and torque, by norm.
struct ForceLimits {
  double force_max = 0;   ///< N
  double torque_max = 0;  ///< N m
};

/// True where the square of x is finite, so that x can be weighed and summed.
inline bool is_usable(const Vec3& x) {
  return std::isfinite(dot(x, x));
}
inline bool is_usable(const Wrench& x) {
  return is_usable(x.force) && is_usable(x.torque);
}

/// Counts what a predictor could not use or had to repair; a prediction is repaired for force and torque apart.
class ForecastGuard {
 public:
  ForecastGuard(const ForceLimits& limits, bool torque) : limits_(limits), torque_(torque) {}

  /// Takes a sample in: the sample where it is usable, else the last usable one (zero before the first), counted.
  /// Returns true where it was usable.
  bool accept(Wrench& sample) {
    if (!torque_) sample.torque = {};
    if (is_usable(sample)) {
      last_ = sample;
      refused_.count(RefusalReason::none);
      return true;
    }
    sample = last_;
    refused_.count(RefusalReason::not_finite);
    ++fallbacks_;
    return false;
  }

  /// Makes all of them ones that can be displayed: shortened to the device's limits, and a step of `predicted` that is
  /// not finite the one before it (the first the current one). Returns true where a step had to be repaired, and counts
  /// the forecast.
  bool repair(Wrench& current, std::span<Wrench> predicted) {
    bool repaired = repair(current, predicted, &Wrench::force, limits_.force_max);
    if (torque_) {
      repaired = repair(current, predicted, &Wrench::torque, limits_.torque_max) || repaired;
    } else {
      for (Wrench& step : predicted) step.torque = {};
    }
    if (repaired) ++fallbacks_;
    return repaired;
  }

  /// Counts a prediction that was held because nothing better could be computed.
  void count_held() { ++fallbacks_; }
  /// Counts a prediction that was held because the history is still too short.
  void count_warm_up() { ++warm_up_; }

  /// Declares its metrics, of a node with a `guard()`.
  template <class N>
  static void declare(Declare<N>& node) {
    node.metric("fallbacks", "1", "predictions that were repaired, or held because nothing better could be computed",
                Better::lower, [](const N& self) { return self.guard().fallbacks_; })
        .summed()
        .metric("prediction.rejected_samples", "1", "samples that were not finite, or too late to be used",
                Better::lower, [](const N& self) { return self.guard().refused_.refused(); })
        .summed()
        .metric("prediction.not_finite", "1", "parts of predictions that were not finite: a step was held",
                Better::lower, [](const N& self) { return self.guard().not_finite_; })
        .summed()
        .metric("prediction.clamped", "1", "parts of predictions that were shortened to the device's limit",
                Better::lower, [](const N& self) { return self.guard().clamped_; })
        .summed()
        .metric("prediction.warm_up", "1", "predictions that were held because too little had been seen",
                Better::neither, [](const N& self) { return self.guard().warm_up_; })
        .summed();
  }

  [[nodiscard]] const Refusals& refusals() const { return refused_; }
  [[nodiscard]] bool torque() const { return torque_; }

 private:
  bool repair(Wrench& current, std::span<Wrench> predicted, Vec3 Wrench::*part, double limit) {
    bool not_finite = false;
    bool clamped = false;
    current.*part = limited(current.*part, limit);
    const Wrench* before = &current;
    for (Wrench& step : predicted) {
      if (!is_usable(step.*part)) {
        step.*part = (*before).*part;
        not_finite = true;
      }
      if (norm(step.*part) > limit) {
        step.*part = limited(step.*part, limit);
        clamped = true;
      }
      before = &step;
    }
    not_finite_ += not_finite ? 1 : 0;
    clamped_ += clamped ? 1 : 0;
    return not_finite || clamped;
  }

  ForceLimits limits_;
  bool torque_;
  Wrench last_;
  Refusals refused_{"forces"};
  std::int64_t fallbacks_ = 0, not_finite_ = 0, clamped_ = 0, warm_up_ = 0;
};

}  // namespace tactor
