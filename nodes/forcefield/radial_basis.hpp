// A vector field on radial basis functions of compact support, whose centres lie on a lattice.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "framework/core/spatial.hpp"

namespace tactor {

/// A box of points at equal distances along the axes: origin + spacing * (i, j, k), 0 <= i < count[0] and so on; the
/// index of a point is (k count[1] + j) count[0] + i.
struct Lattice {
  Vec3 origin;         ///< m
  double spacing = 1;  ///< m, above 0
  std::array<std::int64_t, 3> count{1, 1, 1};

  [[nodiscard]] std::int64_t points() const { return count[0] * count[1] * count[2]; }
  [[nodiscard]] Vec3 point(std::int64_t index) const;
};

/// f(x) = sum_j w_j phi(|x - c_j| / R) with Wendland's function of smoothness C2 in three dimensions,
///   phi(r) = (1 - r)^4 (4 r + 1) for r < 1, else 0
/// (H. Wendland, "Piecewise polynomial, positive definite and compactly supported radial functions of minimal degree",
/// 1995). Local on purpose: a value takes a bounded number of centres, about 4 (R / spacing)^3, however large the
/// field.
class RadialBasis {
 public:
  struct Options {
    double support = 0;  ///< R in m, at least the lattice's spacing
    double ridge = 0;    ///< 0: the values are met; above, smaller weights are preferred (see fit)
  };
  /// A field of zero.
  RadialBasis(const Lattice& lattice, const Options& options);

  /// Fits values[i] at the lattice points[i] (indices, ascending), which become the centres: (A + ridge I) w = values,
  /// A_ij = phi(|c_i - c_j| / R), positive definite, by conjugate gradients. Returns the largest relative residual of
  /// the equations over the components; below 1e-6 where the solver came to its end.
  double fit(std::span<const std::int64_t> points, std::span<const Vec3> values);

  /// Zero farther than R from all centres and where x is not finite. Allocates nothing; looks at (2 R / spacing + 1)^3
  /// lattice points at most.
  [[nodiscard]] Vec3 at(const Vec3& x) const;

  [[nodiscard]] std::size_t centres() const { return weights_.size(); }
  [[nodiscard]] std::size_t memory_bytes() const {
    return centre_of_.size() * sizeof(centre_of_[0]) + weights_.size() * sizeof(weights_[0]);
  }

 private:
  /// Calls visit(centre, phi) for each centre nearer than R to x.
  template <class Visit>
  void each_near(const Vec3& x, const Visit& visit) const;

  Lattice lattice_;
  Options options_;
  std::vector<std::int32_t> centre_of_;  // a lattice point's, or -1
  std::vector<Vec3> weights_;
};

}  // namespace tactor
