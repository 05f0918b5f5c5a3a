// The patch of a result against dense condensation of the same matrices, in balance, in uniform motion, and as it goes
// on against the whole body.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "nodes/physics/deformable/condensation.hpp"
#include "nodes/physics/deformable/spread_nodes.hpp"
#include "nodes/physics/mechanics/patch_motion.hpp"
#include "tests/nodes/physics/deformable/soft_rig.hpp"

BOOST_AUTO_TEST_SUITE(condensation_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

constexpr double radius = 0.008;  // m

Scene ball_over_gel(double gap, double young, bool held = true, const Vec3& gravity = {}) {
  Scene scene;
  scene.gravity_W = gravity;
  scene.bodies = {gel_box("gel", {0.06, 0.06, 0.03}, {0, 0, -0.015}, young, 0.015),
                  ball_tool(radius, {0.002, 0.001, radius + gap}, 0.05)};
  if (held) hold_bottom(scene.bodies[0]);
  scene.bodies[0].deformable.damping = 0.004;
  scene.bodies[0].deformable.drag = 0.5;
  return scene;
}
const RigOptions few_nodes{.patch_nodes = 8, .patch_reach = 0.03};

/// A message as matrices over its free nodes.
struct Seen {
  int free = 0;
  std::vector<int> unknowns;  // of them, three each
  Eigen::MatrixXd V;          // modes as columns
  Eigen::VectorXd stiffness, damping, force, rate;
  [[nodiscard]] Eigen::MatrixXd M() const { return (V * V.transpose()).inverse(); }
  [[nodiscard]] Eigen::MatrixXd K() const { return M() * V * stiffness.asDiagonal() * V.transpose() * M(); }
};

Seen seen(const LocalPatch& patch, const SoftRig& rig) {
  Seen s;
  BOOST_REQUIRE(is_usable(patch));
  BOOST_REQUIRE(!patch.nodes.empty());
  for (std::size_t i = 0; i < patch.nodes.size(); ++i) {
    if (patch.nodes[i].fixed != 0) continue;
    // Nodes lie apart, so a place tells the node.
    int found = -1;
    for (const int node : rig.soft.surface_nodes) {
      if (SoftRig::at(rig.step->x(), node) == patch.nodes[i].p_W) found = node;
    }
    BOOST_REQUIRE(found >= 0);
    for (int c = 0; c < 3; ++c) s.unknowns.push_back(rig.model().unknown_of(found) + c);
    ++s.free;
  }
  const auto m = static_cast<Eigen::Index>(patch.modes.size());
  BOOST_REQUIRE(m >= 3 * s.free);
  const Eigen::Map<const Eigen::MatrixXd> all(patch.shapes.data(), static_cast<Eigen::Index>(3 * patch.nodes.size()),
                                              m);
  s.V = all.topRows(3 * s.free);
  for (Eigen::VectorXd* v : {&s.stiffness, &s.damping, &s.force, &s.rate}) v->resize(m);
  for (Eigen::Index i = 0; i < m; ++i) {
    const PatchMode& mode = patch.modes[static_cast<std::size_t>(i)];
    s.stiffness[i] = mode.stiffness;
    s.damping[i] = mode.damping;
    s.force[i] = mode.force;
    s.rate[i] = mode.rate;
  }
  return s;
}

/// The Schur complement of A on those unknowns.
Eigen::MatrixXd condensed(const Eigen::MatrixXd& A, const std::vector<int>& unknowns) {
  std::vector<int> others;
  for (int u = 0; u < A.rows(); ++u) {
    if (std::find(unknowns.begin(), unknowns.end(), u) == unknowns.end()) others.push_back(u);
  }
  const Eigen::MatrixXd C = A(others, unknowns);
  return A(unknowns, unknowns) - C.transpose() * Eigen::MatrixXd(A(others, others)).ldlt().solve(C);
}

/// N/m, the mean of the exact and the warped one.
Eigen::MatrixXd mean_stiffness(const SoftRig& rig) {
  Eigen::SparseMatrix<double> exact, warped;
  Eigen::VectorXd force;
  rig.model().assemble(rig.step->x(), ElasticModel::Tangent::exact, exact, force);
  rig.model().assemble(rig.step->x(), ElasticModel::Tangent::warped, warped, force);
  return 0.5 * (full(exact) + full(warped));
}

/// Phi^T M Phi with Phi what a unit displacement of each unknown moves: K^-1 S^T (S K^-1 S^T)^-1.
Eigen::MatrixXd guyan_mass(const Eigen::MatrixXd& K, const Eigen::MatrixXd& M, const std::vector<int>& unknowns) {
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(K.rows(), static_cast<Eigen::Index>(unknowns.size()));
  for (std::size_t i = 0; i < unknowns.size(); ++i) S(unknowns[i], static_cast<Eigen::Index>(i)) = 1;
  const Eigen::MatrixXd U = K.ldlt().solve(S);
  const Eigen::MatrixXd Phi = U * Eigen::MatrixXd(S.transpose() * U).inverse();
  return Phi.transpose() * M * Phi;
}

}  // namespace

