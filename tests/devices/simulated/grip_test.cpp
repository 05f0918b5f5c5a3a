// A hand behind a grip is a body of its own: it moves as closed forms and an independent integration say, and makes no
// energy.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "devices/simulated/handle.hpp"
#include "tests/devices/simulated/bench.hpp"
#include "tests/devices/simulated/stored_energy.hpp"

BOOST_AUTO_TEST_SUITE(grip_test)

using namespace tactor;

namespace {

constexpr double h = 1e-4;
const HandleParameters free_body{.inertia = 0.5};

/// A handle of 0.1 kg and a hand of 0.4 kg with a grip between, and nothing else.
HandleParameters gripped(double stiffness, double damping) {
  return {.inertia = 0.5, .hand_inertia = 0.4, .grip_stiffness = stiffness, .grip_damping = damping};
}

/// What a handle in a grip weighs and is held by, for an integration that shares no code with it.
struct Row {
  std::vector<double> mass;       // from the motors to the hand
  std::vector<double> stiffness;  // of the links, and last of the hand to its target at 0
  std::vector<double> damping;
  double device_damping = 0;
};

/// x and v of each mass, one after the other, a small step later by the classical method of Runge and Kutta.
std::vector<double> runge_kutta(const Row& row, std::vector<double> s, double force, double dt) {
  const std::size_t n = row.mass.size();
  const auto rate = [&](const std::vector<double>& at) {
    std::vector<double> out(2 * n);
    for (std::size_t i = 0; i < n; ++i) {
      double f = i == 0 ? force - row.device_damping * at[1] : 0;
      const double next_x = i + 1 < n ? at[2 * i + 2] : 0, next_v = i + 1 < n ? at[2 * i + 3] : 0;
      f += row.stiffness[i] * (next_x - at[2 * i]) + row.damping[i] * (next_v - at[2 * i + 1]);
      if (i > 0) {
        f -= row.stiffness[i - 1] * (at[2 * i] - at[2 * i - 2]) + row.damping[i - 1] * (at[2 * i + 1] - at[2 * i - 1]);
      }
      out[2 * i] = at[2 * i + 1];
      out[2 * i + 1] = f / row.mass[i];
    }
    return out;
  };
  const auto plus = [](const std::vector<double>& a, double w, const std::vector<double>& b) {
    std::vector<double> sum = a;
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += w * b[i];
    return sum;
  };
  const auto k1 = rate(s), k2 = rate(plus(s, dt / 2, k1)), k3 = rate(plus(s, dt / 2, k2)), k4 = rate(plus(s, dt, k3));
  for (std::size_t i = 0; i < s.size(); ++i) s[i] += dt / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
  return s;
}

/// Drives a handle with steps of force, its hand's target at rest, and compares all masses with the integration.
void compare(const HandleParameters& translation, const TransmissionParameters& link, const Row& row) {
  Handle handle(translation, free_body, h, false, {.transmission = link});
  std::vector<double> s(2 * row.mass.size());
  for (int i = 0; i < 400; ++i) {
    const double force = i % 90 < 40 ? 2.0 : -1.0;
    handle.advance(1e-3, {{0, force, 0}, {}}, {}, {});
    for (int k = 0; k < 1000; ++k) s = runge_kutta(row, s, force, 1e-6);
    BOOST_REQUIRE(std::abs(handle.motor_side().X.p.y - s[0]) < 1e-9);
    BOOST_REQUIRE(std::abs(handle.state().X.p.y - s[link.motor_mass > 0 ? 2 : 0]) < 1e-9);
    BOOST_REQUIRE(std::abs(handle.hand().X.p.y - s[s.size() - 2]) < 1e-9);
    BOOST_REQUIRE(std::abs(handle.hand().V.v.y - s[s.size() - 1]) < 1e-7);
  }
}

}  // namespace

