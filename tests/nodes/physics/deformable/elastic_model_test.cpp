// Forces and stiffness of elastic bodies against differences of their energy, and what rigid motion does.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cstring>
#include <string>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "framework/core/check.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "nodes/physics/deformable/elastic_model.hpp"
#include "tests/nodes/physics/deformable/boxes.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(elastic_model_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;
using Tangent = ElasticModel::Tangent;

namespace {

constexpr double young = 2e4;

struct Kind {
  Elasticity law;
  ElementOrder order;
};
constexpr Kind kinds[] = {{Elasticity::corotational, ElementOrder::linear},
                          {Elasticity::corotational, ElementOrder::quadratic},
                          {Elasticity::neo_hookean, ElementOrder::linear},
                          {Elasticity::neo_hookean, ElementOrder::quadratic}};

std::string told(const Kind& kind) {
  return std::string(kind.law == Elasticity::corotational ? "corotational" : "neo-Hookean") +
         (kind.order == ElementOrder::linear ? ", linear" : ", quadratic");
}

ElasticModel small_box(const Kind& kind, double poisson = 0.4, bool held = true) {
  std::vector<SoftBody> bodies{soft_body(box_of_tets(2, 1, 1, {0.02, 0.012, 0.01}), young, poisson,
                                         [held](const Vec3& p) { return held && p.x < 1e-9; })};
  return {std::move(bodies), kind.law, kind.order};
}

/// Deformed by `share` of an edge, in all directions; from .7 on some elements are inverted.
Eigen::VectorXd deformed(const ElasticModel& model, double share) {
  Noise noise;
  return moved(model, model.rest(), share * 0.01 * noise.vector(model.unknowns()));
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_force_is_the_slope_of_the_energy) {
  for (const Kind& kind : kinds) {
    for (const double share : {0.1, 1.0}) {
      BOOST_TEST_CONTEXT(told(kind) << ", deformed by " << share) {
        const ElasticModel model = small_box(kind);
        const Eigen::VectorXd x = deformed(model, share);
        if (share == 1) BOOST_TEST(model.smallest_volume_ratio(x) < 0);
        Eigen::VectorXd f, slope(model.unknowns());
        model.force(x, f);
        constexpr double h = 1e-7;
        for (int i = 0; i < model.unknowns(); ++i) {
          const Eigen::VectorXd u = h * Eigen::VectorXd::Unit(model.unknowns(), i);
          slope[i] = (model.energy(moved(model, x, u)) - model.energy(moved(model, x, -u))) / (2 * h);
        }
        BOOST_TEST((f + slope).norm() < 1e-7 * f.norm());
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(the_exact_tangent_is_the_slope_of_the_force) {
  for (const Kind& kind : kinds) {
    for (const double share : {0.1, 1.0}) {
      BOOST_TEST_CONTEXT(told(kind) << ", deformed by " << share) {
        const ElasticModel model = small_box(kind);
        const Eigen::VectorXd x = deformed(model, share);
        Eigen::SparseMatrix<double> K;
        Eigen::VectorXd f, more, less, alone;
        model.assemble(x, Tangent::exact, K, f);
        model.force(x, alone);
        BOOST_TEST((f - alone).norm() < 1e-13 * f.norm());
        Eigen::MatrixXd slope(model.unknowns(), model.unknowns());
        constexpr double h = 1e-8;
        for (int i = 0; i < model.unknowns(); ++i) {
          const Eigen::VectorXd u = h * Eigen::VectorXd::Unit(model.unknowns(), i);
          model.force(moved(model, x, u), more);
          model.force(moved(model, x, -u), less);
          slope.col(i) = (less - more) / (2 * h);
        }
        BOOST_TEST((full(K) - slope).norm() < 1e-6 * slope.norm());
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(the_mean_tangent_is_half_exact_and_half_warped) {
  for (const Kind& kind : kinds) {
    for (const double share : {0.0, 0.1, 1.0}) {
      BOOST_TEST_CONTEXT(told(kind) << ", deformed by " << share) {
        const ElasticModel model = small_box(kind);
        const Eigen::VectorXd x = deformed(model, share);
        Eigen::SparseMatrix<double> exact, warped, mean;
        Eigen::VectorXd f, of_mean;
        model.assemble(x, Tangent::exact, exact, f);
        model.assemble(x, Tangent::warped, warped, f);
        model.assemble(x, Tangent::mean, mean, of_mean);
        BOOST_TEST((full(mean) - 0.5 * (full(exact) + full(warped))).norm() < 1e-12 * full(mean).norm());
        BOOST_TEST((f - of_mean).norm() < 1e-12 * f.norm() + 1e-12);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(the_projected_tangent_has_no_negative_eigenvalue) {
  for (const Kind& kind : kinds) {
    for (const double share : {0.1, 1.0, 3.0}) {
      BOOST_TEST_CONTEXT(told(kind) << ", deformed by " << share) {
        const ElasticModel model = small_box(kind);
        const Eigen::VectorXd x = deformed(model, share);
        Eigen::SparseMatrix<double> K;
        Eigen::VectorXd f;
        model.assemble(x, Tangent::projected, K, f);
        const Eigen::VectorXd projected = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(full(K)).eigenvalues();
        BOOST_TEST(projected.minCoeff() > -1e-12 * projected.maxCoeff());
        model.assemble(x, Tangent::exact, K, f);
        const Eigen::VectorXd exact = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(full(K)).eigenvalues();
        // So there was something to project, where much is compressed.
        if (share == 1) BOOST_TEST(exact.minCoeff() < -1e-3 * exact.maxCoeff());
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(at_rest_all_tangents_are_linear_elasticity) {
  for (const ElementOrder order : {ElementOrder::linear, ElementOrder::quadratic}) {
    Eigen::SparseMatrix<double> K, other;
    Eigen::VectorXd f;
    const ElasticModel corotational = small_box({Elasticity::corotational, order});
    const ElasticModel neo_hookean = small_box({Elasticity::neo_hookean, order});
    corotational.assemble(corotational.rest(), Tangent::warped, K, f);
    for (const Tangent tangent : {Tangent::projected, Tangent::exact}) {
      corotational.assemble(corotational.rest(), tangent, other, f);
      BOOST_TEST((K - other).norm() < 1e-12 * K.norm());
      neo_hookean.assemble(neo_hookean.rest(), tangent, other, f);
      BOOST_TEST((K - other).norm() < 1e-12 * K.norm());
    }
  }
}

BOOST_AUTO_TEST_CASE(the_warped_tangent_gives_the_corotational_force_of_a_turned_small_strain) {
  // The force is R K (R^T x - X) where all elements turn alike, to the first order of the strain.
  const ElasticModel model = small_box(kinds[0], 0.4, false);
  const Eigen::Matrix3d R = Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  Noise noise;
  const Eigen::VectorXd u = 1e-9 * noise.vector(model.unknowns());
  Eigen::VectorXd x(3 * model.nodes()), f, f_rest;
  for (int n = 0; n < model.nodes(); ++n)
    x.segment<3>(3 * n) = R * (model.rest().segment<3>(3 * n) + u.segment<3>(3 * n));
  Eigen::SparseMatrix<double> K;
  model.assemble(model.rest(), Tangent::warped, K, f_rest);
  model.force(x, f);
  Eigen::VectorXd expected = -(full(K) * u);
  for (int n = 0; n < model.nodes(); ++n) expected.segment<3>(3 * n) = (R * expected.segment<3>(3 * n)).eval();
  BOOST_TEST((f - expected).norm() < 1e-5 * f.norm());
}

BOOST_AUTO_TEST_CASE(rigid_motion_has_neither_energy_nor_force) {
  for (const Kind& kind : kinds) {
    BOOST_TEST_CONTEXT(told(kind)) {
      const ElasticModel model = small_box(kind, 0.45, false);
      const Eigen::Matrix3d R = Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
      Eigen::VectorXd x(3 * model.nodes()), f;
      for (int n = 0; n < model.nodes(); ++n)
        x.segment<3>(3 * n) = R * model.rest().segment<3>(3 * n) + Eigen::Vector3d(0.01, -0.02, 0.03);
      // Forces as large as the modulus on a face, energy as large as the modulus in the volume.
      model.force(x, f);
      BOOST_TEST(f.norm() < 1e-12 * young * 0.01 * 0.01);
      BOOST_TEST(std::abs(model.energy(x)) < 1e-12 * young * model.volume());
      BOOST_TEST(model.energy(model.rest()) == 0, tt::tolerance(1e-12 * young * model.volume()));
      BOOST_TEST(model.smallest_volume_ratio(x) == 1, tt::tolerance(1e-12));
    }
  }
}

BOOST_AUTO_TEST_CASE(the_mass_and_the_weight_are_those_of_the_volume) {
  for (const ElementOrder order : {ElementOrder::linear, ElementOrder::quadratic}) {
    const ElasticModel model = small_box({Elasticity::corotational, order}, 0.4, false);
    const double mass = 1000 * 0.02 * 0.012 * 0.01;
    BOOST_TEST(model.volume() == 0.02 * 0.012 * 0.01, tt::tolerance(1e-12));
    const Eigen::MatrixXd M = full(model.mass());
    Eigen::VectorXd along_y = Eigen::VectorXd::Zero(model.unknowns()), place = along_y;
    for (int i = 1; i < model.unknowns(); i += 3) along_y[i] = 1;
    for (int i = 1; i < model.unknowns(); i += 3) place[i] = model.rest()[3 * model.node_of(i) + 1];
    BOOST_TEST(along_y.dot(M * along_y) == mass, tt::tolerance(1e-12));
    // Moments of the volume, which linear shape functions can hold: the integrals of rho y and rho y^2.
    BOOST_TEST(along_y.dot(M * place) == mass * 0.006, tt::tolerance(1e-12));
    BOOST_TEST(place.dot(M * place) == mass * 0.012 * 0.012 / 3, tt::tolerance(1e-12));
    BOOST_TEST(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(M).eigenvalues().minCoeff() > 0);
    // M times a uniform acceleration.
    Eigen::VectorXd g = Eigen::VectorXd::Zero(model.unknowns());
    for (int i = 0; i < model.unknowns(); ++i) g[i] = i % 3 == 0 ? 1.5 : i % 3 == 1 ? -2.0 : -9.81;
    const Eigen::VectorXd weight = model.weight({1.5, -2, -9.81});
    BOOST_TEST((weight - M * g).norm() < 1e-12 * weight.norm());
  }
}

BOOST_AUTO_TEST_CASE(quadratic_mass_holds_fourth_moments) {
  // Of quadratic shape functions, y^2 is one; so y^4 is integrated exactly.
  const ElasticModel model = small_box({Elasticity::corotational, ElementOrder::quadratic}, 0.4, false);
  Eigen::VectorXd square = Eigen::VectorXd::Zero(model.unknowns());
  for (int i = 1; i < model.unknowns(); i += 3) square[i] = std::pow(model.rest()[3 * model.node_of(i) + 1], 2);
  BOOST_TEST(square.dot(full(model.mass()) * square) == 1000 * 0.02 * 0.01 * std::pow(0.012, 5) / 5,
             tt::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(bodies_are_apart_and_numbered_in_their_order) {
  for (const ElementOrder order : {ElementOrder::linear, ElementOrder::quadratic}) {
    const auto held = [](const Vec3& p) { return p.z < 1e-9; };
    std::vector<SoftBody> bodies{soft_body(box_of_tets(1, 1, 1, {0.01, 0.01, 0.01}), young, 0.3, held),
                                 soft_body(box_of_tets(2, 1, 1, {0.02, 0.01, 0.01}), 2 * young, 0.4, held)};
    const ElasticModel both(bodies, Elasticity::corotational, order);
    const ElasticModel second({bodies[1]}, Elasticity::corotational, order);
    BOOST_TEST(both.first_node(0) == 0);
    BOOST_TEST(both.nodes() == both.first_node(1) + second.nodes());
    const int first_unknown = both.unknowns() - second.unknowns();
    for (int i = 0; i < both.unknowns(); ++i) {
      BOOST_TEST(both.body_of(i) == (i < first_unknown ? 0 : 1));
      BOOST_TEST(both.unknown_of(both.node_of(i)) == i - i % 3);
    }
    for (int n = 0; n < both.nodes(); ++n) {
      const auto [low, high] = both.ends_of(n);
      const Eigen::Vector3d middle = 0.5 * (both.rest().segment<3>(3 * low) + both.rest().segment<3>(3 * high));
      BOOST_TEST((both.rest().segment<3>(3 * n) - middle).norm() < 1e-15);
      BOOST_TEST((both.unknown_of(n) < 0) == (both.rest()[3 * n + 2] < 1e-9));
    }
    Eigen::SparseMatrix<double> K, K_second;
    Eigen::VectorXd f;
    both.assemble(both.rest(), Tangent::warped, K, f);
    second.assemble(second.rest(), Tangent::warped, K_second, f);
    const Eigen::MatrixXd whole = full(K);
    BOOST_TEST(whole.topRightCorner(first_unknown, second.unknowns()).norm() == 0);
    BOOST_TEST((whole.bottomRightCorner(second.unknowns(), second.unknowns()) - full(K_second)).norm() <
               1e-13 * whole.norm());
  }
}

BOOST_AUTO_TEST_CASE(what_cannot_be_a_body_is_refused) {
  const SoftBody good =
      soft_body(box_of_tets(1, 1, 1, {0.01, 0.01, 0.01}), young, 0.3, [](const Vec3&) { return false; });
  const auto refused = [&](const std::function<void(SoftBody&)>& spoil, const std::string& word) {
    SoftBody body = good;
    spoil(body);
    BOOST_CHECK_EXCEPTION(ElasticModel({good, body}, Elasticity::corotational, ElementOrder::linear), InputError,
                          [&](const InputError& error) {
                            const std::string text = error.what();
                            return text.find("deformable body 1") == 0 && text.find(word) != std::string::npos;
                          });
  };
  refused([](SoftBody& b) { b.poisson = 0.5; }, "Poisson's ratio");
  refused([](SoftBody& b) { b.density = 0; }, "density");
  refused([](SoftBody& b) { b.young[3] = -1; }, "tetrahedron 3");
  refused([](SoftBody& b) { b.young.pop_back(); }, "Young's modulus of each of 6");
  refused([](SoftBody& b) { b.fixed.clear(); }, "whether it is fixed");
  refused([](SoftBody& b) { b.mesh.tets.clear(); }, "tetrahedra");
  refused([](SoftBody& b) { b.mesh.tets[2][1] = 8; }, "names node 8");
  refused([](SoftBody& b) { std::swap(b.mesh.tets[4][0], b.mesh.tets[4][1]); }, "tetrahedron 4");
  refused([](SoftBody& b) { b.mesh.tets[5][0] = b.mesh.tets[5][1]; }, "tetrahedron 5");
}

BOOST_AUTO_TEST_CASE(energy_force_and_assembly_do_not_call_the_heap_again,
                     *boost::unit_test::precondition(heap_is_counted)) {
  for (const Kind& kind : kinds) {
    BOOST_TEST_CONTEXT(told(kind)) {
      const ElasticModel model = small_box(kind);
      const Eigen::VectorXd x = deformed(model, 1);
      Eigen::SparseMatrix<double> K;
      Eigen::VectorXd f;
      model.assemble(x, Tangent::warped, K, f);
      const auto before = thread_heap_calls();
      for (const Tangent tangent : {Tangent::warped, Tangent::projected, Tangent::exact})
        model.assemble(x, tangent, K, f);
      model.force(x, f);
      const double energy = model.energy(x), ratio = model.smallest_volume_ratio(x);
      BOOST_TEST(thread_heap_calls() - before == 0);
      BOOST_TEST((energy > 0 && ratio < 1));
    }
  }
}

BOOST_AUTO_TEST_CASE(the_same_positions_give_the_same_bytes) {
  for (const Kind& kind : kinds) {
    const ElasticModel one = small_box(kind), other = small_box(kind);
    const Eigen::VectorXd x = deformed(one, 1);
    Eigen::SparseMatrix<double> K, L;
    Eigen::VectorXd f, g;
    one.assemble(x, Tangent::projected, K, f);
    other.assemble(one.rest(), Tangent::exact, L, g);
    other.assemble(x, Tangent::projected, L, g);
    BOOST_TEST(std::memcmp(K.valuePtr(), L.valuePtr(), sizeof(double) * static_cast<std::size_t>(K.nonZeros())) == 0);
    BOOST_TEST(std::memcmp(f.data(), g.data(), sizeof(double) * static_cast<std::size_t>(f.size())) == 0);
  }
}

BOOST_AUTO_TEST_CASE(mass_and_stiffness_have_the_same_pattern) {
  for (const Kind& kind : kinds) {
    const ElasticModel model = small_box(kind);
    Eigen::SparseMatrix<double> K;
    Eigen::VectorXd f;
    model.assemble(model.rest(), Tangent::warped, K, f);
    const Eigen::SparseMatrix<double>& M = model.mass();
    BOOST_TEST(std::equal(K.outerIndexPtr(), K.outerIndexPtr() + K.cols() + 1, M.outerIndexPtr(),
                          M.outerIndexPtr() + M.cols() + 1));
    BOOST_TEST(std::equal(K.innerIndexPtr(), K.innerIndexPtr() + K.nonZeros(), M.innerIndexPtr(),
                          M.innerIndexPtr() + M.nonZeros()));
    for (int column = 0; column < K.cols(); ++column) {
      BOOST_TEST(std::is_sorted(K.innerIndexPtr() + K.outerIndexPtr()[column],
                                K.innerIndexPtr() + K.outerIndexPtr()[column + 1]));
      BOOST_TEST(K.innerIndexPtr()[K.outerIndexPtr()[column]] == column);
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