BOOST_AUTO_TEST_CASE(stiffness_and_mass_are_those_of_dense_condensation) {
  for (const Integrator integrator : {Integrator::implicit_euler, Integrator::midpoint}) {
    for (const double young : {2e3, 2e4, 5e5}) {
      for (const double h : {0.002, 0.0167}) {
        RigOptions options = few_nodes;
        options.integrator = integrator;
        SoftRig rig(ball_over_gel(0.003, young), options);
        rig.advance(h);
        Condensation condensation(*rig.step, 4);
        rig.step->refresh(rig.bodies);
        const auto patch = condensation.condense();
        BOOST_REQUIRE(patch.has_value());
        const Seen s = seen(*patch, rig);
        const Eigen::MatrixXd K = mean_stiffness(rig), M = full(rig.model().mass());
        // Where Condensation takes its secant.
        const double fastest = K.trace() / M.trace(), s0 = 1e-7 * fastest, s1 = 1e-6 * fastest;
        const Eigen::MatrixXd static_K = condensed(K, s.unknowns), at_s0 = condensed(K + s0 * M, s.unknowns),
                              at_s1 = condensed(K + s1 * M, s.unknowns);
        const Eigen::MatrixXd Kr = s.K(), Mr = s.M();
        BOOST_TEST((Kr + s0 * Mr - at_s0).norm() < 1e-7 * at_s0.norm());
        BOOST_TEST((Kr + s1 * Mr - at_s1).norm() < 1e-7 * at_s1.norm());
        // Guyan's mass, by the displacements of all nodes that the patch's are in balance with.
        const Eigen::MatrixXd guyan = guyan_mass(K, M, s.unknowns);
        BOOST_TEST((Mr - guyan).norm() < 0.01 * guyan.norm());
        BOOST_TEST(Eigen::LLT<Eigen::MatrixXd>(Mr).info() == Eigen::Success);
        // The stiffness is that of statics but for s_0 times a mass no larger than the body's.
        BOOST_TEST((Kr - static_K).norm() < s0 * rig.mass() * std::sqrt(3.0));
        BOOST_TEST_MESSAGE("E " << young << ", h " << h << ": K_r off statics by "
                                << (Kr - static_K).norm() / static_K.norm());
        for (Eigen::Index i = 0; i < s.stiffness.size(); ++i) {
          BOOST_TEST(s.stiffness[i] > 0);
          BOOST_TEST(s.damping[i] == 0.5 + 0.004 * s.stiffness[i], tt::tolerance(1e-12));
        }
      }
    }
  }
}

namespace {

/// m/N, what forces on these unknowns do to them, at a harmonic motion of s = -w^2.
Eigen::MatrixXd compliance(const Eigen::MatrixXd& A, const std::vector<int>& unknowns) {
  return Eigen::MatrixXd(A.inverse())(unknowns, unknowns);
}
Eigen::MatrixXd told_compliance(const Seen& s, double at) {
  return s.V * (s.stiffness.array() + at).inverse().matrix().asDiagonal() * s.V.transpose();
}

}  // namespace