BOOST_AUTO_TEST_CASE(handle_and_hand_swing_against_each_other_with_the_frequency_of_the_reduced_mass) {
  const double k = 500, reduced = 0.1 * 0.4 / 0.5;
  for (const double zeta : {0.0, 0.1}) {
    const double omega = std::sqrt(k / reduced), damped = omega * std::sqrt(1 - zeta * zeta);
    Handle handle(gripped(k, 2 * zeta * omega * reduced), free_body, h, false);
    handle.place({});
    // A blow to the handle: after it the handle has 1 m/s of the distance's rate.
    handle.advance(h, {{0.1 / h, 0, 0}, {}}, {}, {});
    const double d = handle.hand().X.p.x - handle.state().X.p.x, rate = handle.hand().V.v.x - handle.state().V.v.x;
    for (int i = 1; i <= 2000; ++i) {
      handle.advance(h, {}, {}, {});
      const double t = i * h;
      const double expected = std::exp(-zeta * omega * t) *
                              (d * std::cos(damped * t) + (rate + zeta * omega * d) / damped * std::sin(damped * t));
      BOOST_REQUIRE(std::abs(handle.hand().X.p.x - handle.state().X.p.x - expected) < 1e-12);
      BOOST_REQUIRE(std::abs(0.1 * handle.state().V.v.x + 0.4 * handle.hand().V.v.x - 0.1) < 1e-12);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_hand_behind_a_grip_moves_as_an_independent_integration_says) {
  const HandleParameters soft{.inertia = 0.4,
                              .damping = 0.2,
                              .hand_damping = 2,
                              .hand_stiffness = 135,
                              .hand_inertia = 0.3,
                              .grip_stiffness = 800,
                              .grip_damping = 1.5};
  compare(soft, {}, {{0.1, 0.3}, {800, 135}, {1.5, 2}, 0.2});
  const TransmissionParameters link = transmission_of(0.1, 0.4, 90, 0.05, 0);
  compare(soft, link, {{0.04, 0.06, 0.3}, {link.stiffness, 800, 135}, {link.damping, 1.5, 2}, 0.2});
  // A damper alone is a grip too.
  HandleParameters wet = soft;
  wet.grip_stiffness = 0;
  compare(wet, {}, {{0.1, 0.3}, {0, 135}, {1.5, 2}, 0.2});
}

BOOST_AUTO_TEST_CASE(a_very_stiff_grip_moves_as_a_rigid_one) {
  const HandleParameters rigid{
      .inertia = 0.65, .damping = 0.2, .coulomb = 0.05, .hand_damping = 6.5, .hand_stiffness = 135};
  HandleParameters stiff = rigid;
  stiff.hand_inertia = 0.55;
  stiff.grip_stiffness = 1e6;
  stiff.grip_damping = 300;
  for (const double mode : {0.0, 5000.0}) {
    const DeviceParts parts{.transmission = transmission_of(0.1, 0.5, mode, 0.5, 0)};
    Handle one(rigid, free_body, h, false, parts), two(stiff, free_body, h, false, parts);
    for (int i = 0; i < 2000; ++i) {
      const Wrench u{{i % 700 < 350 ? 1.0 : -0.5, 0.2, 0}, {}};
      one.advance(1e-3, u, {}, {});
      two.advance(1e-3, u, {}, {});
      BOOST_REQUIRE(norm(one.state().X.p - two.state().X.p) < 6e-6);
      BOOST_REQUIRE(norm(two.hand().X.p - two.state().X.p) < 6e-6);
    }
  }
}

BOOST_AUTO_TEST_CASE(friction_holds_the_handle_while_the_hand_swings_in_its_grip) {
  HandleParameters held = gripped(500, 0);
  held.coulomb = 5;
  held.hand_stiffness = 100;
  Handle handle(held, free_body, h, false);
  const MotionState away{{{1e-3, 0, 0}, {}}, {}};
  handle.place({});
  const double omega = std::sqrt(600 / 0.4);
  for (int i = 1; i <= 5000; ++i) {
    handle.advance(h, {{1, 0, 0}, {}}, away, away);
    BOOST_REQUIRE((handle.state().X.p == Vec3{}));
    BOOST_REQUIRE(std::abs(handle.hand().X.p.x - 1e-3 / 6 * (1 - std::cos(omega * i * h))) < 1e-12);
  }
}

BOOST_AUTO_TEST_CASE(without_a_motor_force_a_grip_makes_no_energy) {
  const HandleParameters hand{.inertia = 0.3,
                              .damping = 0.1,
                              .coulomb = 0.02,
                              .hand_damping = 0.1,
                              .hand_stiffness = 500,
                              .breakaway = 0.05,
                              .stribeck_velocity = 0.005,
                              .hand_inertia = 0.2,
                              .grip_stiffness = 3000,
                              .grip_damping = 0.05};
  for (const double mode : {0.0, 400.0}) {
    const DeviceParts parts{.cogging = {.force = 0.05, .period = 1e-3},
                            .transmission = transmission_of(0.1, 0.5, mode, 0.02, 5e-4)};
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
    BOOST_TEST(energy() < 0.1 * start);
    BOOST_TEST(handle.work() == 0.0);
  }
}

BOOST_AUTO_TEST_CASE(what_the_motors_give_is_found_again_in_a_grip_without_dampers) {
  HandleParameters lossless = gripped(900, 0);
  lossless.hand_stiffness = 200;
  Handle handle(lossless, free_body, h, false);
  for (int i = 0; i < 3000; ++i) {
    handle.advance(1e-3, {{0, 0, i % 50 < 25 ? 1.0 : -0.7}, {}}, {}, {});
    BOOST_REQUIRE(std::abs(test::stored_energy(handle, lossless) - handle.work()) < 1e-9);
  }
}

BOOST_AUTO_TEST_CASE(extreme_grips_stay_finite_and_make_no_energy) {
  for (const double sub_step : {1e-5, 1e-4, 1e-2}) {
    for (const double mass : {1e-3, 0.1, 100.0}) {
      for (const double stiffness : {0.0, 1.0, 1e6}) {
        for (const double damping : {0.0, 1e-3, 1e4}) {
          if (stiffness == 0 && damping == 0) continue;
          for (const double mode : {0.0, 5000.0}) {
            const HandleParameters hand{.inertia = 1e-3 + mass,
                                        .coulomb = 0.1,
                                        .hand_damping = 1,
                                        .hand_stiffness = 1e5,
                                        .breakaway = 5,
                                        .stribeck_velocity = 1e-6,
                                        .hand_inertia = mass,
                                        .grip_stiffness = stiffness,
                                        .grip_damping = damping};
            Handle handle(hand, free_body, sub_step, false, {.transmission = transmission_of(1e-3, 0.5, mode, 0, 0)});
            for (int i = 0; i < 30; ++i) {
              handle.advance(1e-3, {{i % 2 == 0 ? 1e3 : -1e3, i % 7 - 3.0, 0}, {}}, {}, {});
            }
            const double given = handle.work();
            const auto kinetic = [&] {
              double sum = 0.5 * mass * dot(handle.hand().V.v, handle.hand().V.v);
              for (const MotionState* side : {&handle.motor_side(), &handle.state()}) {
                sum += 0.25e-3 * dot(side->V.v, side->V.v);
              }
              return sum + 5e4 * dot(handle.hand().X.p, handle.hand().X.p);
            };
            BOOST_REQUIRE(std::isfinite(given));
            BOOST_REQUIRE(kinetic() <= given * (1 + 1e-6));
            for (int i = 0; i < 200; ++i) handle.advance(1e-3, {}, {}, {});
            BOOST_REQUIRE(kinetic() <= given * (1 + 1e-6));
          }
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_hand_turns_in_its_grip_as_it_moves) {
  // 5e-5 and 5e-4 kg m^2 on a spring: the wrist's swing against the handle, about an axis that is none of the world's.
  const double k = 2, reduced = 5e-5 * 5e-4 / 5.5e-4, omega = std::sqrt(k / reduced);
  const HandleParameters wrist{.inertia = 5.5e-4, .hand_inertia = 5e-4, .grip_stiffness = k};
  Handle handle(free_body, wrist, h, true);
  handle.place({});
  const Vec3 axis{0.6, 0, 0.8};
  handle.advance(h, {{}, (1e-5 / h) * axis}, {}, {});
  const auto twist = [&] { return dot(axis, to_rotation_vector(handle.hand().X.R * inverse(handle.state().X.R))); };
  const double d = twist(), rate = dot(axis, handle.hand().V.w - handle.state().V.w);
  for (int i = 1; i <= 1000; ++i) {
    handle.advance(h, {}, {}, {});
    const double t = i * h;
    BOOST_REQUIRE(std::abs(twist() - d * std::cos(omega * t) - rate / omega * std::sin(omega * t)) < 1e-9);
    BOOST_REQUIRE(std::abs(dot(axis, 5e-5 * handle.state().V.w + 5e-4 * handle.hand().V.w) - 1e-5) < 1e-15);
  }
}

BOOST_AUTO_TEST_CASE(a_grip_that_is_wound_up_beyond_half_a_turn_pulls_back) {
  // A steady torque on the handle: reduced d'' = -k d - torque reduced / J, d from handle to hand, so that
  // d = -d_0 (1 - cos omega t), up to 5.5 rad.
  const double k = 0.02, handle_J = 5e-5, hand_J = 5e-4, torque = 0.06;
  const double reduced = handle_J * hand_J / (handle_J + hand_J), omega = std::sqrt(k / reduced);
  const double d_0 = torque * reduced / (handle_J * k);
  BOOST_REQUIRE(2 * d_0 > 5);
  Handle handle(free_body, {.inertia = handle_J + hand_J, .hand_inertia = hand_J, .grip_stiffness = k}, h, true);
  handle.place({});
  const Vec3 axis{0.6, 0, 0.8};
  for (int i = 1; i <= 5000; ++i) {
    handle.advance(h, {{}, torque * axis}, {}, {});
    const double rate = dot(axis, handle.hand().V.w - handle.state().V.w);
    BOOST_REQUIRE(std::abs(rate + d_0 * omega * std::sin(omega * i * h)) < 1e-6 * d_0 * omega);
  }
}

BOOST_AUTO_TEST_CASE(a_hand_that_is_turned_beyond_half_a_turn_pulls_towards_its_target) {
  // J a'' = torque - k a: a = torque / k (1 - cos omega t), up to 4 rad.
  const double k = 0.02, J = 5.5e-4, torque = 0.04, omega = std::sqrt(k / J);
  const Vec3 axis{0, 0.6, -0.8};
  Handle handle(free_body, {.inertia = J, .hand_stiffness = k}, h, true);
  handle.place({});
  for (int i = 1; i <= 5000; ++i) {
    handle.advance(h, {{}, torque * axis}, {}, {});
    BOOST_REQUIRE(std::abs(dot(axis, handle.state().V.w) - torque / k * omega * std::sin(omega * i * h)) <
                  1e-6 * torque / k * omega);
  }
}

BOOST_AUTO_TEST_CASE(a_hand_without_mass_in_a_grip_is_refused) {
  const auto refused = [](const std::map<std::string, ParamValue>& given, const std::string& text) {
    BOOST_CHECK_EXCEPTION(test::Bench{given}, InputError,
                          [&](const InputError& e) { return std::string(e.what()).find(text) != std::string::npos; });
  };
  refused(
      {{"hand_mass", 0.0}, {"grip_stiffness", 500.0}},
      "hand_mass is too small for a grip: expected at least 0.001 kg where grip_stiffness or its damping is above 0, "
      "found 0 kg");
  refused({{"hand_mass", 0.0}, {"grip_damping", 1.0}}, "found 0 kg");
  refused({{"hand_inertia", 5e-8}, {"grip_stiffness_angle", 1.0}}, "expected at least 1e-07 kg m^2");
  refused({{"inertia", 1e-12}, {"grip_stiffness_angle", 1.0}}, "inertia is too small for a grip");
  test::Bench({{"hand_mass", 0.0}, {"hand_inertia", 0.0}});
  test::Bench({{"hand_mass", 1e-3}, {"grip_damping", 1.0}, {"hand_inertia", 1e-7}, {"grip_damping_angle", 1e-3}});
}

BOOST_AUTO_TEST_SUITE_END()
