// The energy of a port against closed forms: springs, dampers, rounding, weight, and what is kept of it.
#include "nodes/passivity/port_energy.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/force_stream.hpp"

BOOST_AUTO_TEST_SUITE(port_energy_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr double k = 500;     // N/m
constexpr double A = 0.01;    // m
constexpr int period = 1000;  // ticks
constexpr PortEnergyOptions plain{.kept = 1e6, .stiffness = 1, .lever = 0.05};

double path(int n) {
  return A * std::sin(2 * std::numbers::pi * n / period);
}

/// Ports as a stage has them, fed once a tick.
struct Port {
  explicit Port(const PortEnergyOptions& options) : energy(options) {
    device.configure({QueuePolicy::drop_oldest, 64});
    commanded.configure({QueuePolicy::drop_oldest, 64});
  }
  /// The handle at X, and what is commanded from then on.
  void tick(const Pose& X, const Wrench& wrench) {
    DeviceState state;
    state.X_WD = X;
    const Stamp stamp = stamp_ms(n, n);
    device.push(stamp, &state);
    commanded.push(stamp, &wrench);
    energy.take(device, commanded);
    ++n;
  }
  Input<DeviceState> device;
  Input<Wrench> commanded;
  PortEnergy energy;
  std::uint64_t n = 0;
};

}  // namespace

BOOST_AUTO_TEST_CASE(a_sampled_spring_gives_half_its_stiffness_times_the_square_of_each_step) {
  // F(n) = -k x(n) held: what the hand gave is k/2 (x^2 - sum of squared steps), exactly. Along a slanted line.
  const Vec3 along = Vec3{1, 2, -2} / 3;
  Port port(plain);
  double squares = 0;
  for (int n = 0; n <= 3 * period; ++n) {
    if (n > 0) squares += (path(n) - path(n - 1)) * (path(n) - path(n - 1));
    port.tick({path(n) * along, {}}, {-k * path(n) * along, {}});
    BOOST_TEST(std::abs(port.energy.energy() - 0.5 * k * (path(n) * path(n) - squares)) < 1e-14);
  }
  // Over whole periods the sum of the squares is (2 A sin(pi / period))^2 / 2 a tick.
  const double step = 2 * A * std::sin(std::numbers::pi / period);
  BOOST_TEST(std::abs(port.energy.energy() + 0.5 * k * 3 * period * 0.5 * step * step) < 1e-13);
  BOOST_TEST(port.energy.least() <= port.energy.energy());
}

BOOST_AUTO_TEST_CASE(a_torsion_spring_does_the_same_and_counts_with_the_force) {
  const double k_r = 0.5;  // N m/rad
  PortEnergyOptions options = plain;
  Port port(options);
  double expected = 0, before = 0, before_angle = 0;
  for (int n = 0; n <= period; ++n) {
    const double x = path(n), angle = 30 * path(n + period / 8);
    if (n > 0) expected += k * before * (x - before) + k_r * before_angle * (angle - before_angle);
    before = x;
    before_angle = angle;
    port.tick({{0, x, 0}, from_rotation_vector({0, 0, angle})}, {{0, -k * x, 0}, {0, 0, -k_r * angle}});
    BOOST_TEST(std::abs(port.energy.energy() - expected) < 1e-12);
  }
  options.torque = false;
  Port without(options);
  without.tick({{}, {}}, {{}, {0, 0, 1}});
  without.tick({{}, from_rotation_vector({0, 0, 0.1})}, {});
  BOOST_TEST(without.energy.energy() == 0);
}

BOOST_AUTO_TEST_CASE(damping_of_the_device_adds_what_an_even_motion_loses) {
  PortEnergyOptions options = plain;
  options.damping = 0.2;
  Port port(options);
  for (int n = 0; n <= 100; ++n) port.tick({{1e-4 * n, 0, 0}, {}}, {});
  // b v^2 t with v = 0.1 m/s, t = 0.1 s.
  BOOST_TEST(std::abs(port.energy.energy() - 0.2 * 0.01 * 0.1) < 1e-14);
}

