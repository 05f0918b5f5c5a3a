// The radial basis against closed forms and a dense solution.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/LU>

#include "nodes/forcefield/radial_basis.hpp"
#include "tests/support/dice.hpp"

BOOST_AUTO_TEST_SUITE(radial_basis_test)

using namespace tactor;

namespace {

// Wendland's function expanded: 1 - 10 r^2 + 20 r^3 - 15 r^4 + 4 r^5.
double expanded(double r) {
  return r >= 1 ? 0 : 1 - 10 * r * r + 20 * r * r * r - 15 * r * r * r * r + 4 * r * r * r * r * r;
}

std::vector<std::int64_t> all_points(const Lattice& lattice) {
  std::vector<std::int64_t> points(static_cast<std::size_t>(lattice.points()));
  std::iota(points.begin(), points.end(), 0);
  return points;
}

const Lattice cube{{-0.01, 0.02, 0}, 0.003, {6, 5, 4}};

}  // namespace

BOOST_AUTO_TEST_CASE(one_centre_is_wendlands_function_of_the_distance) {
  const double support = 0.007;
  for (const double ridge : {0.0, 0.25}) {
    RadialBasis basis(cube, {.support = support, .ridge = ridge});
    const std::int64_t centre = (2 * 5 + 1) * 6 + 3;  // (3, 1, 2)
    const Vec3 c{-0.001, 0.023, 0.006};
    BOOST_TEST(norm(cube.point(centre) - c) < 1e-15);
    const Vec3 value{1, -2, 0.5};
    BOOST_TEST(basis.fit(std::vector{centre}, std::vector{value}) < 1e-6);
    test::Dice dice(1);
    for (int n = 0; n < 500; ++n) {
      const Vec3 x = c + dice.in_cube(0.008);
      const Vec3 wanted = expanded(norm(x - c) / support) / (1 + ridge) * value;
      BOOST_TEST(norm(basis.at(x) - wanted) < 1e-12);
    }
  }
}

BOOST_AUTO_TEST_CASE(the_fit_is_that_of_a_dense_solution) {
  test::Dice dice(2);
  std::vector<std::int64_t> points;
  std::vector<Vec3> values;
  for (const std::int64_t p : all_points(cube)) {
    if (dice(0, 1) < 0.3) continue;  // centres need not fill the lattice
    points.push_back(p);
    values.push_back(dice.in_cube(3));
  }
  const auto n = static_cast<Eigen::Index>(points.size());
  const double support = 0.0085, ridge = 0.01;
  Eigen::MatrixXd A(n, n), b(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto at = [&](Eigen::Index k) { return cube.point(points[static_cast<std::size_t>(k)]); };
    for (Eigen::Index j = 0; j < n; ++j) A(i, j) = expanded(norm(at(i) - at(j)) / support) + (i == j ? ridge : 0);
    for (int axis = 0; axis < 3; ++axis) b(i, axis) = values[static_cast<std::size_t>(i)][axis];
  }
  const Eigen::MatrixXd w = A.fullPivLu().solve(b);
  RadialBasis basis(cube, {.support = support, .ridge = ridge});
  BOOST_TEST(basis.fit(points, values) < 1e-6);
  BOOST_TEST(basis.centres() == points.size());
  for (int k = 0; k < 300; ++k) {
    const Vec3 x = Vec3{-0.002, 0.026, 0.005} + dice.in_cube(0.015);
    Eigen::RowVector3d wanted = Eigen::RowVector3d::Zero();
    for (Eigen::Index i = 0; i < n; ++i) {
      wanted += expanded(norm(x - cube.point(points[static_cast<std::size_t>(i)])) / support) * w.row(i);
    }
    BOOST_TEST(norm(basis.at(x) - Vec3{wanted[0], wanted[1], wanted[2]}) < 1e-6);
  }
}

BOOST_AUTO_TEST_CASE(without_a_ridge_the_values_are_met_and_with_one_they_are_smaller) {
  test::Dice dice(3);
  const std::vector<std::int64_t> points = all_points(cube);
  std::vector<Vec3> values;
  for (std::size_t i = 0; i < points.size(); ++i) values.push_back(dice.in_cube(2));
  RadialBasis exact(cube, {.support = 0.009, .ridge = 0}), smooth(cube, {.support = 0.009, .ridge = 0.5});
  exact.fit(points, values);
  smooth.fit(points, values);
  double met = 0, squares = 0, smoothed = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    met = std::max(met, norm(exact.at(cube.point(points[i])) - values[i]));
    squares += dot(values[i], values[i]);
    const Vec3 v = smooth.at(cube.point(points[i]));
    smoothed += dot(v, v);
  }
  BOOST_TEST(met < 1e-5);
  BOOST_TEST(smoothed < squares);
}

BOOST_AUTO_TEST_CASE(it_is_zero_far_away_and_where_there_is_no_place) {
  RadialBasis basis(cube, {.support = 0.009, .ridge = 0});
  const double inf = std::numeric_limits<double>::infinity();
  BOOST_TEST(norm(basis.at({0, 0.025, 0.003})) == 0.0);  // not fitted yet
  const std::vector<std::int64_t> points = all_points(cube);
  basis.fit(points, std::vector<Vec3>(points.size(), Vec3{1, 1, 1}));
  BOOST_TEST(norm(basis.at({0, 0.025, 0.003})) > 1.0);
  for (const double far : {std::nan(""), inf, -inf, 1e300, -1e300, 1.0, -1.0, 0.0411}) {
    BOOST_TEST(norm(basis.at({0, far, 0.003})) == 0.0);
    BOOST_TEST(norm(basis.at({far, 0.025, 0.003})) == 0.0);
  }
}

BOOST_AUTO_TEST_SUITE_END()
