// Two masses with a spring and play between them move as the closed forms say.
#include "devices/simulated/transmission.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>

#include "devices/simulated/handle.hpp"
#include "devices/simulated/mass_chain.hpp"
#include "tests/devices/simulated/stored_energy.hpp"

BOOST_AUTO_TEST_SUITE(transmission_test)

using namespace tactor;

namespace {

constexpr double pi = std::numbers::pi;
constexpr double h = 1e-4;
const Friction no_friction({});
const Cogging no_cogging({});
const HandleParameters free_body{.inertia = 0.5};

/// 60 g on the motor side, 40 g at the handle.
constexpr double m_1 = 0.06, m_2 = 0.04, mass = m_1 + m_2, reduced = m_1 * m_2 / mass;

MassChain<2>::Parameters free_masses(double frequency, double zeta, double backlash = 0) {
  const TransmissionParameters link = transmission_of(mass, 0.6, frequency, zeta, backlash);
  return {.mass = {m_1, m_2}, .link = {{{link.stiffness, link.damping}}}, .half_gap = link.half_gap};
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_free_masses_swing_with_the_given_frequency_and_damping_ratio) {
  const double frequency = 70;
  for (const double zeta : {0.0, 0.03, 0.4}) {
    MassChain<2> link(free_masses(frequency, zeta), no_friction, no_cogging);
    MassChain<2>::Points points{PointState{}, PointState{{1e-3, 0, 0}, {}}};
    const auto& [motor, handle] = points;
    const double omega = 2 * pi * frequency, damped = omega * std::sqrt(1 - zeta * zeta);
    for (int i = 1; i <= 2000; ++i) {
      link.advance(h, {}, {}, points);
      const double t = i * h;
      const double d =
          1e-3 * std::exp(-zeta * omega * t) * (std::cos(damped * t) + zeta * omega / damped * std::sin(damped * t));
      BOOST_REQUIRE(std::abs(handle.p.x - motor.p.x - d) < 1e-13);
      // Nothing moves what both weigh together.
      BOOST_REQUIRE(std::abs(m_1 * motor.p.x + m_2 * handle.p.x - m_2 * 1e-3) < 1e-15);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_force_accelerates_both_masses_together_and_bends_the_spring_by_its_share) {
  MassChain<2> link(free_masses(200, 0.5), no_friction, no_cogging);
  MassChain<2>::Points points;
  const auto& [motor, handle] = points;
  const double force = 1.5;
  for (int i = 1; i <= 3000; ++i) link.advance(h, {0, force, 0}, {}, points);
  const double t = 3000 * h, centre = (m_1 * motor.p.y + m_2 * handle.p.y) / mass;
  BOOST_TEST(std::abs(centre - 0.5 * force / mass * t * t) < 1e-11);
  // The spring accelerates the handle: k d = -F m_2 / M, with d = x_2 - x_1.
  const double k = free_masses(200, 0.5).link[0].stiffness;
  BOOST_TEST(std::abs(k * (handle.p.y - motor.p.y) + force * m_2 / mass) < 1e-9);
}

BOOST_AUTO_TEST_CASE(a_very_stiff_transmission_moves_as_one_body) {
  const HandleParameters hand{
      .inertia = 0.65, .damping = 0.2, .coulomb = 0.05, .hand_damping = 6.5, .hand_stiffness = 135};
  Handle one(hand, free_body, h, false);
  Handle two(hand, free_body, h, false, {.transmission = transmission_of(0.1, 0.5, 5000, 0.5, 0)});
  for (int i = 0; i < 2000; ++i) {
    const Wrench u{{i % 700 < 350 ? 1.0 : -0.5, 0.2, 0}, {}};
    one.advance(1e-3, u, {}, {});
    two.advance(1e-3, u, {}, {});
    BOOST_REQUIRE(norm(one.state().X.p - two.state().X.p) < 3e-6);
  }
}

BOOST_AUTO_TEST_CASE(within_the_play_the_motors_move_alone_and_the_handle_feels_nothing) {
  const double gap = 1e-3, force = 0.05;
  MassChain<2> link(free_masses(150, 0.0, gap), no_friction, no_cogging);
  MassChain<2>::Points points;
  const auto& [motor, handle] = points;
  const double contact = std::sqrt(m_1 * gap / force);  // 1/2 F/m_1 t^2 = gap / 2
  int i = 1;
  for (; i * h < contact; ++i) {
    link.advance(h, {0, 0, force}, {}, points);
    BOOST_TEST(std::abs(motor.p.z - 0.5 * force / m_1 * i * h * i * h) < 1e-15);
    BOOST_TEST((handle.p == Vec3{} && handle.v == Vec3{}));
    BOOST_TEST((link.link_force(motor, handle) == Vec3{}));
  }
  // Then the spring is pressed: mu r'' = -k r - F mu / m_1 with r = d + gap/2, from r = 0 with -v of the motor.
  const double omega = 2 * pi * 150, speed = force / m_1 * contact;
  const double rest = -force / (m_1 * omega * omega);
  for (; i * h < contact + 0.9 * pi / omega; ++i) {
    link.advance(h, {0, 0, force}, {}, points);
    const double t = i * h - contact;
    const double r = rest - rest * std::cos(omega * t) - speed / omega * std::sin(omega * t);
    BOOST_TEST(std::abs(handle.p.z - motor.p.z - (r - gap / 2)) < 1e-7);
    BOOST_TEST(handle.v.z > 0);
  }
}

BOOST_AUTO_TEST_CASE(two_masses_with_play_bounce_in_the_period_of_free_flight_and_contact) {
  const double gap = 2e-3, frequency = 300, speed = 0.5;
  MassChain<2> link(free_masses(frequency, 0.0, gap), no_friction, no_cogging);
  MassChain<2>::Points points{PointState{{}, {speed * m_2 / mass, 0, 0}}, PointState{{}, {-speed * m_1 / mass, 0, 0}}};
  const auto& [motor, handle] = points;
  // A flight across the gap at each way, and half a swing at each end.
  const double period = 2 * (gap / speed + 0.5 / frequency);
  const double energy = 0.5 * reduced * speed * speed;
  double before = 0;
  int crossings = 0;
  double first = 0, last = 0;
  for (int i = 1; i <= 20000; ++i) {
    link.advance(h, {}, {}, points);
    const double d = handle.p.x - motor.p.x;
    if (before < 0 && d >= 0) {
      last = i * h - h * d / (d - before);
      if (crossings++ == 0) first = last;
    }
    before = d;
    const double bent = std::max(std::abs(d) - gap / 2, 0.0);
    const double now = 0.5 * m_1 * motor.v.x * motor.v.x + 0.5 * m_2 * handle.v.x * handle.v.x +
                       0.5 * free_masses(frequency, 0).link[0].stiffness * bent * bent;
    BOOST_REQUIRE(std::abs(now / energy - 1) < 2e-3);
    BOOST_REQUIRE(std::abs(m_1 * motor.v.x + m_2 * handle.v.x) < 1e-13);
  }
  BOOST_REQUIRE(crossings > 100);
  BOOST_TEST(std::abs((last - first) / (crossings - 1) / period - 1) < 1e-3);
}

BOOST_AUTO_TEST_CASE(motors_held_by_friction_leave_the_handle_swinging_on_the_spring) {
  const Friction friction({.coulomb = 5});
  const double frequency = 50;
  MassChain<2> link(free_masses(frequency, 0.0), friction, no_cogging);
  MassChain<2>::Points points{PointState{}, PointState{{1e-3, 0, 0}, {}}};
  const auto& [motor, handle] = points;
  const double omega = std::sqrt(free_masses(frequency, 0).link[0].stiffness / m_2);
  for (int i = 1; i <= 5000; ++i) {
    link.advance(h, {1, 0, 0}, {}, points);
    BOOST_REQUIRE((motor.p == Vec3{}));
    BOOST_REQUIRE(std::abs(handle.p.x - 1e-3 * std::cos(omega * i * h)) < 1e-12);
  }
}

BOOST_AUTO_TEST_CASE(play_hides_small_motions_of_the_handle_from_the_encoders) {
  // A hand moves the handle to and fro within the gap, while friction holds the motors.
  const HandleParameters hand{.inertia = 0.65, .coulomb = 0.1, .hand_damping = 6.5, .hand_stiffness = 2000};
  Handle handle(hand, free_body, h, false, {.transmission = transmission_of(0.1, 0.5, 200, 0.1, 2e-3)});
  double farthest = 0;
  for (int i = 0; i < 1000; ++i) {
    const auto target = [](double t) {
      return MotionState{{{5e-4 * std::sin(6 * t), 0, 0}, {}}, {{3e-3 * std::cos(6 * t), 0, 0}, {}}};
    };
    handle.advance(1e-3, {}, target(i * 1e-3), target((i + 1) * 1e-3));
    BOOST_REQUIRE((handle.motor_side().X.p == Vec3{}));
    farthest = std::max(farthest, handle.state().X.p.x);
  }
  BOOST_TEST(farthest > 4e-4);
  BOOST_TEST(farthest < 1e-3);
}

BOOST_AUTO_TEST_CASE(without_a_motor_force_no_part_makes_energy) {
  const HandleParameters hand{.inertia = 0.11,
                              .damping = 0.1,
                              .coulomb = 0.02,
                              .hand_damping = 0.1,
                              .hand_stiffness = 500,
                              .breakaway = 0.05,
                              .stribeck_velocity = 0.005};
  const DeviceParts parts{.cogging = {.force = 0.05, .period = 1e-3},
                          .transmission = transmission_of(0.1, 0.5, 400, 0.02, 5e-4)};
  Handle handle(hand, free_body, h, false, parts);
  handle.place({{{0.02, -0.01, 0}, {}}, {{0, 0, 0.5}, {}}});
  const auto energy = [&] { return test::stored_energy(handle, hand, parts); };
  const double start = energy();
  double least = start;
  for (int i = 0; i < 3000; ++i) {
    handle.advance(1e-3, {}, {}, {});
    BOOST_REQUIRE(energy() < least + 1e-3 * start);
    least = std::min(least, energy());
  }
  BOOST_TEST(energy() < 0.05 * start);
  BOOST_TEST(handle.work() == 0.0);
}

BOOST_AUTO_TEST_CASE(extreme_constants_stay_finite_and_bounded) {
  for (const double sub_step : {1e-5, 1e-4, 1e-2}) {
    for (const double share : {0.01, 0.5, 0.99}) {
      for (const double backlash : {0.0, 1e-6, 1e-2}) {
        for (const double frequency : {1.0, 1000.0, 5000.0}) {
          for (const double ripple : {0.0, 10.0}) {
            const HandleParameters light{.inertia = 1e-3,
                                         .damping = 0,
                                         .coulomb = 0.1,
                                         .hand_damping = 1,
                                         .hand_stiffness = 1e5,
                                         .breakaway = 5,
                                         .stribeck_velocity = 1e-6};
            Handle handle(light, free_body, sub_step, false,
                          {.amplifier = {.bandwidth = 1e5, .force_max = 10},
                           .cogging = {.force = ripple, .period = 1e-4},
                           .transmission = transmission_of(1e-3, share, frequency, 0.01, backlash)});
            for (int i = 0; i < 30; ++i) {
              handle.advance(1e-3, {{i % 2 == 0 ? 1e3 : -1e3, i % 7 - 3.0, 0}, {}}, {}, {});
              BOOST_REQUIRE(is_finite(handle.state().X.p) && is_finite(handle.motor_side().X.p));
              // 10 N on 10 mg for a millisecond are 0.5 m; none of the parts may add to the work of the motors.
              BOOST_REQUIRE(norm(handle.motor_side().X.p) < 20);
              BOOST_REQUIRE(norm(handle.state().X.p) < 20);
            }
          }
        }
      }
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
