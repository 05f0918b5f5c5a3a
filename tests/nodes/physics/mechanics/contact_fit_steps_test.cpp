// The fit of stiffness and friction against steps that RigidStep takes.
#include <boost/test/unit_test.hpp>

#include "nodes/physics/mechanics/rigid_step.hpp"
#include "tests/nodes/physics/mechanics/contact_fit_subject.hpp"
#include "tests/support/dice.hpp"

BOOST_AUTO_TEST_SUITE(contact_fit_steps_test)

using namespace tactor;
using namespace tactor::test;
using namespace tactor::test::contact_fit;
namespace tt = boost::test_tools;

namespace {

/// A body with six degrees of freedom that slides over random planes at random levers, moved by RigidStep.
struct Slide {
  LocalContacts model;  // as the fit gets it
  BodyStates after;
  Wrench wrench;
  int touching = 0;
  Twist acceleration;
};

/// `law`: of which inertia, creep and lift count.
Slide slide(Dice& dice, double scale, double excess, double length, const Pose& world, const Contact& law = {}) {
  SystemModel system;
  system.body[0].mass = 0.1;
  system.body[0].inertia_B = 4e-2 * length * length * Eigen::Matrix3d::Identity();
  system.gravity_W = rotate(world.R, {0, 0, -9.81});
  system.stick_velocity = stick;
  Slide s;
  BodyStates bodies = one_body(world.p, rotate(world.R, dice.in_cube(0.3)));
  bodies.X_WB[0].R = world.R;
  s.model.anchors = 1;
  s.model.bodies = 1;
  s.model.count = 6;
  s.model.X_WB[0] = bodies.X_WB;
  LocalContacts truth = s.model;
  for (std::size_t i = 0; i < 6; ++i) {
    Contact& c = s.model.contact[i][0];
    const Vec3 n = dice.in_cube(0.5) + Vec3{0, 0, 1};
    c.n_W = rotate(world.R, (1 / norm(n)) * n);
    c.p_TC = length * dice.in_cube(1);
    c.distance = dice(-1e-3, -2e-4);
    c.weight = dice(0.5, 1);
    c.stiffness = k;
    c.damping = b;
    c.friction = 0.3;
    c.inertia = law.inertia;
    c.creep = law.creep;
    c.lift = law.lift;
    truth.contact[i][0] = c;
    truth.contact[i][0].stiffness *= scale;
    truth.contact[i][0].damping *= scale;
    truth.contact[i][0].inertia *= scale;
    truth.contact[i][0].friction += excess;
  }
  RigidStep step(system);
  std::array<Contact, 6> planes;
  std::array<ContactPair, 6> pairs;
  for (std::size_t i = 0; i < 6; ++i) planes[i] = truth.contact[i][0];
  DeviceState handle;
  handle.X_WD = bodies.X_WB[0];
  handle.V_WD = bodies.V_WB[0];
  const CouplingParameters spring{.k_t = 500, .b_t = 14, .k_r = 1, .b_r = 0.01, .force_max = 8, .torque_max = 0.3};
  const std::span<const Pose> at(s.model.X_WB[0].data(), 1);
  s.after = bodies;
  const StepResult result = step.advance(spring, handle, handle, {at, planes, pairs}, 1e-4, s.after);
  BOOST_REQUIRE((result.outcome == StepOutcome::converged));
  s.wrench = result.contact_T_W;
  s.touching = result.touching;
  const Twist &from = bodies.V_WB[0], &to = s.after.V_WB[0];
  s.acceleration = {1e4 * (to.v - from.v), 1e4 * (to.w - from.w)};
  return s;
}

}  // namespace

BOOST_AUTO_TEST_CASE(steps_of_a_body_that_slides_over_many_planes_give_its_material_back) {
  for (const double length : {0.01, 1.0}) {
    for (const double scale : {0.5, 1.0, 2.0}) {
      for (const double excess : {-0.3, 0.0, 0.3}) {
        Dice dice(7);
        Subject subject(true);
        for (int i = 0; i < 10; ++i) {
          const Slide s = slide(dice, scale, excess, length, dice.pose(1, 3));
          BOOST_REQUIRE((subject.take(s.model, s.after, s.wrench, s.touching) == FitOutcome::used));
        }
        BOOST_TEST(subject.scale() == scale, tt::tolerance(0.03));
        BOOST_TEST(std::abs(subject.excess() - excess) < 0.03);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(contacts_that_tell_inertia_and_lift_give_their_stiffness_back_by_the_acceleration) {
  for (const double scale : {0.5, 1.0, 2.0}) {
    Dice dice(9);
    ContactFit knows(true, stick), guesses(true, stick);
    for (int i = 0; i < 10; ++i) {
      const Slide s = slide(dice, scale, 0, 0.02, dice.pose(1, 3), {.inertia = 0.3, .creep = 0.01, .lift = 1});
      const Time at{20'000'000LL * (i + 1)};
      knows.take(at, s.model, s.after, false, s.wrench, s.touching, s.acceleration);
      guesses.take(at, s.model, s.after, false, s.wrench, s.touching);
    }
    BOOST_TEST(knows.error().stiffness_scale == scale, tt::tolerance(0.03));
    BOOST_TEST(std::abs(knows.error().friction_excess) < 0.03);
    BOOST_TEST(knows.law_error() < guesses.law_error());
  }
}

BOOST_AUTO_TEST_CASE(where_the_world_lies_changes_nothing) {
  Dice dice(8);
  Subject here(true), there(true);
  for (int i = 0; i < 10; ++i) {
    Dice same_here(static_cast<std::uint64_t>(i)), same_there(static_cast<std::uint64_t>(i));
    const Slide x = slide(same_here, 2, 0.1, 0.02, {}), y = slide(same_there, 2, 0.1, 0.02, dice.pose(0.1, 3));
    here.take(x.model, x.after, x.wrench, x.touching);
    there.take(y.model, y.after, y.wrench, y.touching);
    BOOST_TEST(std::abs(here.scale() - there.scale()) < 1e-4);
    BOOST_TEST(std::abs(here.excess() - there.excess()) < 1e-4);
  }
}

BOOST_AUTO_TEST_SUITE_END()
