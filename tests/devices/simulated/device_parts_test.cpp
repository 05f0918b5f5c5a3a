// The simulated device with the parts of a real one: amplifiers, lines, play, noise.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <complex>
#include <map>
#include <vector>

#include "devices/simulated/simulated.hpp"
#include "framework/core/check.hpp"
#include "framework/core/segment.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "tests/devices/simulated/bench.hpp"

BOOST_AUTO_TEST_SUITE(device_parts_test)

using namespace tactor;
using test::Bench;
using test::open_gate;
using test::with;

namespace {

const std::map<std::string, ParamValue> closed_loop =
    with({{"loop", std::string("closed")}, {"encoder_step", 0.0}, {"encoder_step_angle", 0.0}}, open_gate);

const std::map<std::string, ParamValue> all_parts{{"amplifier_bandwidth", 200.0},
                                                  {"motor_force_max", 3.0},
                                                  {"motor_torque_max", 0.1},
                                                  {"cogging", 0.05},
                                                  {"breakaway", 0.1},
                                                  {"breakaway_angle", 2e-3},
                                                  {"mode_frequency", 90.0},
                                                  {"backlash", 2e-4},
                                                  {"encoder_noise", 1e-5},
                                                  {"encoder_noise_angle", 1e-4},
                                                  {"delay_in", 0.001},
                                                  {"delay_out", 0.002}};

MotionState swinging(double t) {
  return {
      {{0.05 * std::sin(3 * t), 0.02 * std::cos(7 * t), 0.1 * t}, from_rotation_vector({0, 0, 0.5 * std::sin(2 * t)})},
      {{0.15 * std::cos(3 * t), -0.14 * std::sin(7 * t), 0.1}, {0, 0, std::cos(2 * t)}}};
}

Wrench wave(int i) {
  return {{3 * std::sin(0.05 * i), 1, 0.2 * (i % 11)}, {0, 0.01, 0.02 * std::cos(0.1 * i)}};
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_state_comes_so_many_ticks_late_and_says_the_time_of_reading) {
  for (const std::string loop : {"open", "closed"}) {
    Bench bench(with({{"delay_in", 0.003}, {"loop", loop}}, closed_loop));
    std::vector<DeviceState> truth;
    for (std::size_t i = 0; i < 300; ++i) {
      bench.target(swinging(bench.now().seconds()));
      bench.tick();  // which demands that the state is stamped with now
      truth.push_back(bench.truth);
      const DeviceState& expected = truth[i < 3 ? 0 : i - 3];
      BOOST_REQUIRE(bench.shown.has_value());
      BOOST_REQUIRE((bench.shown->X_WD == expected.X_WD));
      BOOST_REQUIRE((bench.shown->V_WD.v == expected.V_WD.v));
    }
  }
}

BOOST_AUTO_TEST_CASE(a_command_acts_so_many_ticks_later_and_moves_the_handle_by_as_much_later) {
  Bench now(closed_loop), late(with({{"delay_out", 0.004}}, closed_loop));
  std::vector<DeviceState> truth;
  std::vector<Wrench> commanded;
  for (std::size_t i = 0; i < 500; ++i) {
    for (Bench* bench : {&now, &late}) {
      bench->target({});
      bench->segment(constant_segment(bench->now(), wave(static_cast<int>(i))));
      bench->tick();
    }
    BOOST_REQUIRE((now.commanded.force == late.commanded.force));
    truth.push_back(now.truth);
    commanded.push_back(now.commanded);
    // What acts at a tick is what has been held since the one before.
    if (i >= 1) BOOST_REQUIRE((now.motors.force == commanded[i - 1].force));
    if (i >= 5) BOOST_REQUIRE((late.motors.force == commanded[i - 5].force));
    if (i < 5) BOOST_REQUIRE((late.motors.force == Vec3{}));
    if (i >= 4) {
      // The target rests, so that the motion is the same.
      BOOST_REQUIRE((late.truth.X_WD == truth[i - 4].X_WD));
      BOOST_REQUIRE((late.truth.V_WD.v == truth[i - 4].V_WD.v));
    }
  }
}

BOOST_AUTO_TEST_CASE(motors_give_no_more_than_they_can_whatever_is_commanded) {
  for (const std::string loop : {"open", "closed"}) {
    Bench bench(with({{"motor_force_max", 2.0}, {"motor_torque_max", 0.05}, {"loop", loop}}, closed_loop));
    for (int i = 0; i < 100; ++i) {
      bench.target({});
      bench.segment(constant_segment(bench.now(), {{3, 0, -4}, {0.03, 0, 0.04}}));
      bench.tick();
    }
    BOOST_TEST(norm(bench.commanded.force - Vec3{3, 0, -4}) < 1e-14);
    BOOST_TEST(norm(bench.motors.force - Vec3{1.2, 0, -1.6}) < 1e-14);
    BOOST_TEST(norm(bench.motors.torque - Vec3{0.03, 0, 0.04}) < 1e-15);
    // The gate opens over the first ticks, and a command acts a tick later.
    BOOST_TEST(bench.metrics().at("device.saturated_ticks") >= 97);
    BOOST_TEST(bench.metrics().at("device.saturated_ticks") <= 99);
  }
  BOOST_TEST(Bench({}).metrics().count("device.saturated_ticks") == 0U);
}

BOOST_AUTO_TEST_CASE(the_motors_of_an_open_loop_have_the_pole_too) {
  Bench bench(with({{"amplifier_bandwidth", 60.0}}, open_gate));
  const double tau = 1 / (2 * 3.141592653589793 * 60);
  for (int i = 0; i < 50; ++i) {
    bench.target({});
    bench.segment(constant_segment(bench.now(), {{2, 0, 0}, {}}));
    // The gate lets the force through at the second tick, from which on it is held.
    const double t = std::max(bench.now().seconds() - 0.001, 0.0);
    bench.tick();
    BOOST_TEST(std::abs(bench.motors.force.x - 2 * (1 - std::exp(-t / tau))) < 1e-12);
  }
}

BOOST_AUTO_TEST_CASE(the_encoders_are_on_the_motor_side_and_the_truth_at_the_handle) {
  // A held force bends the spring: m_2 of the device and the hand's spring pull at the handle.
  Bench bench(
      with({{"friction", 0.0}, {"mode_frequency", 40.0}, {"mode_damping", 0.5}, {"motor_share", 0.5}}, closed_loop));
  for (int i = 0; i < 5000; ++i) {
    bench.target({});
    bench.segment(constant_segment(bench.now(), {{2, 0, 0}, {}}));
    bench.tick();
  }
  const double k = std::pow(2 * 3.141592653589793 * 40, 2) * 0.025;
  BOOST_TEST(std::abs(bench.truth.X_WD.p.x - 2 / 135.0) < 1e-9);
  BOOST_TEST(std::abs(bench.shown->X_WD.p.x - bench.truth.X_WD.p.x - 2 / k) < 1e-9);
}

BOOST_AUTO_TEST_CASE(a_reference_run_follows_the_handle_and_not_the_motor_side) {
  Bench tested(with(all_parts, closed_loop));
  std::vector<DeviceState> path;
  double apart = 0;
  for (int i = 0; i < 1000; ++i) {
    tested.target(swinging(tested.now().seconds()));
    tested.segment(constant_segment(tested.now(), wave(i)));
    tested.tick();
    path.push_back(tested.truth);
    apart = std::max(apart, norm(tested.shown->X_WD.p - tested.truth.X_WD.p));
  }
  BOOST_TEST(apart > 1e-4);
  // The engine gives the reference's values to the parameters that have some.
  std::map<std::string, ParamValue> given = with(all_parts, closed_loop);
  for (const ParamInfo& param : SimulatedDevice::declare().params) {
    if (param.in_reference && param.name != "rate") given[param.name] = *param.in_reference;
  }
  Bench reference(given);
  reference.device().follow(tested.device());
  for (std::size_t i = 0; i < 1000; ++i) {
    reference.target({});
    reference.segment(constant_segment(reference.now(), wave(static_cast<int>(i))));
    const Wrench before = reference.commanded;
    reference.tick();
    BOOST_REQUIRE(norm(reference.shown->X_WD.p - path[i].X_WD.p) < 1e-15);
    BOOST_REQUIRE(norm(reference.shown->V_WD.v - path[i].V_WD.v) < 1e-9);
    BOOST_REQUIRE((reference.motors.force == before.force));
  }
}

BOOST_AUTO_TEST_CASE(noise_lines_and_motors_are_ideal_in_a_reference_run) {
  const NodeInfo info = SimulatedDevice::declare();
  for (const char* name : {"encoder_noise", "encoder_noise_angle", "delay_in", "delay_out", "amplifier_bandwidth",
                           "motor_force_max", "motor_torque_max"}) {
    const ParamInfo& param = info.params[info.param(name).value()];
    BOOST_REQUIRE(param.in_reference.has_value());
    BOOST_TEST(std::get<double>(*param.in_reference) == 0.0);
  }
}

BOOST_AUTO_TEST_CASE(the_same_seed_makes_the_same_run_and_another_one_other_noise) {
  const auto run = [](std::uint64_t seed) {
    Bench bench(with(all_parts, closed_loop), true, seed);
    std::vector<Vec3> shown;
    for (int i = 0; i < 200; ++i) {
      bench.target(swinging(bench.now().seconds()));
      bench.segment(constant_segment(bench.now(), wave(i)));
      bench.tick();
      shown.push_back(bench.shown->X_WD.p);
    }
    return shown;
  };
  BOOST_TEST((run(5) == run(5)));
  BOOST_TEST((run(5) != run(6)));
}

BOOST_AUTO_TEST_CASE(parts_that_are_off_change_nothing_whatever_their_other_constants) {
  const std::map<std::string, ParamValue> idle{{"cogging_period", 1e-3},
                                               {"stribeck_velocity", 0.5},
                                               {"mode_damping", 0.7},
                                               {"motor_share", 0.2},
                                               {"breakaway", 0.01}};
  Bench plain(closed_loop), other(with(idle, closed_loop), true, 99);
  for (int i = 0; i < 1000; ++i) {
    for (Bench* bench : {&plain, &other}) {
      bench->target(swinging(bench->now().seconds()));
      bench->segment(constant_segment(bench->now(), wave(i)));
      bench->tick();
    }
    BOOST_REQUIRE((plain.truth.X_WD == other.truth.X_WD));
    BOOST_REQUIRE((plain.shown->X_WD == other.shown->X_WD));
    BOOST_REQUIRE((plain.shown->V_WD.v == other.shown->V_WD.v));
  }
}

BOOST_AUTO_TEST_CASE(a_delay_that_no_tick_can_show_is_refused) {
  for (const char* name : {"delay_in", "delay_out"}) {
    BOOST_CHECK_EXCEPTION(Bench(with({{name, 0.0004}}, closed_loop)), InputError, [&](const InputError& e) {
      return std::string(e.what()).find(std::string(name) +
                                        " is less than half a tick: expected 0 s or at least 0.000500 s") !=
             std::string::npos;
    });
    Bench(with({{name, 0.0005}}, closed_loop));
  }
}

BOOST_AUTO_TEST_CASE(a_rendered_spring_swings_up_or_down_as_the_delay_of_its_loop_says) {
  // M s^2 + b s + k_h + k e^(-s T) = 0, T being the delays, a tick until the command, and half a tick of hold.
  const double k = 1000;
  for (const double delay : {0.0, 0.002, 0.004}) {
    Bench bench(with({{"delay_in", delay}, {"delay_out", delay}, {"friction", 0.0}}, closed_loop), false);
    const double T = 2 * delay + 0.0015;
    std::complex<double> s(0, std::sqrt((k + 135) / 0.65));
    for (int i = 0; i < 50; ++i) {
      const std::complex<double> late = k * std::exp(-s * T);
      s -= (0.65 * s * s + 6.7 * s + 135.0 + late) / (1.3 * s + 6.7 - T * late);
    }
    // Samples 20 ticks apart of one mode: x_2 = a x_1 - c x_0, with c = e^(2 Re(s) 20 ms).
    std::vector<double> x;
    for (int i = 0; i < 1200; ++i) {
      bench.target({{{i < 100 ? 1e-3 : 0, 0, 0}, {}}, {}});
      bench.tick();
      bench.segment(constant_segment(bench.now(), {{-k * bench.shown->X_WD.p.x, 0, 0}, {}}));
      if (i >= 400) x.push_back(bench.truth.X_WD.p.x);
    }
    double m11 = 0, m12 = 0, m22 = 0, r1 = 0, r2 = 0;
    for (std::size_t i = 40; i < x.size(); ++i) {
      const double x_0 = x[i - 40], x_1 = x[i - 20];
      m11 += x_1 * x_1, m12 += x_1 * x_0, m22 += x_0 * x_0, r1 += x_1 * x[i], r2 += x_0 * x[i];
    }
    const double c = -(m11 * r2 - m12 * r1) / (m11 * m22 - m12 * m12);
    BOOST_TEST(std::abs(0.5 * std::log(c) / 0.02 - s.real()) < 0.02);
    BOOST_TEST((s.real() > 0) == (delay == 0.004));
  }
}

BOOST_AUTO_TEST_CASE(play_without_a_mode_is_refused_for_nothing_tells_its_stiffness) {
  BOOST_CHECK_EXCEPTION(Bench({{"backlash", 1e-3}}), InputError, [](const InputError& error) {
    return std::string(error.what()).find("mode_frequency") != std::string::npos;
  });
}

BOOST_AUTO_TEST_CASE(no_tick_with_all_parts_allocates) {
  Bench bench(with(all_parts, closed_loop));
  std::int64_t most = 0;
  for (int i = 0; i < 3000; ++i) {
    bench.target(swinging(bench.now().seconds()));
    bench.segment(constant_segment(bench.now(), wave(i)));
    const std::int64_t before = thread_heap_calls();
    bench.tick();
    most = std::max(most, thread_heap_calls() - before);
  }
  BOOST_TEST(most == 0);
  BOOST_TEST(bench.metrics().at("device.saturated_ticks") > 0);
}

BOOST_AUTO_TEST_SUITE_END()
