// The volume of bodies that hardly compress, under pressure and under a ball that is pressed in deep.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include <Eigen/LU>
#include <Eigen/SVD>

#include "tests/nodes/physics/deformable/soft_rig.hpp"

BOOST_AUTO_TEST_SUITE(volume_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

constexpr double young = 2e4, poisson = 0.495;  // Pa; the largest ratio that scenes allow
constexpr double mu = young / (2 * (1 + poisson)), bulk = young / (3 * (1 - 2 * poisson)),
                 lambda = bulk - 2.0 / 3 * mu;  // Pa
/// Of stable neo-Hookean (Smith, De Goes and Kim, TOG 2018): psi = mu/2 (I - 3) + lambda/2 (J - a)^2 - mu/2 log(I + 1),
/// I = |F|^2, J = det F.
constexpr double neo_mu = 4.0 / 3 * mu, neo_lambda = lambda + 5.0 / 6 * mu, neo_rest = 1 + 0.75 * neo_mu / neo_lambda;

/// The nominal stress P = P I of F = s I, Pa, as the definitions of both laws have it.
double hydrostatic(Elasticity law, double s) {
  if (law == Elasticity::corotational) return 3 * bulk * (s - 1);
  return neo_mu * s * (1 - 1 / (3 * s * s + 1)) + neo_lambda * (s * s * s - neo_rest) * s * s;
}

/// The stretch at which a law answers a nominal pressure p (Pa), which acts on the area at rest.
double stretch_under(Elasticity law, double p) {
  double low = 0.9, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double s = 0.5 * (low + high);
    (hydrostatic(law, s) < -p ? low : high) = s;
  }
  return low;
}

/// Faces that one tetrahedron alone has, counter-clockwise as seen from outside.
std::vector<std::array<int, 3>> boundary(const TetMesh& mesh) {
  std::map<std::array<int, 3>, std::array<int, 3>> open;
  for (const auto& t : mesh.tets) {
    for (const auto& face : {std::array{t[0], t[2], t[1]}, std::array{t[0], t[1], t[3]}, std::array{t[1], t[2], t[3]},
                             std::array{t[0], t[3], t[2]}}) {
      std::array<int, 3> key = face;
      std::sort(key.begin(), key.end());
      if (open.erase(key) == 0) open[key] = face;
    }
  }
  std::vector<std::array<int, 3>> faces;
  for (const auto& [key, face] : open) faces.push_back(face);
  return faces;
}

/// N on the unknowns of linear elements: a pressure on the areas at rest, inwards.
Eigen::VectorXd pressed_on_all_sides(const ElasticModel& model, const TetMesh& mesh, double p) {
  Eigen::VectorXd f = Eigen::VectorXd::Zero(model.unknowns());
  for (const auto& face : boundary(mesh)) {
    const auto at = [&](std::size_t i) { return mesh.nodes[static_cast<std::size_t>(face[i])]; };
    const Eigen::Vector3d area = 0.5 * eigen(cross(at(1) - at(0), at(2) - at(0)));
    for (const int node : face) f.segment<3>(model.unknown_of(node)) -= p / 3 * area;
  }
  return f;
}

/// The deformation gradients of linear tetrahedra, with their volumes at rest.
struct Strained {
  std::vector<Eigen::Matrix3d> F;
  std::vector<double> volume;  // m^3
  double rest = 0, now = 0;    // m^3
  template <class Of>
  [[nodiscard]] double mean(const Of& of) const {
    double sum = 0;
    for (std::size_t i = 0; i < F.size(); ++i) sum += volume[i] * of(F[i]);
    return sum / rest;
  }
};

Strained strained(const ElasticModel& model, const Eigen::VectorXd& x) {
  Strained s;
  const Eigen::VectorXd& X = model.rest();
  for (const auto& t : model.bodies()[0].mesh.tets) {
    const auto edges = [&](const Eigen::VectorXd& of) {
      Eigen::Matrix3d D;
      for (int c = 0; c < 3; ++c) {
        D.col(c) = of.segment<3>(3 * t[static_cast<std::size_t>(c) + 1]) - of.segment<3>(3 * t[0]);
      }
      return D;
    };
    const Eigen::Matrix3d D0 = edges(X), D = edges(x);
    s.F.emplace_back(D * D0.inverse());
    s.volume.push_back(D0.determinant() / 6);
    s.rest += D0.determinant() / 6;
    s.now += D.determinant() / 6;
  }
  return s;
}

/// s_i - 1 of the singular values of F: the strain, of the corotational law.
Eigen::Vector3d strain(const Eigen::Matrix3d& F) {
  return F.jacobiSvd().singularValues().array() - 1;
}

