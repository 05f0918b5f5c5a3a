// An all-pole filter in the form of a normalised lattice, whose coefficients may change from sample to sample.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>

namespace tactor {

/// The reflection coefficients k_1 .. k_p of x_t = sum phi_i x_{t-i} + e_t: k_p = phi_p, and from order m to m - 1
///   phi_i <- (phi_i + k_m phi_{m-i}) / (1 - k_m^2).
/// All lie inside (-1, 1) where and only where the filter is stable (the Schur-Cohn test, as in nodes/prediction). The
/// variance of x is that of e over the product of 1 - k_m^2.
struct Reflection {
  static constexpr std::size_t most_order = 32;
  std::array<double, most_order> k{};

  /// None where the filter is not stable, or `phi` is longer than most_order.
  static std::optional<Reflection> of(std::span<const double> phi) {
    if (phi.size() > most_order) return std::nullopt;
    std::array<double, most_order> a{}, lower{};
    for (std::size_t i = 0; i < phi.size(); ++i) a[i] = phi[i];
    Reflection result;
    for (std::size_t m = phi.size(); m > 0; --m) {
      const double k = a[m - 1];
      if (!(std::abs(k) < 1)) return std::nullopt;
      result.k[m - 1] = k;
      for (std::size_t i = 0; i + 1 < m; ++i) lower[i] = (a[i] + k * a[m - 2 - i]) / (1 - k * k);
      a = lower;
    }
    return result;
  }
  /// The variance of x where e has 1.
  [[nodiscard]] double gain() const {
    double product = 1;
    for (const double each : k) product *= 1 - each * each;
    return 1 / product;
  }
};

/// Each section turns the pair of forward and backward error,
///   f_{m-1} = s f_m + k b_{m-1},  b_m <- s b_{m-1} - k f_m,  s = sqrt(1 - k_m^2),
/// so that it keeps their squares' sum: white noise of variance 1 in is a signal of variance 1 out, whatever the
/// coefficients, and it stays bounded however they change.
class NormalisedLattice {
 public:
  /// The next sample for `e`, of variance 1.
  double next(const Reflection& reflection, double e) {
    double f = e;
    for (std::size_t m = Reflection::most_order; m > 0; --m) {
      const double k = reflection.k[m - 1], s = std::sqrt(1 - k * k);
      const double before = b_[m - 1];
      b_[m] = s * before - k * f;
      f = s * f + k * before;
    }
    b_[0] = f;
    return f;
  }
  /// Backward errors, of variance 1 and without correlation where the signal is under way.
  void set_errors(std::span<const double, Reflection::most_order> errors) {
    for (std::size_t m = 0; m < Reflection::most_order; ++m) b_[m] = errors[m];
  }

 private:
  std::array<double, Reflection::most_order + 1> b_{};
};

}  // namespace tactor
