// Decimation against the filter's own frequency response, summed here anew, and the player that stands for physics.
#include "nodes/source/decimate.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>

#include "framework/core/check.hpp"
#include "nodes/source/physics.hpp"

BOOST_AUTO_TEST_SUITE(decimate_test)

using namespace tactor;

namespace {

constexpr double pi = std::numbers::pi;
constexpr double rate = 2000;

template <class F>
std::vector<Stamped<Wrench>> sampled(int n, F f) {
  std::vector<Stamped<Wrench>> samples;
  for (int i = 0; i < n; ++i) {
    const Time t{500'000LL * i};
    samples.push_back({{t, t, static_cast<std::uint64_t>(i)}, f(i / rate)});
  }
  return samples;
}

// What a Hamming-windowed sinc of 21 weights with its cut-off at 400 Hz leaves of a wave of `f` Hz sampled at 2 kHz.
double response(double f) {
  double sum = 0;
  double whole = 0;
  for (int i = -10; i <= 10; ++i) {
    const double sinc = i == 0 ? 0.4 : std::sin(0.4 * pi * i) / (pi * i);
    const double weight = sinc * (0.54 + 0.46 * std::cos(pi * i / 10));
    sum += weight * std::cos(2 * pi * f * i / rate);
    whole += weight;
  }
  return sum / whole;
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_second_sample_is_kept_at_its_own_time_with_the_filters_gain_and_no_shift) {
  for (const double f : {0.0, 10.0, 150.0, 300.0, 400.0, 700.0, 900.0}) {
    const auto wave = [f](double t) {
      return Wrench{{std::cos(2 * pi * f * t + 0.3), 0, 0}, {0, 0, 0.1 * std::sin(2 * pi * f * t)}};
    };
    const auto kept = decimated(sampled(2001, wave), 2, "here");
    BOOST_REQUIRE(kept.size() == 1001U);
    for (std::size_t i = 10; i < 990; ++i) {
      const double t = 1e-3 * static_cast<double>(i);
      BOOST_REQUIRE(kept[i].stamp.valid.ns == static_cast<std::int64_t>(i) * 1'000'000);
      BOOST_REQUIRE(std::abs(kept[i].value.force.x - response(f) * wave(t).force.x) < 1e-12);
      BOOST_REQUIRE(std::abs(kept[i].value.torque.z - response(f) * wave(t).torque.z) < 1e-12);
    }
  }
  // What would come back as a slow wave is gone, and what is slow stays.
  BOOST_TEST(std::abs(response(900)) < 0.003);
  BOOST_TEST(std::abs(response(100) - 1) < 0.004);
}

BOOST_AUTO_TEST_CASE(a_line_is_kept_to_its_ends) {
  const auto line = [](double t) { return Wrench{{3 - 2 * t, 0, 0}, {}}; };
  const auto kept = decimated(sampled(200, line), 4, "here");
  BOOST_REQUIRE(kept.size() == 50U);
  for (const auto& sample : kept) {
    BOOST_TEST(std::abs(sample.value.force.x - line(sample.stamp.valid.seconds()).force.x) < 1e-12);
  }
}

BOOST_AUTO_TEST_CASE(uneven_and_few_samples_are_refused_with_the_place) {
  const auto rest = [](double) { return Wrench{}; };
  BOOST_TEST(decimated(sampled(3, rest), 1, "here").size() == 3U);
  const auto about = [](const std::string& text) {
    return [text](const InputError& e) { return std::string(e.what()).find(text) != std::string::npos; };
  };
  BOOST_CHECK_EXCEPTION(decimated(sampled(20, rest), 2, "here"), InputError, about("here: expected at least 21"));
  auto gap = sampled(100, rest);
  for (std::size_t i = 60; i < gap.size(); ++i) gap[i].stamp.valid = gap[i].stamp.valid + Duration{500'000};
  BOOST_CHECK_EXCEPTION(decimated(gap, 2, "here"), InputError, about("before the one at 0.030500 s"));
}

BOOST_AUTO_TEST_CASE(the_player_passes_each_newest_force_on_once_with_its_stamp) {
  PhysicsSource player({}, {});
  player.recorded.configure({QueuePolicy::latest, 1});
  const auto sent = [&] {
    StepContext context(Time{9'000'000});
    player.recorded.queue().mark_seen();
    player.step(context);
    const std::size_t count = player.force.pending();
    return count;
  };
  BOOST_TEST(sent() == 0U);
  for (std::int64_t i = 1; i < 4; ++i) {
    const Wrench force{{double(i), 0, 0}, {}};
    player.recorded.push({Time{i * 1'000'000}, Time{i * 1'000'000}, std::uint64_t(i)}, &force);
  }
  BOOST_REQUIRE(sent() == 1U);
  BOOST_TEST(player.force.pending_valid(0).ns == 3'000'000);
  BOOST_TEST(static_cast<const Wrench*>(player.force.pending_value(0))->force.x == 3.0);
  player.force.clear_pending();
  BOOST_TEST(sent() == 0U);
}

BOOST_AUTO_TEST_SUITE_END()