BOOST_AUTO_TEST_CASE(nodes_far_from_the_tool_bring_the_motion_of_the_whole_body) {
  for (const double young : {2e3, 2e4}) {
    // A motion of some 50 ms.
    const double s = std::pow(2 * std::numbers::pi / 0.05, 2);
    std::vector<double> off;
    for (const int far : {0, 4, 8}) {
      RigOptions options = few_nodes;
      options.far_nodes = far;
      SoftRig rig(ball_over_gel(0.003, young), options);
      rig.advance(0.0167);
      rig.step->refresh(rig.bodies);
      const Eigen::MatrixXd K = mean_stiffness(rig), M = full(rig.model().mass());
      const double fastest = K.trace() / M.trace(), s0 = 1e-7 * fastest, s1 = 1e-6 * fastest;
      Condensation condensation(*rig.step, 4);
      const auto patch = condensation.condense();
      BOOST_REQUIRE(patch.has_value());
      BOOST_TEST(patch->modes.size() == 3U * static_cast<std::size_t>(8 + far));
      const Seen told = seen(*patch, rig);
      BOOST_TEST(told.free == 8);
      // In balance they change nothing, and else all is as dense matrices over all masters have it.
      std::vector<int> masters = told.unknowns;
      const std::vector<int> spread = spread_nodes(rig.soft, far + 8).front();
      for (const int node : spread) {
        if (masters.size() == 3U * static_cast<std::size_t>(8 + far)) break;
        if (rig.step->patch().place_of(node) >= 0) continue;
        for (int c = 0; c < 3; ++c) masters.push_back(rig.model().unknown_of(node) + c);
      }
      const Eigen::MatrixXd K0 = condensed(K + s0 * M, masters), K1 = condensed(K + s1 * M, masters);
      const Eigen::MatrixXd Mr = (K1 - K0) / (s1 - s0), Kr = K0 - s0 * Mr;
      const Eigen::Index near = 24;
      for (const double at : {0.0, s}) {
        const Eigen::MatrixXd dense = (Kr + at * Mr).inverse().topLeftCorner(near, near);
        BOOST_TEST((told_compliance(told, at) - dense).norm() < 1e-6 * dense.norm());
      }
      const Eigen::MatrixXd exact = compliance(K + s * M, told.unknowns);
      off.push_back((told_compliance(told, s) - exact).norm() / exact.norm());
      BOOST_TEST_MESSAGE("E " << young << ", " << far << " far nodes: off by " << off.back());
    }
    BOOST_TEST(off[1] < 0.8 * off[0]);
    BOOST_TEST(off[2] < 0.65 * off[0]);
  }
}

BOOST_AUTO_TEST_CASE(the_mass_turns_with_the_body_and_is_made_anew_where_that_is_strained) {
  RigOptions options = few_nodes;
  options.far_nodes = 4;
  SoftRig rig(ball_over_gel(0.003, 2e4, false), options);
  rig.advance(0.001);
  Condensation condensation(*rig.step, 4);
  const auto at = [&](double angle) {
    Eigen::VectorXd x = rig.model().rest();
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    for (Eigen::Index i = 0; i < x.size(); i += 3) x.segment<3>(i) = turn * x.segment<3>(i);
    rig.step->place(x);
    rig.step->refresh(rig.bodies);
    BOOST_REQUIRE(condensation.condense().has_value());
    return condensation.factors();
  };
  // A mass that is kept still gives a body in uniform motion its velocity, nearly.
  const auto velocity_off = [&](double angle) {
    at(angle);
    Eigen::VectorXd v(rig.model().unknowns());
    const Eigen::Vector3d uniform(0.1, 0.2, -0.01);
    for (int u = 0; u < rig.model().unknowns(); u += 3) v.segment<3>(u) = uniform;
    rig.step->place(rig.step->x(), v);
    const auto patch = condensation.condense();
    BOOST_REQUIRE(patch.has_value());
    const Seen s = seen(*patch, rig);
    const Eigen::VectorXd told = s.V * s.rate;
    double worst = 0;
    for (int i = 0; i < s.free; ++i)
      worst = std::max(worst, (told.segment<3>(3 * i) - uniform).norm() / uniform.norm());
    BOOST_TEST_MESSAGE("turned by " << angle << ": velocity of the patch off by " << worst);
    return worst;
  };
  BOOST_TEST(at(0) == 2);
  BOOST_TEST(at(0) == 3);
  // It turns with the body.
  BOOST_TEST(at(0.05) == 4);
  for (const double angle : {0.2, 1.0, 3.0, 0.0}) BOOST_TEST(velocity_off(angle) < 1e-3);
  // Stretched a little, and much.
  const auto stretched = [&](double by) {
    Eigen::VectorXd x = rig.model().rest();
    for (Eigen::Index i = 0; i < x.size(); i += 3) x[i] *= 1 + by;
    rig.step->place(x);
    rig.step->refresh(rig.bodies);
    BOOST_REQUIRE(condensation.condense().has_value());
    return condensation.factors();
  };
  const std::int64_t before = at(0);
  BOOST_TEST(stretched(0.05) == before + 1);
  BOOST_TEST(stretched(0.2) == before + 3);
}