/// P : F, Pa, of the definitions of both laws. Its mean over a body is -f . x / V, with the elastic forces f of all
/// nodes, because F is x's own gradient; a third of it is the mean stress.
double stress_by_strain(Elasticity law, const Eigen::Matrix3d& F) {
  if (law == Elasticity::corotational) {
    const Eigen::Vector3d E = strain(F);
    return 3 * bulk * E.sum() + 2 * mu * E.squaredNorm() + lambda * E.sum() * E.sum();
  }
  const double I = F.squaredNorm(), J = F.determinant();
  return neo_mu * I * (1 - 1 / (I + 1)) + 3 * neo_lambda * J * (J - neo_rest);
}

}  // namespace

BOOST_AUTO_TEST_CASE(pressure_on_all_sides_takes_the_volume_that_the_bulk_modulus_says) {
  const TetMesh mesh = box_of_tets(3, 2, 2, {0.03, 0.02, 0.02});
  for (const Elasticity law : {Elasticity::corotational, Elasticity::neo_hookean}) {
    const ElasticModel model({soft_body(mesh, young, poisson, [](const Vec3&) { return false; })}, law,
                             ElementOrder::linear);
    for (const double p : {1e-4 * bulk, 0.01 * bulk, 0.1 * bulk}) {
      const double s = stretch_under(law, p), lost = 1 - s * s * s;
      Eigen::VectorXd inner;
      model.force(s * model.rest(), inner);
      const Eigen::VectorXd outer = pressed_on_all_sides(model, mesh, p);
      BOOST_TEST((inner + outer).norm() < 1e-6 * outer.norm());
      BOOST_TEST(lost == p / bulk, tt::tolerance(0.02 + p / bulk));
    }
  }
}

// A block of 30 mm that is held at its bottom. By the corotational law
//   <P : F> / 3 = K <tr E> + (2 mu <|E|^2> + lambda <tr(E)^2>) / 3,   det F - 1 = tr E - |E|^2 / 2 + ...,
// so that strain takes volume beside pressure. The neo-Hookean law knows det F itself. 12 mm turn elements round by
// the corotational law, which is for less strain.
BOOST_AUTO_TEST_CASE(a_ball_pressed_in_deep_takes_no_more_volume_than_pressure_and_strain_explain) {
  for (const Elasticity law : {Elasticity::corotational, Elasticity::neo_hookean}) {
    Scene scene;
    scene.gravity_W = {};
    scene.bodies = {gel_box("gel", {0.06, 0.06, 0.03}, {0, 0, -0.015}, young, 0.01),
                    ball_tool(0.012, {0.001, 0.0007, 0.012}, 1e9)};
    hold_bottom(scene.bodies[0]);
    scene.bodies[0].deformable.poisson = poisson;
    scene.bodies[0].material.stiffness = 2e4;
    SoftRig rig(scene, {.law = law, .tolerance = 1e-9});
    // The same body that nothing holds: its forces are on all nodes, the held ones too.
    SoftBody loose = rig.model().bodies()[0];
    std::fill(loose.fixed.begin(), loose.fixed.end(), 0);
    const ElasticModel whole({loose}, law, ElementOrder::linear);
    std::vector<double> depths{0.004, 0.008};
    if (law == Elasticity::neo_hookean) depths.push_back(0.012);
    for (const double depth : depths) {
      StepResult result;
      for (const double short_of : {0.003, 0.002, 0.001, 0.0, 0.0, 0.0}) {
        rig.bodies.X_WB[0].p.z = 0.012 - depth + short_of;
        rig.bodies.V_WB[0] = {};
        result = rig.advance(10);
      }
      BOOST_TEST((result.outcome == StepOutcome::converged));
      const Strained s = strained(whole, rig.step->x());
      Eigen::VectorXd inner;
      whole.force(rig.step->x(), inner);
      const double work = -inner.dot(rig.step->x()) / s.rest, p = -work / 3, lost = 1 - s.now / s.rest;
      const double by_law = s.mean([law](const Eigen::Matrix3d& F) { return stress_by_strain(law, F); });
      const double squared = s.mean([](const Eigen::Matrix3d& F) { return strain(F).squaredNorm(); });
      BOOST_TEST_CONTEXT("neo-Hookean " << (law == Elasticity::neo_hookean) << ", depth " << depth) {
        BOOST_TEST_MESSAGE("depth " << depth << ", force " << result.contact_T_W.force.z << " N: lost " << 1e3 * lost
                                    << " per mille of the volume, pressure over bulk modulus " << 1e3 * p / bulk
                                    << ", half of the squared strain " << 500 * squared);
        BOOST_TEST(result.contact_T_W.force.z > 1);
        BOOST_TEST(p > 0);
        BOOST_TEST(by_law == work, tt::tolerance(1e-6));
        const double explained = p / bulk + (law == Elasticity::corotational ? 0.5 * squared : 0.0);
        BOOST_TEST(lost > 0);
        BOOST_TEST(lost < (law == Elasticity::corotational ? 1.1 : 1.4) * explained);
        BOOST_TEST(rig.model().smallest_volume_ratio(rig.step->x()) > 0.5);
      }
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
