// The simulated device answers a sine as the closed form of its linear part says.
#include "devices/simulated/response.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "devices/simulated/handle.hpp"
#include "tests/devices/simulated/bench.hpp"

BOOST_AUTO_TEST_SUITE(response_test)

using namespace tactor;

namespace {

constexpr double pi = std::numbers::pi;
const HandleParameters free_body{.inertia = 0.5};
const std::vector<double> frequencies{1, 2, 5, 10, 20, 40, 60, 80, 90, 100, 120, 150, 180, 200};

/// The complex amplitude at `frequency` (whole Hz) of what is sampled at `rate`, relative to sin(2 pi f t).
class Analyser {
 public:
  Analyser(double frequency, double rate) : omega_(2 * pi * frequency), rate_(rate) {}
  /// Sample number i, over whole seconds.
  void take(int i, double x) {
    sum_ += x * std::polar(1.0, -omega_ * i / rate_);
    ++count_;
  }
  [[nodiscard]] std::complex<double> amplitude() const {
    return std::complex<double>(0, 2.0 / static_cast<double>(count_)) * sum_;
  }

 private:
  double omega_, rate_;
  std::complex<double> sum_;
  int count_ = 0;
};

double dB(std::complex<double> ratio) {
  return 20 * std::log10(std::abs(ratio));
}

/// Drives a handle by a sine of `rate` samples a second, and compares both of its sides with the closed form.
void compare(const LinearDevice& device, double rate, double allowed_dB, double allowed_rad) {
  const HandleParameters translation{.inertia = device.mass,
                                     .damping = device.damping,
                                     .hand_damping = device.hand_damping,
                                     .hand_stiffness = device.hand_stiffness,
                                     .hand_inertia = device.hand_mass,
                                     .grip_stiffness = device.grip_stiffness,
                                     .grip_damping = device.grip_damping};
  for (const double frequency : frequencies) {
    Handle handle(translation, free_body, 1e-4, false,
                  {.amplifier = {.bandwidth = device.bandwidth}, .transmission = device.transmission});
    Analyser at_handle(frequency, rate), at_motors(frequency, rate);
    const int settled = static_cast<int>(4 * rate), end = static_cast<int>(5 * rate);
    for (int i = 0; i < end; ++i) {
      if (i >= settled) {
        at_handle.take(i, handle.state().X.p.x);
        at_motors.take(i, handle.motor_side().X.p.x);
      }
      handle.advance(1 / rate, {{std::sin(2 * pi * frequency * i / rate), 0, 0}, {}}, {}, {});
    }
    const std::complex<double> of_handle =
        at_handle.amplitude() / position_response(device, frequency, ResponsePoint::handle);
    const std::complex<double> of_motors =
        at_motors.amplitude() / position_response(device, frequency, ResponsePoint::motor_side);
    BOOST_TEST_CONTEXT(frequency << " Hz") {
      BOOST_TEST(std::abs(dB(of_handle)) < allowed_dB);
      BOOST_TEST(std::abs(dB(of_motors)) < allowed_dB);
      BOOST_TEST(std::abs(std::arg(of_handle)) < allowed_rad);
      BOOST_TEST(std::abs(std::arg(of_motors)) < allowed_rad);
    }
  }
}

const LinearDevice in_a_hand{.hold = 1e-4, .mass = 0.65, .damping = 0.2, .hand_damping = 6.5, .hand_stiffness = 135};

}  // namespace

BOOST_AUTO_TEST_CASE(one_body_answers_as_a_mass_on_a_spring) {
  compare(in_a_hand, 10000, 0.02, 0.002);
}

BOOST_AUTO_TEST_CASE(a_hand_behind_a_grip_answers_as_grip_and_hand_in_series) {
  LinearDevice device = in_a_hand;
  device.hand_mass = 0.55;
  device.grip_stiffness = 900;
  device.grip_damping = 2;
  compare(device, 10000, 0.02, 0.002);
  device.transmission = transmission_of(0.1, 0.4, 110, 0.05, 0);
  compare(device, 10000, 0.02, 0.002);
}

BOOST_AUTO_TEST_CASE(an_amplifier_takes_three_decibels_at_its_bandwidth) {
  LinearDevice device = in_a_hand;
  device.bandwidth = 100;
  compare(device, 10000, 0.02, 0.002);
  const double lost = dB(position_response(device, 100, ResponsePoint::handle) /
                         position_response(in_a_hand, 100, ResponsePoint::handle));
  BOOST_TEST(std::abs(lost - 10 * std::log10(0.5)) < 1e-12);
}