BOOST_AUTO_TEST_CASE(in_balance_the_patch_feels_what_its_contacts_push_and_stays_where_it_is) {
  Scene scene = ball_over_gel(0.0, 2e4, true, {0, 0, -9.81});
  scene.bodies[0].deformable.damping = 0.02;
  for (Body& body : scene.bodies) body.material.damping = 20;
  RigOptions options = few_nodes;
  options.patch_nodes = 12;
  SoftRig rig(scene, options);
  StepResult result;
  for (int i = 0; i < 400; ++i) result = rig.advance(0.0167);
  BOOST_TEST(result.contact_T_W.force.z == 0.05 * 9.81, tt::tolerance(1e-4));
  Condensation condensation(*rig.step, 4);
  rig.step->refresh(rig.bodies);
  const auto patch = condensation.condense();
  BOOST_REQUIRE(patch.has_value());
  const Seen s = seen(*patch, rig);
  Eigen::VectorXd inner;
  rig.model().force(rig.step->x(), inner);
  inner += rig.model().weight(scene.gravity_W);
  const Eigen::VectorXd on_patch = inner(s.unknowns);
  // All that is out of balance is where the ball pushes.
  BOOST_TEST(inner.norm() == on_patch.norm(), tt::tolerance(1e-4));
  BOOST_TEST((s.force - s.V.transpose() * on_patch).norm() < 1e-3 * s.force.norm());
  // With the contact's force held, it stays.
  PatchMotion motion(Integrator::implicit_euler);
  motion.restart(*patch);
  double moved = 0;
  for (int tick = 0; tick < 20; ++tick) {
    std::vector<SoftContact> contacts;
    for (int i = 0; i < s.free; ++i) {
      SoftContact c;
      c.node = {i, i, i};
      c.share = {1, 0, 0};
      contacts.push_back(c);
    }
    const std::array<Pose, 1> X_WB{};
    motion.begin(0.001, contacts, X_WB);
    for (int i = 0; i < s.free; ++i) {
      motion.motion().force.segment<3>(3 * contacts[static_cast<std::size_t>(i)].node[0]) = -on_patch.segment<3>(3 * i);
    }
    motion.end(0.001);
    for (std::size_t i = 0; i < patch->nodes.size(); ++i) {
      moved = std::max(moved, norm(motion.nodes_W()[i] - patch->nodes[i].p_W));
    }
  }
  BOOST_TEST_MESSAGE("in balance the patch moves by " << moved << " m in 20 ms");
  BOOST_TEST(moved < 1e-7);
}

BOOST_AUTO_TEST_CASE(a_patch_of_a_body_in_uniform_motion_has_its_velocity) {
  for (const double young : {1e3, 2e4, 1e6}) {
    for (const double h : {0.002, 0.0167}) {
      Scene scene = ball_over_gel(0.003, young, false);
      scene.bodies[0].deformable.drag = 0;
      SoftRig rig(scene, few_nodes);
      Eigen::VectorXd v(rig.model().unknowns());
      for (int u = 0; u < rig.model().unknowns(); u += 3) v.segment<3>(u) = Eigen::Vector3d(0.1, 0.2, -0.01);
      rig.start(Eigen::VectorXd::Zero(v.size()), v);
      rig.bodies.V_WB[0].v = {0.1, 0.2, -0.01};
      rig.advance(h);
      Condensation condensation(*rig.step, 4);
      rig.step->refresh(rig.bodies);
      const auto patch = condensation.condense();
      BOOST_REQUIRE(patch.has_value());
      const Seen s = seen(*patch, rig);
      const Eigen::VectorXd u = s.V * s.rate;
      double worst = 0;
      for (int i = 0; i < s.free; ++i) {
        worst = std::max(worst, (u.segment<3>(3 * i) - Eigen::Vector3d(0.1, 0.2, -0.01)).norm() / 0.2238);
      }
      BOOST_TEST_MESSAGE("E " << young << ", h " << h << ": velocity of the patch off by " << worst);
      BOOST_TEST(worst < 1e-3);
      BOOST_TEST(s.force.norm() < 1e-6);
    }
  }
}

