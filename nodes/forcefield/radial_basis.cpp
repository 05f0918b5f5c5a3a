#include "nodes/forcefield/radial_basis.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

double wendland(double r) {
  const double s = 1 - r;
  return s * s * s * s * (4 * r + 1);
}

}  // namespace

Vec3 Lattice::point(std::int64_t index) const {
  const std::int64_t i = index % count[0], j = index / count[0] % count[1], k = index / count[0] / count[1];
  return origin + spacing * Vec3{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
}

RadialBasis::RadialBasis(const Lattice& lattice, const Options& options)
    : lattice_(lattice), options_(options), centre_of_(static_cast<std::size_t>(lattice.points()), -1) {
  TACTOR_DEMAND(lattice.spacing > 0 && options.support >= lattice.spacing && options.ridge >= 0);
}

template <class Visit>
void RadialBasis::each_near(const Vec3& x, const Visit& visit) const {
  if (!is_finite(x)) return;
  std::array<std::int64_t, 3> first{}, last{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const double middle = (x[axis] - lattice_.origin[axis]) / lattice_.spacing;
    const double radius = options_.support / lattice_.spacing;
    const auto most = static_cast<double>(lattice_.count[a] - 1);
    // Compared before they are made integers, which far away they would not fit.
    if (!(middle + radius >= 0 && middle - radius <= most)) return;
    first[a] = static_cast<std::int64_t>(std::ceil(std::max(0.0, middle - radius)));
    last[a] = static_cast<std::int64_t>(std::floor(std::min(most, middle + radius)));
  }
  const double support2 = options_.support * options_.support;
  for (std::int64_t k = first[2]; k <= last[2]; ++k) {
    for (std::int64_t j = first[1]; j <= last[1]; ++j) {
      const std::int64_t row = (k * lattice_.count[1] + j) * lattice_.count[0];
      for (std::int64_t i = first[0]; i <= last[0]; ++i) {
        const std::int32_t centre = centre_of_[static_cast<std::size_t>(row + i)];
        if (centre < 0) continue;
        const Vec3 way = x - lattice_.point(row + i);
        const double d2 = dot(way, way);
        if (d2 < support2) visit(centre, wendland(std::sqrt(d2 / support2)));
      }
    }
  }
}

double RadialBasis::fit(std::span<const std::int64_t> points, std::span<const Vec3> values) {
  TACTOR_DEMAND(points.size() == values.size());
  std::fill(centre_of_.begin(), centre_of_.end(), -1);
  const auto n = static_cast<Eigen::Index>(points.size());
  weights_.assign(points.size(), {});
  if (n == 0) return 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::int32_t& centre = centre_of_[static_cast<std::size_t>(points[i])];
    TACTOR_DEMAND(i == 0 || points[i - 1] < points[i]);
    centre = static_cast<std::int32_t>(i);
  }
  Eigen::SparseMatrix<double, Eigen::RowMajor> A(n, n);
  for (Eigen::Index row = 0; row < n; ++row) {
    A.startVec(row);
    each_near(lattice_.point(points[static_cast<std::size_t>(row)]), [&](std::int32_t centre, double phi) {
      A.insertBack(row, centre) = centre == row ? phi + options_.ridge : phi;
    });
  }
  A.finalize();
  Eigen::ConjugateGradient<Eigen::SparseMatrix<double, Eigen::RowMajor>, Eigen::Lower | Eigen::Upper> solver(A);
  solver.setTolerance(1e-8);
  solver.setMaxIterations(10000);
  double residual = 0;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::VectorXd b(n);
    for (Eigen::Index i = 0; i < n; ++i) b[i] = values[static_cast<std::size_t>(i)][axis];
    const Eigen::VectorXd w = solver.solve(b);
    residual = std::max(residual, solver.error());
    for (Eigen::Index i = 0; i < n; ++i) weights_[static_cast<std::size_t>(i)][axis] = w[i];
  }
  return residual;
}

Vec3 RadialBasis::at(const Vec3& x) const {
  Vec3 sum;
  each_near(x, [&](std::int32_t centre, double phi) { sum += phi * weights_[static_cast<std::size_t>(centre)]; });
  return sum;
}

}  // namespace tactor
