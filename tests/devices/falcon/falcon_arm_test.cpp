// The Falcon's geometry against Stamper's formulas, finite differences and the balance of power.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>

#include "devices/falcon/delta_arm.hpp"

BOOST_AUTO_TEST_SUITE(falcon_arm_test)

using namespace tactor;

namespace {

/// Stamper's inverse by half angles, as the thesis gives it (chapter 3), independent of the closed form under test.
double stamper_theta(const DeltaGeometry& g, int arm, const Vec3& p) {
  const double phi = g.phi[static_cast<std::size_t>(arm)];
  const double pu = std::cos(phi) * p.x + std::sin(phi) * p.y - g.r;
  const double pv = -std::sin(phi) * p.x + std::cos(phi) * p.y - g.s;
  const double pw = p.z;
  const double s3 = std::sin(std::acos((pv + g.f) / g.b));
  const double common = pw * pw + pu * pu + 2 * g.c * pu + g.a * g.a + g.c * g.c - g.d * g.d - g.e * g.e -
                        g.b * g.b * s3 * s3 - 2 * g.b * (g.e + g.d) * s3 - 2 * g.d * g.e;
  const double l0 = common - 2 * g.a * pu - 2 * g.a * g.c;
  const double l1 = -4 * g.a * pw;
  const double l2 = common + 2 * g.a * pu + 2 * g.a * g.c;
  return 2 * std::atan((-l1 - std::sqrt(l1 * l1 - 4 * l2 * l0)) / (2 * l2));
}

/// Points of a grid over the workspace that published metrics give the Falcon: a ball of 5 cm about (0, 0, 0.125).
template <class F>
void over_the_workspace(F&& check) {
  int points = 0;
  for (double x = -0.05; x <= 0.0501; x += 0.0125) {
    for (double y = -0.05; y <= 0.0501; y += 0.0125) {
      for (double z = 0.080; z <= 0.1651; z += 0.01) {
        if (norm(Vec3{x, y, z - 0.125}) > 0.05) continue;
        check(Vec3{x, y, z});
        ++points;
      }
    }
  }
  BOOST_TEST(points > 200);
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_inverse_is_that_of_stamper) {
  const DeltaGeometry geometry;
  const DeltaArm arm(geometry);
  over_the_workspace([&](const Vec3& p) {
    const auto theta = arm.inverse(p);
    BOOST_TEST_REQUIRE(theta.has_value());
    for (int i = 0; i < 3; ++i) {
      BOOST_TEST(std::abs((*theta)[static_cast<std::size_t>(i)] - stamper_theta(geometry, i, p)) < 1e-9);
    }
  });
}

BOOST_AUTO_TEST_CASE(forward_leads_back_to_where_the_inverse_came_from) {
  const DeltaArm arm;
  over_the_workspace([&](const Vec3& p) {
    const auto theta = arm.inverse(p);
    BOOST_TEST_REQUIRE(theta.has_value());
    const auto back = arm.forward(*theta);
    BOOST_TEST_REQUIRE(back.has_value());
    BOOST_TEST(norm(*back - p) < 1e-10);
  });
}

BOOST_AUTO_TEST_CASE(the_jacobian_is_the_slope_of_forward) {
  const DeltaArm arm;
  const double h = 1e-6;
  over_the_workspace([&](const Vec3& p) {
    const auto theta = *arm.inverse(p);
    const auto J = arm.jacobian(theta, p);
    BOOST_TEST_REQUIRE(J.has_value());
    for (std::size_t i = 0; i < 3; ++i) {
      auto more = theta, less = theta;
      more[i] += h;
      less[i] -= h;
      const Vec3 slope = (1 / (2 * h)) * (*arm.forward(more) - *arm.forward(less));
      BOOST_TEST(norm(slope - (*J)[i]) < 1e-6);
    }
  });
}

BOOST_AUTO_TEST_CASE(torques_do_the_work_of_the_force) {
  const DeltaArm arm;
  const Vec3 F{1.5, -2, 3};
  over_the_workspace([&](const Vec3& p) {
    const auto theta = *arm.inverse(p);
    const auto torque = arm.torques(theta, p, F);
    BOOST_TEST_REQUIRE(torque.has_value());
    const double d = 1e-6;
    for (const Vec3& step : {Vec3{d, 0, 0}, Vec3{0, d, 0}, Vec3{0, 0, d}, Vec3{d, -d, d}}) {
      const auto more = *arm.inverse(p + step), less = *arm.inverse(p - step);
      double work = 0;
      for (std::size_t i = 0; i < 3; ++i) work += (*torque)[i] * (more[i] - less[i]);
      BOOST_TEST(std::abs(work - 2 * dot(F, step)) < 1e-11);
    }
  });
}

BOOST_AUTO_TEST_CASE(a_force_along_z_loads_the_arms_alike_in_the_middle) {
  const DeltaArm arm;
  // By the threefold symmetry about z.
  const Vec3 p{0, 0, 0.125};
  const auto torque = *arm.torques(*arm.inverse(p), p, {0, 0, 3});
  BOOST_TEST(std::abs(torque[0] - torque[1]) < 1e-12);
  BOOST_TEST(std::abs(torque[1] - torque[2]) < 1e-12);
  BOOST_TEST(torque[0] > 0.01);
}

BOOST_AUTO_TEST_CASE(what_is_beyond_reach_is_nowhere) {
  const DeltaArm arm;
  BOOST_TEST(!arm.inverse({0, 0, 0.4}).has_value());
  BOOST_TEST(!arm.inverse({0.3, 0, 0.1}).has_value());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  BOOST_TEST(!arm.forward({nan, 0.6, 0.6}).has_value());
  BOOST_TEST(!arm.inverse({nan, 0, 0.1}).has_value());
}

BOOST_AUTO_TEST_CASE(every_count_gives_a_finite_place_or_none) {
  const DeltaArm arm;
  const double degree = std::numbers::pi / 180;
  for (int a = -3000; a <= 3000; a += 600) {
    for (int b = -3000; b <= 3000; b += 600) {
      for (int c = -3000; c <= 3000; c += 600) {
        const std::array<double, 3> theta{(35 + 0.03643 * a) * degree, (35 + 0.03643 * b) * degree,
                                          (35 + 0.03643 * c) * degree};
        const auto p = arm.forward(theta);
        if (!p) continue;
        BOOST_TEST(is_finite(*p));
        const auto torque = arm.torques(theta, *p, {1, 1, 1});
        if (!torque) continue;
        for (const double t : *torque) BOOST_TEST(std::isfinite(t));
      }
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
