// Elastic bodies in balance against closed forms: stretched bars, bent beams, compressed columns.
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <string>

#include "nodes/physics/deformable/elastic_law.hpp"
#include "nodes/physics/deformable/static_balance.hpp"
#include "tests/nodes/physics/deformable/boxes.hpp"

BOOST_AUTO_TEST_SUITE(static_balance_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

constexpr double young = 5e4;  // Pa

/// The force on the unknowns of a uniform traction `t` (Pa) on the faces of the boundary at x = length.
Eigen::VectorXd traction_at_end(const ElasticModel& model, const TetMesh& mesh, double length,
                                const Eigen::Vector3d& t) {
  Eigen::VectorXd f = Eigen::VectorXd::Zero(model.unknowns());
  const auto add = [&](int node, const Eigen::Vector3d& force) {
    if (model.unknown_of(node) >= 0) f.segment<3>(model.unknown_of(node)) += force;
  };
  for (const std::array<int, 4>& tet : mesh.tets) {
    for (std::size_t off = 0; off < 4; ++off) {
      std::array<int, 3> face{};
      bool at_end = true;
      for (std::size_t c = 0, k = 0; c < 4; ++c) {
        if (c == off) continue;
        face[k++] = tet[c];
        at_end &= mesh.nodes[static_cast<std::size_t>(tet[c])].x > length - 1e-9;
      }
      if (!at_end) continue;
      const auto p = [&](std::size_t c) { return mesh.nodes[static_cast<std::size_t>(face[c])]; };
      const Eigen::Vector3d force = 0.5 * norm(cross(p(1) - p(0), p(2) - p(0))) * t;
      // Shape functions of quadratic triangles have no integral at corners.
      if (model.order() == ElementOrder::linear) {
        for (const int node : face) add(node, force / 3);
        continue;
      }
      for (int node = static_cast<int>(mesh.nodes.size()); node < model.nodes(); ++node) {
        const auto [low, high] = model.ends_of(node);
        const auto on_face = [&](int end) { return end == face[0] || end == face[1] || end == face[2]; };
        if (on_face(low) && on_face(high)) add(node, force / 3);
      }
    }
  }
  return f;
}

/// What stable neo-Hookean stores at the stretches a along and b across, J/m^3.
double stored(double a, double b, double mu, double lambda) {
  const double alpha = 1 + 0.75 * mu / lambda;
  const double I = a * a + 2 * b * b, J = a * b * b;
  const double psi = 0.5 * mu * (I - 3) + 0.5 * lambda * (J - alpha) * (J - alpha) - 0.5 * mu * std::log(I + 1);
  const double rest = 0.5 * lambda * (1 - alpha) * (1 - alpha) - 0.5 * mu * std::log(4.0);
  return psi - rest;
}

/// The stretch across at which free sides have no stress: d stored / d b = 0.
double side_of(double along, double mu, double lambda) {
  double low = 0.5, high = 1.5;
  for (int i = 0; i < 60; ++i) {
    const double b = 0.5 * (low + high), h = 1e-6;
    (stored(along, b + h, mu, lambda) > stored(along, b - h, mu, lambda) ? high : low) = b;
  }
  return low;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_stretched_bar_with_free_sides_stores_the_energy_of_uniaxial_stress) {
  for (const ElementOrder order : {ElementOrder::linear, ElementOrder::quadratic}) {
    for (const double poisson : {0.0, 0.3, 0.45}) {
      for (const double stretch : {1.1, 1.02}) {
        const double lame_mu = young / (2 * (1 + poisson)),
                     lame_lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
        const double mu = 4.0 / 3 * lame_mu, lambda = lame_lambda + 5.0 / 6 * lame_mu;
        const double side = side_of(stretch, mu, lambda);
        const double h = 1e-5;
        const double stress = (stored(stretch + h, side, mu, lambda) - stored(stretch - h, side, mu, lambda)) / (2 * h);
        // A quarter of a bar: planes through its axis hold it, by fixed nodes on the axis and a start in the solution's
        // shape.
        const TetMesh mesh = box_of_tets(4, 2, 2, {0.04, 0.02, 0.02});
        const ElasticModel model({soft_body(mesh, young, poisson, [](const Vec3& p) { return norm(p) < 1e-9; })},
                                 Elasticity::neo_hookean, order);
        // Tractions on both ends, so that nothing else holds the bar but one corner.
        Eigen::VectorXd outer = traction_at_end(model, mesh, 0.04, {stress, 0, 0});
        TetMesh turned = mesh;
        for (Vec3& p : turned.nodes) p.x = 0.04 - p.x;
        outer += traction_at_end(model, turned, 0.04, {-stress, 0, 0});
        const Balance balance = settle(model, model.rest(), {}, outer);
        BOOST_TEST_CONTEXT("poisson " << poisson << ", stretch " << stretch) {
          BOOST_TEST(balance.converged);
          BOOST_TEST(model.energy(balance.x) == model.volume() * stored(stretch, side, mu, lambda),
                     tt::tolerance(1e-6));
          BOOST_TEST(model.smallest_volume_ratio(balance.x) == stretch * side * side, tt::tolerance(1e-6));
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(uniform_stretch_is_in_balance_with_its_tractions) {
  // Compressed bars too, which a free end would let turn round.
  for (const ElementOrder order : {ElementOrder::linear, ElementOrder::quadratic}) {
    for (const double stretch : {0.7, 0.9, 1.5}) {
      const double poisson = 0.4, lame_mu = young / (2 * (1 + poisson)),
                   lame_lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
      const double mu = 4.0 / 3 * lame_mu, lambda = lame_lambda + 5.0 / 6 * lame_mu;
      const double b = side_of(stretch, mu, lambda), h = 1e-5;
      const double stress = (stored(stretch + h, b, mu, lambda) - stored(stretch - h, b, mu, lambda)) / (2 * h);
      const TetMesh mesh = box_of_tets(3, 2, 2, {0.03, 0.02, 0.02});
      const ElasticModel model({soft_body(mesh, young, poisson, [](const Vec3& p) { return p.x < 1e-9; })},
                               Elasticity::neo_hookean, order);
      Eigen::VectorXd x = model.rest(), f;
      for (int node = 0; node < model.nodes(); ++node) x.segment<3>(3 * node).array() *= Eigen::Array3d(stretch, b, b);
      model.force(x, f);
      BOOST_TEST(model.energy(x) == model.volume() * stored(stretch, b, mu, lambda), tt::tolerance(1e-9));
      BOOST_TEST((f + traction_at_end(model, mesh, 0.03, {stress, 0, 0})).norm() < 1e-6 * f.norm());
    }
  }
}

BOOST_AUTO_TEST_CASE(a_column_under_its_weight_shortens_as_a_rod_does) {
  // Poisson's ratio 0: no sides matter; u(z) = -rho g / E (L z - z^2 / 2). Quadratic elements hold that exactly.
  constexpr double length = 0.1, g = 9.81, density = 1000;
  for (const int n : {4, 8}) {
    const TetMesh mesh = box_of_tets(1, 1, n, {0.02, 0.02, length});
    const ElasticModel model({soft_body(mesh, 1e7, 0, [](const Vec3& p) { return p.z < 1e-9; })},
                             Elasticity::corotational, ElementOrder::quadratic);
    const Balance balance = settle(model, model.rest(), {0, 0, -g});
    BOOST_TEST(balance.converged);
    for (int node = 0; node < model.nodes(); ++node) {
      const double z = model.rest()[3 * node + 2];
      const double expected = -density * g / 1e7 * (length * z - 0.5 * z * z);
      BOOST_TEST(std::abs(balance.x[3 * node + 2] - z - expected) < 1e-8 * length);
    }
  }
}

namespace {

/// The tip's deflection of a slender cantilever under a small end load, over that of beam theory; `high` elements in
/// its height.
double bending_of(ElementOrder order, int high, double poisson) {
  constexpr double height = 0.01, length = 0.1, load = 1e-3;  // m, m, N
  const TetMesh mesh = box_of_tets(10 * high, high, high, {length, height, height});
  const ElasticModel model({soft_body(mesh, young, poisson, [](const Vec3& p) { return p.x < 1e-9; })},
                           Elasticity::corotational, order);
  const Balance balance =
      settle(model, model.rest(), {}, traction_at_end(model, mesh, length, {0, 0, load / (height * height)}));
  BOOST_TEST(balance.converged);
  double sum = 0;
  int count = 0;
  for (int node = 0; node < model.nodes(); ++node) {
    if (model.rest()[3 * node] < length - 1e-9) continue;
    sum += balance.x[3 * node + 2] - model.rest()[3 * node + 2];
    ++count;
  }
  // Timoshenko: bending and shear, with Cowper's coefficient of a square section.
  const double area = height * height, inertia = height * height * height * height / 12,
               shear = 10 * (1 + poisson) / (12 + 11 * poisson);
  const double expected = load * length * length * length / (3 * young * inertia) +
                          load * length * 2 * (1 + poisson) / (shear * area * young);
  return sum / count / expected;
}

}  // namespace

BOOST_AUTO_TEST_CASE(quadratic_beams_bend_as_beam_theory_says) {
  for (const double poisson : {0.0, 0.3, 0.45}) {
    const double share = bending_of(ElementOrder::quadratic, 2, poisson);
    BOOST_TEST_CONTEXT("poisson " << poisson) {
      BOOST_TEST(share == 1, tt::tolerance(0.04));
    }
  }
}

BOOST_AUTO_TEST_CASE(linear_beams_are_too_stiff_and_less_so_with_smaller_elements) {
  // Locking: the more so the nearer Poisson's ratio is to 0.5. Finer elements approach beam theory from below.
  double last = 0;
  for (const int high : {2, 4, 8}) {
    const double share = bending_of(ElementOrder::linear, high, 0.45);
    BOOST_TEST_MESSAGE("linear tetrahedra at 0.45, " << high << " high: " << share << " of beam theory");
    BOOST_TEST(share > last);
    BOOST_TEST(share < 1);
    last = share;
  }
  BOOST_TEST(bending_of(ElementOrder::linear, 2, 0.45) < 0.7 * bending_of(ElementOrder::linear, 2, 0.0));
  BOOST_TEST(last > 0.75);
}

BOOST_AUTO_TEST_CASE(a_soft_beam_hangs_straight_down_where_its_weight_is_large) {
  // Far beyond linear: the way there needs the line search. No closed form, but a string of the same weight hangs
  // straight.
  for (const Elasticity law : {Elasticity::corotational, Elasticity::neo_hookean}) {
    const TetMesh mesh = box_of_tets(10, 1, 1, {0.2, 0.01, 0.01});
    const ElasticModel model({soft_body(mesh, 2e4, 0.4, [](const Vec3& p) { return p.x < 1e-9; })}, law,
                             ElementOrder::quadratic);
    const Balance balance = settle(model, model.rest(), {0, 0, -9.81});
    BOOST_TEST(balance.converged);
    BOOST_TEST(balance.residual < 1e-9);
    double lowest = 0, farthest = 0;
    for (int node = 0; node < model.nodes(); ++node) {
      lowest = std::min(lowest, balance.x[3 * node + 2]);
      farthest = std::max(farthest, balance.x[3 * node]);
    }
    BOOST_TEST(lowest < -0.15);
    BOOST_TEST(farthest < 0.05);
  }
}

BOOST_AUTO_TEST_CASE(inverted_elements_find_their_way_back_to_rest) {
  for (const Elasticity law : {Elasticity::corotational, Elasticity::neo_hookean}) {
    const ElasticModel model(
        {soft_body(box_of_tets(3, 3, 3, {0.03, 0.03, 0.03}), young, 0.4, [](const Vec3& p) { return p.z < 1e-9; })},
        law, ElementOrder::linear);
    Noise noise;
    const Eigen::VectorXd start = moved(model, model.rest(), 0.01 * noise.vector(model.unknowns()));
    BOOST_TEST(model.smallest_volume_ratio(start) < 0);
    const Balance balance = settle(model, start, {});
    BOOST_TEST(balance.converged);
    BOOST_TEST((balance.x - model.rest()).norm() < 1e-8 * model.rest().norm());
  }
}

BOOST_AUTO_TEST_CASE(a_body_that_nothing_holds_has_no_balance_under_its_weight) {
  const ElasticModel model(
      {soft_body(box_of_tets(1, 1, 1, {0.01, 0.01, 0.01}), young, 0.3, [](const Vec3&) { return false; })},
      Elasticity::corotational, ElementOrder::linear);
  BalanceOptions options;
  options.most_steps = 20;
  BOOST_TEST(!settle(model, model.rest(), {0, 0, -9.81}, {}, options).converged);
  BOOST_TEST(settle(model, model.rest(), {}, {}, options).converged);
}

BOOST_AUTO_TEST_SUITE_END()