namespace {

/// How far a patch that was let go is from the whole body over 20 ms, over how far that moves, at worst. The ball has
/// rested on the gel, or has come at `speed`, and is gone then.
double let_go(double young, double h, double speed, Integrator integrator) {
  RigOptions options{.integrator = integrator, .tolerance = 1e-8, .patch_nodes = 16, .patch_reach = 0.03};
  SoftRig rig(ball_over_gel(speed > 0 ? 0.0005 : 0.0, young, true, {0, 0, -9.81}), options);
  rig.bodies.V_WB[0].v = {0, 0, -speed};
  if (speed > 0) {
    for (int i = 0; i < 2; ++i) rig.advance(h);
  } else {
    for (int i = 0; i < 60; ++i) rig.advance(h);
  }
  Condensation condensation(*rig.step, 4);
  rig.step->refresh(rig.bodies);
  const auto patch = condensation.condense();
  BOOST_REQUIRE(patch.has_value());
  const Seen s = seen(*patch, rig);
  PatchMotion motion(integrator);
  motion.restart(*patch);
  rig.bodies.X_WB[0].p = {0, 0, 1};
  const Eigen::VectorXd before = rig.step->x();
  double worst = 0, most = 0;
  for (int tick = 0; tick < 20; ++tick) {
    rig.advance(0.001);
    motion.coast(0.001);
    int free = 0;
    for (std::size_t i = 0; i < patch->nodes.size(); ++i) {
      if (patch->nodes[i].fixed != 0) continue;
      const int node = rig.model().node_of(s.unknowns[static_cast<std::size_t>(3 * free++)]);
      const Vec3 now = SoftRig::at(rig.step->x(), node);
      worst = std::max(worst, norm(motion.nodes_W()[i] - now));
      most = std::max(most, norm(now - SoftRig::at(before, node)));
    }
  }
  BOOST_TEST_MESSAGE("E " << young << ", h " << h << ", speed " << speed << ": off by " << worst << " m of " << most);
  return worst / most;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_patch_goes_on_as_the_whole_body_does) {
  for (const Integrator integrator : {Integrator::implicit_euler, Integrator::midpoint}) {
    for (const double young : {1e4, 5e4}) {
      BOOST_TEST(let_go(young, 0.0167, 0, integrator) < 0.06);
      BOOST_TEST(let_go(young, 0.0167, 0.3, integrator) < 0.15);
      BOOST_TEST(let_go(young, 0.004, 0.3, integrator) < 0.2);
    }
  }
}

namespace {

constexpr double dampings[] = {0.002, 0.02}, drags[] = {0.5, 20};  // s, 1/s, of two bodies

/// Two blocks beside each other, mirror images but for what is told of them, and a ball over the gap. `only`: one of
/// the two alone.
Scene ball_over_two(double young, double other_young, std::optional<std::size_t> only = {}) {
  Scene scene;
  scene.gravity_W = {};
  for (const std::size_t b : {0U, 1U}) {
    if (only && *only != b) continue;
    Body gel = gel_box(b == 0 ? "left" : "right", {0.06, 0.06, 0.03}, {b == 0 ? -0.0325 : 0.0325, 0, -0.015},
                       b == 0 ? young : other_young, 0.015);
    hold_bottom(gel);
    gel.deformable.damping = dampings[b];
    gel.deformable.drag = drags[b];
    scene.bodies.push_back(gel);
  }
  scene.bodies.push_back(ball_tool(radius, {0, 0.001, radius + 0.003}, 0.05));
  return scene;
}
/// Half of the nodes are of either body.
RigOptions near_nodes(int count) {
  return {.patch_nodes = count, .patch_reach = 0.024};
}

}  // namespace

BOOST_AUTO_TEST_CASE(each_of_two_bodies_has_its_own_damping_in_the_patch) {
  // Equal ones have equal modes, which must not be mixed.
  for (const double other_young : {2e4, 2.0001e4, 5e4}) {
    for (const double h : {0.002, 0.0167}) {
      SoftRig rig(ball_over_two(2e4, other_young), near_nodes(16));
      rig.advance(h);
      rig.step->refresh(rig.bodies);
      Condensation condensation(*rig.step, 4);
      const auto patch = condensation.condense();
      BOOST_REQUIRE(patch.has_value());
      const Seen s = seen(*patch, rig);
      const Eigen::MatrixXd M = s.M(), K = s.K(), D = M * s.V * s.damping.asDiagonal() * s.V.transpose() * M;
      double worst = 0;
      std::array<int, 2> count{};
      for (Eigen::Index j = 0; j < D.cols(); ++j) {
        const auto b = static_cast<std::size_t>(rig.model().body_of(s.unknowns[static_cast<std::size_t>(j)]));
        ++count[b];
        const Eigen::VectorXd expected = drags[b] * M.col(j) + dampings[b] * K.col(j);
        worst = std::max(worst, (D.col(j) - expected).norm() / expected.norm());
      }
      BOOST_TEST_MESSAGE("E of the other " << other_young << ", h " << h << ": damping off by " << worst << ", of "
                                           << count[0] << " and " << count[1] << " unknowns");
      BOOST_TEST(count[0] == 24);
      BOOST_TEST(count[1] == 24);
      BOOST_TEST(worst < 1e-6);
    }
  }
}

BOOST_AUTO_TEST_CASE(two_bodies_go_on_in_one_patch_as_each_does_in_its_own) {
  // Both are thrown sideways and let go.
  for (const double other_young : {2e4, 5e4}) {
    constexpr double h = 0.0167, tick = 0.001;
    const auto thrown = [](SoftRig& rig) {
      Eigen::VectorXd v(rig.model().unknowns());
      for (int u = 0; u < rig.model().unknowns(); u += 3) v.segment<3>(u) = Eigen::Vector3d(0.3, 0.1, -0.2);
      rig.start(Eigen::VectorXd::Zero(v.size()), v);
      rig.advance(h);
      rig.step->refresh(rig.bodies);
    };
    SoftRig both(ball_over_two(2e4, other_young), near_nodes(16));
    thrown(both);
    Condensation of_both(*both.step, 4);
    const auto patch = of_both.condense();
    BOOST_REQUIRE(patch.has_value());
    BOOST_REQUIRE(is_usable(*patch));
    PatchMotion motion(Integrator::implicit_euler);
    motion.restart(*patch);
    for (int i = 0; i < 20; ++i) motion.coast(tick);
    double most = 0, worst = 0;
    int compared = 0;
    for (const std::size_t b : {0U, 1U}) {
      SoftRig alone(ball_over_two(2e4, other_young, b), near_nodes(8));
      thrown(alone);
      Condensation of_one(*alone.step, 4);
      const auto own = of_one.condense();
      BOOST_REQUIRE(own.has_value());
      PatchMotion its(Integrator::implicit_euler);
      its.restart(*own);
      for (int i = 0; i < 20; ++i) its.coast(tick);
      // Nodes lie apart, so a place tells the node.
      for (std::size_t i = 0; i < own->nodes.size(); ++i) {
        for (std::size_t k = 0; k < patch->nodes.size(); ++k) {
          if (patch->nodes[k].fixed != 0 || norm(patch->nodes[k].p_W - own->nodes[i].p_W) > 1e-6) continue;
          ++compared;
          most = std::max(most, norm(its.nodes_W()[i] - own->nodes[i].p_W));
          worst = std::max(worst, norm(its.nodes_W()[i] - motion.nodes_W()[k]));
        }
      }
    }
    BOOST_TEST_MESSAGE("E of the other " << other_young << ": off by " << worst << " m of " << most << ", " << compared
                                         << " nodes of " << patch->nodes.size());
    BOOST_TEST(compared == 16);
    BOOST_TEST(most > 1e-4);
    BOOST_TEST(worst < 1e-5 * most);  // how slow is slow goes by all bodies
  }
}

BOOST_AUTO_TEST_CASE(far_from_all_that_deforms_the_patch_is_empty) {
  SoftRig rig(ball_over_gel(0.5, 2e4), few_nodes);
  Condensation condensation(*rig.step, 4);
  // Before a step too.
  for (int i = 0; i < 2; ++i) {
    const auto patch = condensation.condense();
    BOOST_REQUIRE(patch.has_value());
    BOOST_TEST(patch->nodes.empty());
    rig.advance(0.01);
  }
}

BOOST_AUTO_TEST_SUITE_END()