BOOST_AUTO_TEST_CASE(two_masses_answer_with_resonance_and_antiresonance) {
  LinearDevice device = in_a_hand;
  device.bandwidth = 300;
  device.transmission = transmission_of(0.1, 0.4, 90, 0.05, 0);
  compare(device, 10000, 0.02, 0.002);
  // With the heavy hand the motor side stands still where the handle alone swings on the spring.
  const double k = device.transmission.stiffness;
  const double antiresonance = std::sqrt((k + 135) / (0.65 - 0.04)) / (2 * pi);
  const double at = acceleration_response_dB(device, antiresonance, ResponsePoint::motor_side);
  BOOST_TEST(at < acceleration_response_dB(device, 0.5 * antiresonance, ResponsePoint::motor_side));
  BOOST_TEST(at < acceleration_response_dB(device, 2 * antiresonance, ResponsePoint::motor_side) - 10);
}

BOOST_AUTO_TEST_CASE(a_lightly_damped_mode_of_a_device_without_hand_is_met_as_well) {
  // A weak spring and damper stand for the rest, so that it stays where it is.
  const LinearDevice device{.hold = 1e-4,
                            .bandwidth = 500,
                            .mass = 0.08,
                            .damping = 0.5,
                            .hand_damping = 0.5,
                            .hand_stiffness = 10,
                            .transmission = transmission_of(0.08, 0.6, 120, 0.02, 0)};
  compare(device, 10000, 0.02, 0.003);
}

BOOST_AUTO_TEST_CASE(low_frequencies_are_those_of_the_springs_and_high_ones_those_of_the_masses) {
  LinearDevice device = in_a_hand;
  device.hold = 0;
  BOOST_TEST(std::abs(std::abs(position_response(device, 1e-4, ResponsePoint::handle)) * 135 - 1) < 1e-6);
  BOOST_TEST(std::abs(acceleration_response_dB(device, 1e5, ResponsePoint::handle) + 20 * std::log10(0.65)) < 1e-4);
  device.transmission = transmission_of(0.1, 0.4, 90, 0.05, 0);
  BOOST_TEST(std::abs(std::abs(position_response(device, 1e-4, ResponsePoint::handle)) * 135 - 1) < 1e-6);
  // Far above the mode the motors move their own mass alone.
  BOOST_TEST(std::abs(acceleration_response_dB(device, 1e5, ResponsePoint::motor_side) + 20 * std::log10(0.04)) < 1e-2);
}

BOOST_AUTO_TEST_CASE(the_device_at_one_kilohertz_answers_within_half_a_decibel_up_to_200_hertz) {
  const std::map<std::string, ParamValue> given = test::with({{"loop", std::string("closed")},
                                                              {"friction", 0.0},
                                                              {"encoder_step", 0.0},
                                                              {"amplifier_bandwidth", 250.0},
                                                              {"mode_frequency", 110.0},
                                                              {"motor_share", 0.5},
                                                              {"delay_out", 0.002}},
                                                             test::open_gate);
  SimulatedDevice::Params params{};
  const NodeInfo info = SimulatedDevice::declare();
  const std::vector<ParamValue> values = test::param_values(info, given);
  for (std::size_t i = 0; i < values.size(); ++i) info.params[i].assign(&params, values[i]);
  params.rate = 1000;
  const LinearDevice device = linear_device(params);
  BOOST_TEST(device.delay == 0.002);
  BOOST_TEST(device.hold == 0.001);
  for (const double frequency : frequencies) {
    test::Bench bench(given, false);
    Analyser analyser(frequency, 1000);
    for (int i = 0; i < 5000; ++i) {
      bench.target({});
      bench.segment(constant_segment(bench.now(), {{std::sin(2 * pi * frequency * i / 1000), 0, 0}, {}}));
      bench.tick();
      if (i >= 4000) analyser.take(i, bench.truth.X_WD.p.x);
    }
    const std::complex<double> ratio =
        analyser.amplitude() / position_response(device, frequency, ResponsePoint::handle);
    BOOST_TEST_CONTEXT(frequency << " Hz") {
      BOOST_TEST(std::abs(dB(ratio)) < 0.5);
      BOOST_TEST(std::abs(std::arg(ratio)) < 0.05);
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
