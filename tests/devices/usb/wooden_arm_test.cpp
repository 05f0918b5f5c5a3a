// The geometry of WoodenHaptics against its inverse, finite differences and the balance of power.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>

#include "devices/usb/wooden_arm.hpp"

BOOST_AUTO_TEST_SUITE(wooden_arm_test)

using namespace tactor;

namespace {

template <class F>
void over_the_workspace(F&& check) {
  int points = 0;
  for (double x = -0.08; x <= 0.0801; x += 0.02) {
    for (double y = -0.08; y <= 0.0801; y += 0.02) {
      for (double z = -0.08; z <= 0.0801; z += 0.02) {
        if (norm(Vec3{x, y, z}) > 0.09) continue;
        check(Vec3{x, y, z});
        ++points;
      }
    }
  }
  BOOST_TEST(points > 200);
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_pose_of_calibration_is_where_a_ruler_finds_it) {
  // Upper link upright, lower link level and straight ahead.
  const Vec3 p = WoodenArm().forward({0, 0, std::numbers::pi / 2});
  BOOST_TEST(norm(p - Vec3{0.133 - 0.140, 0, 0.058 + 0.174 - 0.100}) < 1e-15);
}

BOOST_AUTO_TEST_CASE(a_turned_base_turns_the_handle_about_z) {
  const WoodenGeometry g;
  const WoodenArm arm(g);
  const Vec3 straight = arm.forward({0, 0.3, 1.2}) + g.O;
  const Vec3 turned = arm.forward({0.7, 0.3, 1.2}) + g.O;
  BOOST_TEST(norm(rotate(from_rotation_vector({0, 0, 0.7}), straight) - turned) < 1e-15);
}

BOOST_AUTO_TEST_CASE(forward_leads_back_to_where_the_inverse_came_from) {
  const WoodenArm arm;
  over_the_workspace([&](const Vec3& p) {
    const auto q = arm.inverse(p);
    BOOST_TEST_REQUIRE(q.has_value());
    BOOST_TEST(norm(arm.forward(*q) - p) < 1e-12);
  });
  BOOST_TEST(!arm.inverse({1, 0, 0}).has_value());
}

BOOST_AUTO_TEST_CASE(the_jacobian_is_the_slope_of_forward) {
  const WoodenArm arm;
  const double h = 1e-6;
  over_the_workspace([&](const Vec3& p) {
    const auto q = *arm.inverse(p);
    const auto J = arm.jacobian(q);
    for (std::size_t i = 0; i < 3; ++i) {
      auto more = q, less = q;
      more[i] += h;
      less[i] -= h;
      BOOST_TEST(norm((1 / (2 * h)) * (arm.forward(more) - arm.forward(less)) - J[i]) < 1e-9);
    }
  });
}

BOOST_AUTO_TEST_CASE(torques_do_the_work_of_the_force) {
  const WoodenArm arm;
  const Vec3 F{2, -1, 3};
  const double d = 1e-6;
  over_the_workspace([&](const Vec3& p) {
    const auto J = arm.jacobian(*arm.inverse(p));
    for (const Vec3& step : {Vec3{d, 0, 0}, Vec3{0, d, 0}, Vec3{0, 0, d}}) {
      const auto more = *arm.inverse(p + step), less = *arm.inverse(p - step);
      double work = 0;
      for (std::size_t i = 0; i < 3; ++i) work += dot(J[i], F) * (more[i] - less[i]);
      BOOST_TEST(std::abs(work - 2 * dot(F, step)) < 1e-11);
    }
  });
}

BOOST_AUTO_TEST_SUITE_END()