BOOST_AUTO_TEST_CASE(rounding_is_taken_off_so_that_no_true_motion_gives_more) {
  // A handle that moves within steps of D, under a force that changes at random: by parts, the energy by the rounded
  // positions less that of the true ones is below D/2 times the changes of force and the last force.
  constexpr double D = 1e-5;
  PortEnergyOptions options = plain;
  options.step = D;
  options.pessimism = 1;
  Dice draw(4);
  for (int run = 0; run < 20; ++run) {
    Port port(options);
    double truth = 0, x_before = 0, x = 0;
    Vec3 force;
    for (int n = 0; n < 2000; ++n) {
      x = 0.9 * x + draw.normal(D);
      truth -= force.x * (x - x_before);
      x_before = x;
      // The worst case: the force follows what the rounding hides.
      const double rounded = D * std::round(x / D);
      force.x = run % 2 == 0 ? draw.normal() : (rounded - x) * 1e5;
      port.tick({{rounded, 0, 0}, {}}, {force, {}});
      BOOST_TEST_REQUIRE(port.energy.energy() <= truth + 1e-15);
    }
  }
}

BOOST_AUTO_TEST_CASE(what_is_kept_is_what_the_softest_spring_holds_at_the_force) {
  PortEnergyOptions options = plain;
  options.kept = 0.002;
  options.stiffness = 50;
  Port port(options);
  // A damper of 4 N over 1 m takes 4 J; of these 0.002 + 16 / 100 are kept, and without force 0.002.
  for (int n = 0; n <= 1000; ++n) port.tick({{1e-3 * n, 0, 0}, {}}, {{-4, 0, 0}, {}});
  BOOST_TEST(std::abs(port.energy.energy() - 0.162) < 1e-12);
  port.tick({{1, 0, 0}, {}}, {});
  port.tick({{1, 0, 0}, {}}, {});
  BOOST_TEST(std::abs(port.energy.energy() - 0.002) < 1e-12);
}

BOOST_AUTO_TEST_CASE(the_weight_of_the_tool_gives_back_what_lifting_it_took) {
  PortEnergyOptions options = plain;
  const Vec3 weight{0, 0, -0.981};
  options.weight_W = weight;
  Port port(options);
  for (int n = 0; n <= 2 * period; ++n) {
    port.tick({{0, 0, path(n)}, {}}, {weight, {}});
    BOOST_TEST(std::abs(port.energy.energy()) < 1e-14);
  }
  // Zero is commanded by a gate that is not engaged: then the weight gives nothing.
  Port open(options);
  for (int n = 0; n <= period / 4; ++n) open.tick({{0, 0, path(n)}, {}}, {});
  BOOST_TEST(open.energy.energy() == 0);
}

BOOST_AUTO_TEST_CASE(samples_that_are_not_finite_or_not_later_are_left_out) {
  Port port(plain);
  port.tick({{0, 0, 0}, {}}, {{1, 0, 0}, {}});
  port.tick({{NAN, 0, 0}, {}}, {{NAN, 0, 0}, {}});
  BOOST_TEST(port.energy.held().force.x == 1);
  port.n = 1;
  port.tick({{0.5, 0, 0}, {}}, {{1, 0, 0}, {}});
  BOOST_TEST(std::abs(port.energy.energy() + 0.5) < 1e-15);
  port.n = 1;
  port.tick({{0.9, 0, 0}, {}}, {{1, 0, 0}, {}});
  BOOST_TEST(std::abs(port.energy.energy() + 0.5) < 1e-15);
}

BOOST_AUTO_TEST_CASE(a_device_that_comes_late_is_charged_for_the_two_ticks_that_it_held) {
  PortEnergyOptions options = plain;
  options.acceleration = 60;
  options.tick = Duration{1'000'000};
  Port port(options);
  const Wrench push{{5, 0, 0}, {}};
  port.tick({{0, 0, 0}, {}}, push);
  port.tick({{0.0005, 0, 0}, {}}, push);  // 0.5 m/s
  BOOST_TEST(std::abs(port.energy.energy() + 5 * 0.0005) < 1e-15);
  // The next tick is 10 ms later; the hand has pulled the handle back meanwhile.
  port.n = 11;
  port.tick({{-0.01, 0, 0}, {}}, push);
  const double held = 2e-3, farther = 60 * held * (0.5 * held + 0.5 * 1e-3);
  BOOST_TEST(std::abs(port.energy.energy() + 5 * (0.0005 + 0.5 * held + farther)) < 1e-12);
  // Two ticks are no lateness.
  const double before = port.energy.energy();
  port.n = 13;
  port.tick({{-0.012, 0, 0}, {}}, push);
  BOOST_TEST(std::abs(port.energy.energy() - before - 5 * 0.002) < 1e-12);
}

BOOST_AUTO_TEST_SUITE_END()
