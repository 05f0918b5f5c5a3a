// Factors that learn from pairs of ways and forces, against dense matrices by the BFGS formula.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "nodes/physics/deformable/elastic_model.hpp"
#include "nodes/physics/deformable/suitesparse_plugin.hpp"
#include "nodes/physics/deformable/updated_factor.hpp"
#include "tests/nodes/physics/deformable/boxes.hpp"

BOOST_AUTO_TEST_SUITE(updated_factor_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

constexpr double softest = 2500;  // 1/s^2, what the mass is multiplied with

ElasticModel held_box() {
  std::vector<SoftBody> bodies{
      soft_body(box_of_tets(4, 3, 3, {0.05, 0.04, 0.03}), 2e4, 0.45, [](const Vec3& p) { return p.z < 1e-9; })};
  return {std::move(bodies), Elasticity::corotational, ElementOrder::linear};
}

/// The matrix of a step where the box is twisted by so much (rad) at its end.
Eigen::SparseMatrix<double> twisted(const ElasticModel& model, double angle) {
  Eigen::VectorXd x = model.rest();
  for (int n = 0; n < model.nodes(); ++n) {
    const Eigen::Vector3d p = x.segment<3>(3 * n);
    const double turn = angle * p.x() / 0.05;
    x.segment<3>(3 * n) = Eigen::Vector3d(p.x(), std::cos(turn) * p.y() - std::sin(turn) * p.z(),
                                          std::sin(turn) * p.y() + std::cos(turn) * p.z());
  }
  Eigen::SparseMatrix<double> K;
  Eigen::VectorXd f;
  model.assemble(x, ElasticModel::Tangent::warped, K, f);
  return K + softest * model.mass();
}

std::vector<FactorKind> all_kinds() {
  std::vector<FactorKind> all{FactorKind::eigen};
  if (has_suitesparse_plugin()) all.insert(all.end(), {FactorKind::simplicial, FactorKind::supernodal});
  return all;
}

/// The inverse of the block of the inverse.
Eigen::MatrixXd schur_of(const Eigen::MatrixXd& B, const std::vector<int>& last) {
  std::vector<int> rows;
  for (const int node : last) {
    for (int c = 0; c < 3; ++c) rows.push_back(3 * node + c);
  }
  const Eigen::MatrixXd H = B.inverse();
  return H(rows, rows).inverse();
}

}  // namespace

BOOST_AUTO_TEST_CASE(it_solves_and_condenses_as_the_dense_bfgs_formula_says_of_the_last_eight_pairs) {
  const ElasticModel model = held_box();
  const Eigen::SparseMatrix<double> P = twisted(model, 0), A = twisted(model, 0.4);
  const Eigen::MatrixXd exact = full(A);
  const std::vector<int> last{7, 3, 12, 20};
  for (const FactorKind kind : all_kinds()) {
    UpdatedFactor factor(make_factor(kind, 0));
    factor.analyze(P, last);
    BOOST_REQUIRE(factor.factor(P));
    Noise noise;
    std::vector<Eigen::VectorXd> ways;
    for (std::size_t k = 0; k < UpdatedFactor::most_pairs + 3; ++k) {
      ways.push_back(noise.vector(P.rows()));
      BOOST_TEST(factor.update(ways.back(), exact * ways.back()));
      // B' = B - B s s^T B / (s . B s) + y y^T / (y . s), from the factor of P through the pairs that are kept.
      Eigen::MatrixXd B = full(P);
      const std::size_t kept = std::min(ways.size(), UpdatedFactor::most_pairs);
      BOOST_TEST(factor.pairs() == kept);
      for (std::size_t i = ways.size() - kept; i < ways.size(); ++i) {
        const Eigen::VectorXd &s = ways[i], y = exact * s, Bs = B * s;
        B += y * y.transpose() / y.dot(s) - Bs * Bs.transpose() / s.dot(Bs);
      }
      Eigen::VectorXd x = noise.vector(P.rows());
      const Eigen::VectorXd expected = B.ldlt().solve(x);
      factor.solve(x);
      BOOST_TEST((x - expected).norm() < 1e-9 * expected.norm());
      const Eigen::MatrixXd S = schur_of(B, last);
      BOOST_TEST((factor.schur() - S).norm() < 1e-9 * S.norm());
    }
    // The way of the newest pair it knows exactly.
    Eigen::VectorXd y = exact * ways.back();
    factor.solve(y);
    BOOST_TEST((y - ways.back()).norm() < 1e-9 * y.norm());
    // A new factor forgets.
    BOOST_REQUIRE(factor.factor(A));
    BOOST_TEST(factor.pairs() == 0U);
    const Eigen::MatrixXd S = schur_of(exact, last);
    BOOST_TEST((factor.schur() - S).norm() < 1e-9 * S.norm());
  }
}

