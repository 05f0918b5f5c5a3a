// Sparse Cholesky factors against dense ones.
#include <boost/test/unit_test.hpp>

#include <cstring>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "framework/realtime/allocation_watch.hpp"
#include "nodes/physics/deformable/elastic_model.hpp"
#include "nodes/physics/deformable/sparse_factor.hpp"
#include "nodes/physics/deformable/suitesparse_plugin.hpp"
#include "tests/nodes/physics/deformable/boxes.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(sparse_factor_test)

using namespace tactor;
using namespace tactor::test;

namespace {

/// A dynamic matrix of a box: mass over h^2 and stiffness.
Eigen::SparseMatrix<double> step_matrix(int nx, int ny, int nz) {
  std::vector<SoftBody> bodies{
      soft_body(box_of_tets(nx, ny, nz, {0.05, 0.04, 0.03}), 2e4, 0.45, [](const Vec3& p) { return p.z < 1e-9; })};
  const ElasticModel model(std::move(bodies), Elasticity::corotational, ElementOrder::linear);
  Eigen::SparseMatrix<double> K;
  Eigen::VectorXd f;
  model.assemble(model.rest(), ElasticModel::Tangent::warped, K, f);
  return K + 2500 * model.mass();
}

std::vector<FactorKind> kinds() {
  std::vector<FactorKind> all{FactorKind::eigen};
  if (has_suitesparse_plugin()) all.insert(all.end(), {FactorKind::simplicial, FactorKind::supernodal});
  return all;
}

/// The Schur complement by the dense inverse.
Eigen::MatrixXd dense_schur(const Eigen::MatrixXd& A, const std::vector<int>& last) {
  const Eigen::MatrixXd inverse = A.ldlt().solve(Eigen::MatrixXd::Identity(A.rows(), A.cols()));
  const auto size = static_cast<Eigen::Index>(last.size());
  Eigen::MatrixXd part(3 * size, 3 * size);
  for (Eigen::Index a = 0; a < size; ++a) {
    for (Eigen::Index b = 0; b < size; ++b) {
      part.block<3, 3>(3 * a, 3 * b) =
          inverse.block<3, 3>(3 * last[static_cast<std::size_t>(a)], 3 * last[static_cast<std::size_t>(b)]);
    }
  }
  return part.inverse();
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_factor_solves_as_a_dense_one_does) {
  const Eigen::SparseMatrix<double> A = step_matrix(5, 4, 3);
  const Eigen::MatrixXd dense = full(A);
  Noise noise;
  const Eigen::VectorXd b = noise.vector(A.rows());
  const Eigen::VectorXd expected = dense.ldlt().solve(b);
  for (const FactorKind kind : kinds()) {
    const std::unique_ptr<SparseFactor> factor = make_factor(kind, 0);
    BOOST_TEST_CONTEXT(factor->name()) {
      for (const std::vector<int>& last : {std::vector<int>{}, {17, 3, 40, 41, 8}}) {
        factor->analyze(A, last);
        // Twice with other values, because the analysis is used again.
        for (const double scale : {3.0, 1.0}) {
          BOOST_TEST(factor->factor(scale * A));
          Eigen::VectorXd x = b;
          factor->solve(x);
          BOOST_TEST((scale * x - expected).norm() < 1e-11 * expected.norm());
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(the_schur_complement_is_that_of_the_last_nodes_in_their_order) {
  const Eigen::SparseMatrix<double> A = step_matrix(5, 4, 3);
  const Eigen::MatrixXd dense = full(A);
  for (const FactorKind kind : kinds()) {
    const std::unique_ptr<SparseFactor> factor = make_factor(kind, 0);
    BOOST_TEST_CONTEXT(factor->name()) {
      for (const std::vector<int>& last :
           {std::vector<int>{2}, {50, 7, 51, 12}, {0, 30, 60, 89, 1, 31, 61, 88, 45, 44, 43, 42, 41, 40, 39, 38}}) {
        factor->analyze(A, last);
        BOOST_TEST(factor->factor(A));
        Eigen::MatrixXd S;
        factor->schur(S);
        const Eigen::MatrixXd expected = dense_schur(dense, last);
        BOOST_TEST((S - expected).norm() < 1e-11 * expected.norm());
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_large_matrix_is_solved_whichever_way_its_nodes_are_ordered) {
  const Eigen::SparseMatrix<double> A = step_matrix(12, 12, 10);
  Noise noise;
  const Eigen::VectorXd b = noise.vector(A.rows());
  const std::vector<int> last{100, 500, 900, 1000, 1200, 7};
  Eigen::MatrixXd first_schur;
  for (const FactorKind kind : kinds()) {
    const std::unique_ptr<SparseFactor> factor = make_factor(kind, 0);
    BOOST_TEST_CONTEXT(factor->name()) {
      factor->analyze(A, last);
      BOOST_TEST(factor->factor(A));
      Eigen::VectorXd x = b;
      factor->solve(x);
      const Eigen::VectorXd back = A.selfadjointView<Eigen::Lower>() * x;
      BOOST_TEST((back - b).norm() < 1e-10 * b.norm());
      Eigen::MatrixXd S;
      factor->schur(S);
      if (first_schur.size() == 0) first_schur = S;
      BOOST_TEST((S - first_schur).norm() < 1e-10 * S.norm());
    }
  }
}

BOOST_AUTO_TEST_CASE(an_indefinite_matrix_has_no_factor_and_the_next_one_has) {
  Eigen::SparseMatrix<double> A = step_matrix(3, 3, 3);
  for (const FactorKind kind : kinds()) {
    const std::unique_ptr<SparseFactor> factor = make_factor(kind, 0);
    BOOST_TEST_CONTEXT(factor->name()) {
      factor->analyze(A, {});
      Eigen::SparseMatrix<double> indefinite = A;
      indefinite.coeffRef(20, 20) = -1;
      BOOST_TEST(!factor->factor(indefinite));
      BOOST_TEST(factor->factor(A));
      Eigen::VectorXd x = Eigen::VectorXd::Ones(A.rows());
      factor->solve(x);
      const Eigen::VectorXd back = A.selfadjointView<Eigen::Lower>() * x;
      BOOST_TEST((back - Eigen::VectorXd::Ones(A.rows())).norm() < 1e-10);
    }
  }
}

BOOST_AUTO_TEST_CASE(the_same_matrix_gives_the_same_bytes) {
  const Eigen::SparseMatrix<double> A = step_matrix(12, 12, 10);
  const std::vector<int> last{3, 4, 5};
  for (const FactorKind kind : kinds()) {
    std::vector<Eigen::VectorXd> results;
    for (int run = 0; run < 2; ++run) {
      const std::unique_ptr<SparseFactor> factor = make_factor(kind, 0);
      factor->analyze(A, last);
      for (int again = 0; again < 2; ++again) {
        BOOST_TEST(factor->factor(A));
        results.emplace_back(Eigen::VectorXd::Ones(A.rows()));
        factor->solve(results.back());
      }
    }
    for (const Eigen::VectorXd& x : results) {
      BOOST_TEST(std::memcmp(x.data(), results.front().data(), sizeof(double) * static_cast<std::size_t>(x.size())) ==
                 0);
    }
  }
}

BOOST_AUTO_TEST_CASE(small_bodies_are_factored_by_eigen) {
  BOOST_TEST(std::string(make_factor(FactorKind::automatic, least_for_supernodal - 1)->name()) == "Eigen");
  BOOST_TEST(std::string(make_factor(FactorKind::automatic, least_for_supernodal)->name()) ==
             (has_suitesparse_plugin() ? "CHOLMOD supernodal" : "Eigen"));
}

BOOST_AUTO_TEST_CASE(a_portable_factor_never_calls_the_BLAS) {
  BOOST_TEST(std::string(make_factor(FactorKind::portable, least_for_simplicial - 1)->name()) == "Eigen");
  BOOST_TEST(std::string(make_factor(FactorKind::portable, least_for_simplicial)->name()) ==
             (has_suitesparse_plugin() ? "CHOLMOD simplicial" : "Eigen"));
}

BOOST_AUTO_TEST_CASE(no_factor_starts_a_thread) {
  // Neither OpenMP in CHOLMOD nor the BLAS.
  const auto threads = [] {
    const std::filesystem::directory_iterator tasks("/proc/self/task");
    return std::distance(begin(tasks), end(tasks));
  };
  const Eigen::SparseMatrix<double> A = step_matrix(12, 12, 10);
  for (const FactorKind kind : kinds()) {
    const std::unique_ptr<SparseFactor> factor = make_factor(kind, 0);
    BOOST_TEST_CONTEXT(factor->name()) {
      const auto before = threads();
      factor->analyze(A, {});
      BOOST_TEST(factor->factor(A));
      Eigen::VectorXd b = Eigen::VectorXd::Ones(A.rows());
      factor->solve(b);
      BOOST_TEST(threads() == before);
    }
  }
}

BOOST_AUTO_TEST_CASE(solving_does_not_call_the_heap, *boost::unit_test::precondition(heap_is_counted)) {
  const Eigen::SparseMatrix<double> A = step_matrix(8, 8, 8);
  for (const FactorKind kind : kinds()) {
    const std::unique_ptr<SparseFactor> factor = make_factor(kind, 0);
    BOOST_TEST_CONTEXT(factor->name()) {
      factor->analyze(A, {});
      BOOST_TEST(factor->factor(A));
      Eigen::VectorXd b = Eigen::VectorXd::Ones(A.rows());
      factor->solve(b);
      const auto before = thread_heap_calls();
      factor->solve(b);
      BOOST_TEST(thread_heap_calls() - before == 0);
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
