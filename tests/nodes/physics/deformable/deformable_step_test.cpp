// Steps of deformable bodies against mechanics: momentum, free fall, energy, and how the error falls with the step.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/Geometry>

#include "tests/nodes/physics/deformable/soft_rig.hpp"

BOOST_AUTO_TEST_SUITE(deformable_step_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

constexpr std::array both_integrators{Integrator::implicit_euler, Integrator::midpoint};
constexpr std::array both_laws{Elasticity::corotational, Elasticity::neo_hookean};

const char* name(Integrator integrator) {
  return integrator == Integrator::midpoint ? "midpoint" : "implicit Euler";
}
const char* name(Elasticity law) {
  return law == Elasticity::corotational ? "corotational" : "neo-Hookean";
}

/// A box of 40 mm in cells of 20 mm, free or held at its bottom, far from the tool.
Scene lone_box(double young, bool held, const Vec3& gravity = {}) {
  Scene scene;
  scene.gravity_W = gravity;
  scene.bodies = {gel_box("gel", {0.04, 0.04, 0.04}, {}, young, 0.02), far_tool()};
  if (held) hold_bottom(scene.bodies[0]);
  return scene;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_body_that_nothing_holds_keeps_its_momentum) {
  for (const Integrator integrator : both_integrators) {
    for (const Elasticity law : both_laws) {
      for (const double damping : {0.0, 0.005}) {
        Scene scene = lone_box(2e4, false);
        scene.bodies[0].deformable.damping = damping;
        SoftRig rig(scene, {.law = law, .integrator = integrator});
        Noise noise;
        const Eigen::VectorXd u = 0.001 * noise.vector(rig.model().unknowns());
        rig.start(u, 0.3 * noise.vector(rig.model().unknowns()) + Eigen::VectorXd::Constant(u.size(), 0.1));
        const Eigen::Vector3d before = rig.momentum();
        double worst = 0;
        for (int i = 0; i < 40; ++i) {
          rig.advance(0.01);
          worst = std::max(worst, (rig.momentum() - before).norm() / before.norm());
        }
        BOOST_TEST_CONTEXT(name(integrator) << ", " << name(law) << ", damping " << damping) {
          BOOST_TEST_MESSAGE(name(integrator) << ", " << name(law) << ", damping " << damping << ": momentum off by "
                                              << worst << ", damped " << rig.step->counts().damped);
          BOOST_TEST(rig.step->counts().damped == 0);
          BOOST_TEST(worst < 1e-7);
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_falling_body_goes_where_the_integrator_says) {
  // Euler: z_n = -g h^2 n (n + 1) / 2. Midpoint: z_n = -g (n h)^2 / 2. Drag d: v' = (v - h g) / (1 + h d).
  constexpr double g = 9.81, h = 0.01;
  for (const Integrator integrator : both_integrators) {
    for (const double drag : {0.0, 3.0}) {
      Scene scene = lone_box(2e4, false, {0, 0, -g});
      scene.bodies[0].deformable.drag = drag;
      SoftRig rig(scene, {.integrator = integrator});
      double z = rig.centre().z(), v = 0;
      for (int i = 0; i < 30; ++i) {
        rig.advance(h);
        const bool midpoint = integrator == Integrator::midpoint;
        const double solved = midpoint ? h / 2 : h, after = (v - solved * g) / (1 + solved * drag);
        z += h * after;
        v = midpoint ? 2 * after - v : after;
        BOOST_TEST(std::abs(rig.centre().z() - z) < 1e-9);
      }
      BOOST_TEST(rig.step->counts().damped == 0);
    }
  }
}

namespace {

/// Energy of a strained box that is let go, over so many steps. `usual`: by the options that graphs have if they say
/// nothing.
void check_energy(int steps, bool usual) {
  for (const Integrator integrator : both_integrators) {
    for (const Elasticity law : both_laws) {
      for (const double young : {1e3, 1e5, 1e7}) {
        for (const double h : {0.001, 0.005, 0.02, 0.05}) {
          SoftRig rig(lone_box(young, true), {.law = law,
                                              .integrator = integrator,
                                              .iterations = usual ? 8 : 30,
                                              .tolerance = usual ? 1e-3 : 1e-6,
                                              .reuse = usual});
          Noise noise;
          rig.start(0.004 * noise.vector(rig.model().unknowns()), Eigen::VectorXd::Zero(rig.model().unknowns()));
          const double begin = rig.step->energy();
          double last = begin, worst = 0, most = 0;
          for (int i = 0; i < steps; ++i) {
            rig.advance(h);
            const double now = rig.step->energy();
            most = std::max(most, now / begin);
            worst = std::max(worst, (now - last) / begin);
            last = now;
          }
          BOOST_TEST_CONTEXT(name(integrator) << ", " << name(law) << ", E " << young << ", h " << h) {
            BOOST_TEST_MESSAGE(name(integrator)
                               << ", " << name(law) << ", E " << young << ", h " << h << ": grew by " << worst
                               << ", left " << last / begin << ", damped " << rig.step->counts().damped << ", by Euler "
                               << rig.step->counts().by_euler);
            BOOST_TEST(worst < (integrator == Integrator::midpoint ? 0.02 : 1e-9));
            BOOST_TEST(most <= 1 + 1e-9);
          }
        }
      }
    }
  }
}

}  // namespace

BOOST_AUTO_TEST_CASE(energy_never_grows) {
  check_energy(100, false);
}

BOOST_AUTO_TEST_CASE(energy_never_grows_by_the_usual_options) {
  check_energy(100, true);
}

// Takes minutes; see docs/trust/testing.md.
BOOST_AUTO_TEST_CASE(energy_never_grows_in_ten_thousand_steps,
                     *boost::unit_test::disabled() * boost::unit_test::label("minutes")) {
  for (const bool usual : {false, true}) check_energy(10'000, usual);
}

BOOST_AUTO_TEST_CASE(damping_does_not_brake_a_body_that_turns) {
  // Half a turn and more, with factors of earlier steps.
  for (const Integrator integrator : both_integrators) {
    std::array<double, 2> left{};
    for (const double damping : {0.0, 0.01}) {
      Scene scene = lone_box(1e5, false);
      scene.bodies[0].deformable.damping = damping;
      SoftRig rig(scene, {.integrator = integrator, .tolerance = 1e-6, .reuse = true});
      const Eigen::Vector3d w(0, 0, 8);
      Eigen::VectorXd v(rig.model().unknowns());
      const auto place = [&](int u) -> Eigen::Vector3d { return rig.step->x().segment<3>(3 * rig.model().node_of(u)); };
      for (int u = 0; u < v.size(); u += 3) v.segment<3>(u) = w.cross(place(u));
      rig.start(Eigen::VectorXd::Zero(v.size()), v);
      const auto spin = [&] {
        const Eigen::VectorXd p = rig.model().mass().selfadjointView<Eigen::Lower>() * rig.step->v();
        double sum = 0;
        for (int u = 0; u < p.size(); u += 3) sum += place(u).cross(Eigen::Vector3d(p.segment<3>(u))).z();
        return sum;
      };
      const double before = spin();
      for (int i = 0; i < 250; ++i) rig.advance(0.002);
      left[damping > 0 ? 1 : 0] = spin() / before;
    }
    BOOST_TEST_MESSAGE(name(integrator) << ": spin left " << left[0] << " without damping, " << left[1] << " with");
    BOOST_TEST(left[1] > left[0] - 0.02);
  }
}

namespace {

/// A box that swings and turns at its free end by some tenths of a radian.
struct Swing {
  Eigen::VectorXd x;  // m, less where it was at rest
  DeformableCounts counts;
  double worth = 0;  // iterations, of a factor
};
Swing swing(double edge, bool reuse, int iterations = 30) {
  Scene scene = lone_box(2e3, true);
  scene.bodies[0].deformable.cell_size = edge;
  SoftRig rig(scene, {.iterations = iterations, .tolerance = 1e-7, .reuse = reuse});
  Eigen::VectorXd v(rig.model().unknowns());
  for (int u = 0; u < rig.model().unknowns(); u += 3) {
    const Eigen::Vector3d p = rig.model().rest().segment<3>(3 * rig.model().node_of(u));
    v.segment<3>(u) = Eigen::Vector3d(0.5, -6 * p.x(), 6 * p.y()) * (p.z() + 0.02) / 0.04;
  }
  rig.start(Eigen::VectorXd::Zero(v.size()), v);
  for (int i = 0; i < 12; ++i) {
    // As samples of a handle come, steps are not all of one length.
    rig.advance(i % 3 == 0 ? 0.0085 : 0.008);
  }
  return {rig.step->x() - rig.model().rest(), rig.step->counts(), rig.step->iterations_a_factor_is_worth()};
}

}  // namespace

BOOST_AUTO_TEST_CASE(factors_that_learn_change_no_result_and_are_worth_more_iterations_of_large_bodies) {
  std::array<double, 2> worth{};
  for (const bool large : {false, true}) {
    const double edge = large ? 0.005 : 0.02;
    const Swing fresh = swing(edge, false), old = swing(edge, true);
    const double off = (old.x - fresh.x).norm() / fresh.x.norm();
    worth[large ? 1 : 0] = old.worth;
    BOOST_TEST_MESSAGE("edge " << edge << ": " << old.counts.factors << " factors and " << old.counts.updates
                               << " updates in " << old.counts.iterations << " iterations, for " << fresh.counts.factors
                               << " in " << fresh.counts.iterations << "; off by " << off);
    BOOST_TEST(off < 1e-5);
    BOOST_TEST(old.counts.damped == 0);
    BOOST_TEST(fresh.counts.damped == 0);
    BOOST_TEST(fresh.counts.updates == 0);
    BOOST_TEST(fresh.counts.factors >= fresh.counts.steps);
    BOOST_TEST(old.counts.updates > 0);
    BOOST_TEST(old.counts.factors < fresh.counts.factors);
  }
  // A block of 48 tetrahedra is factored anew after one lost iteration or two.
  BOOST_TEST_MESSAGE("worth " << worth[0] << ", " << worth[1]);
  BOOST_TEST(worth[0] < 2);
  BOOST_TEST(worth[1] > 2 * worth[0]);
}

BOOST_AUTO_TEST_CASE(where_the_iterations_left_would_not_do_it_factors_anew) {
  // Few iterations, to a tolerance that an old factor does not reach in them.
  const Swing many = swing(0.01, true), few = swing(0.01, true, 6);
  BOOST_TEST_MESSAGE("factors " << many.counts.factors << ", of 6 iterations " << few.counts.factors);
  BOOST_TEST(few.counts.factors > many.counts.factors);
  BOOST_TEST((few.x - many.x).norm() < 1e-5 * many.x.norm());
}

BOOST_AUTO_TEST_CASE(steps_with_factors_that_learn_are_the_same_each_time) {
  const Swing once = swing(0.01, true), again = swing(0.01, true);
  BOOST_TEST((once.x - again.x).norm() == 0);
  BOOST_TEST(once.counts.factors == again.counts.factors);
  BOOST_TEST(once.counts.updates == again.counts.updates);
}

namespace {

/// How far the box has moved after 40 ms in n steps, by all nodes.
Eigen::VectorXd swung(Integrator integrator, Elasticity law, int n) {
  SoftRig rig(lone_box(2e3, true), {.law = law, .integrator = integrator});
  Eigen::VectorXd v(rig.model().unknowns());
  for (int u = 0; u < rig.model().unknowns(); u += 3) {
    v.segment<3>(u) =
        Eigen::Vector3d(0.1, 0.03, -0.05) * (rig.model().rest()[3 * rig.model().node_of(u) + 2] + 0.02) / 0.04;
  }
  rig.start(Eigen::VectorXd::Zero(v.size()), v);
  for (int i = 0; i < n; ++i) rig.advance(0.04 / n);
  return rig.step->x();
}

}  // namespace

BOOST_AUTO_TEST_CASE(euler_is_of_first_order_and_the_midpoint_rule_of_second) {
  for (const Elasticity law : both_laws) {
    for (const Integrator integrator : both_integrators) {
      const Eigen::VectorXd fine = swung(Integrator::midpoint, law, 2560);
      const double coarse = (swung(integrator, law, 160) - fine).norm(),
                   half = (swung(integrator, law, 320) - fine).norm();
      const double order = std::log2(coarse / half);
      BOOST_TEST_MESSAGE(name(integrator) << ", " << name(law) << ": order " << order);
      BOOST_TEST(std::abs(order - (integrator == Integrator::midpoint ? 2 : 1)) < 0.15);
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