BOOST_AUTO_TEST_CASE(iterations_converge_faster_where_the_factor_learns) {
  const ElasticModel model = held_box();
  const Eigen::SparseMatrix<double> P = twisted(model, 0), A = twisted(model, 0.4);
  const Eigen::MatrixXd exact = full(A);
  Noise noise;
  const Eigen::VectorXd b = noise.vector(P.rows());
  std::array<int, 2> taken{};
  for (const bool learns : {false, true}) {
    UpdatedFactor factor(make_factor(FactorKind::eigen, 0));
    factor.analyze(P, {});
    BOOST_REQUIRE(factor.factor(P));
    Eigen::VectorXd x = Eigen::VectorXd::Zero(b.size());
    int& iterations = taken[learns ? 1 : 0];
    for (Eigen::VectorXd left = b; left.norm() > 1e-8 * b.norm() && iterations < 200; ++iterations) {
      Eigen::VectorXd d = left;
      factor.solve(d);
      x += d;
      left = b - exact * x;
      if (learns) factor.update(d, exact * d);
    }
  }
  BOOST_TEST_MESSAGE("iterations " << taken[0] << ", learning " << taken[1]);
  BOOST_TEST(taken[1] < 40);
  BOOST_TEST(2 * taken[1] < taken[0]);
}

BOOST_AUTO_TEST_CASE(a_way_along_which_the_force_does_not_push_back_teaches_nothing) {
  const ElasticModel model = held_box();
  const Eigen::SparseMatrix<double> P = twisted(model, 0);
  UpdatedFactor factor(make_factor(FactorKind::eigen, 0));
  factor.analyze(P, std::vector<int>{2, 5});
  BOOST_REQUIRE(factor.factor(P));
  const Eigen::MatrixXd before = factor.schur();
  Noise noise;
  const Eigen::VectorXd s = noise.vector(P.rows());
  BOOST_TEST(!factor.update(s, -s));
  BOOST_TEST(!factor.update(s, Eigen::VectorXd::Zero(s.size())));
  BOOST_TEST(factor.pairs() == 0U);
  BOOST_TEST((factor.schur() - before).norm() == 0);
}

BOOST_AUTO_TEST_CASE(a_full_matrix_takes_as_many_multiplications_as_its_columns_have_squares) {
  // Of n unknowns: the sum of k^2 for k from 1 to n. All nodes of one tetrahedron are coupled.
  TetMesh tet;
  tet.nodes = {{0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0}, {0, 0, 0.01}};
  tet.tets = {{0, 1, 2, 3}};
  const ElasticModel model({soft_body(tet, 1e4, 0.3, [](const Vec3&) { return false; })}, Elasticity::corotational,
                           ElementOrder::linear);
  const Eigen::SparseMatrix<double> A = twisted(model, 0);
  const auto n = static_cast<double>(A.rows());
  for (const FactorKind kind : all_kinds()) {
    const std::unique_ptr<SparseFactor> factor = make_factor(kind, 0);
    factor->analyze(A, {});
    BOOST_REQUIRE(factor->factor(A));
    BOOST_TEST_CONTEXT(factor->name()) {
      BOOST_TEST(factor->multiplications() == n * (n + 1) * (2 * n + 1) / 6, tt::tolerance(1e-12));
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
