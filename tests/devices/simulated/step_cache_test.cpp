// Steps whose length alternates are as exact as steps of one length, and nothing is made anew for them.
#include "devices/simulated/step_cache.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>

#include "devices/simulated/handle.hpp"
#include "devices/simulated/mass_chain.hpp"

BOOST_AUTO_TEST_SUITE(step_cache_test)

using namespace tactor;

namespace {

/// A loop of 3 kHz has periods of 333,333 and 333,334 ns.
constexpr double shorter = 333333e-9, longer = 333334e-9;

double length_of(int i) {
  return i % 3 == 2 ? longer : shorter;
}

}  // namespace

BOOST_AUTO_TEST_CASE(lengths_that_come_again_are_made_once) {
  StepCache<double> cache;
  int made = 0;
  const auto get = [&](double h) {
    return cache.get(h, [&](double step, double& value) {
      ++made;
      value = 2 * step;
    });
  };
  for (int i = 0; i < 300; ++i) BOOST_TEST(get(length_of(i)) == 2 * length_of(i));
  BOOST_TEST(made == 2);
  // A tick that was missed makes a step of two, and a few more lengths do no harm.
  for (int i = 0; i < 300; ++i)
    BOOST_TEST(get(i % 50 == 0 ? 2 * shorter : length_of(i)) == (i % 50 == 0 ? 4 * shorter : 2 * length_of(i)));
  BOOST_TEST(made == 3);
  // However many there are, each gets its own.
  for (int i = 0; i < 300; ++i) BOOST_TEST(get(1e-3 * (1 + i % 7)) == 2e-3 * (1 + i % 7));
}

BOOST_AUTO_TEST_CASE(masses_swing_by_the_closed_form_over_steps_of_two_lengths) {
  const double k = 5000, m_1 = 0.06, m_2 = 0.04, omega = std::sqrt(k * (m_1 + m_2) / (m_1 * m_2));
  MassChain<2> chain({.mass = {m_1, m_2}, .link = {{{k, 0}}}}, Friction({}), Cogging({}));
  MassChain<2>::Points points{PointState{}, PointState{{1e-3, 0, 0}, {}}};
  double t = 0;
  for (int i = 0; i < 3000; ++i) {
    chain.advance(length_of(i), {}, {}, points);
    t += length_of(i);
    BOOST_REQUIRE(std::abs(points[1].p.x - points[0].p.x - 1e-3 * std::cos(omega * t)) < 1e-12);
  }
}

BOOST_AUTO_TEST_CASE(a_handle_falls_into_its_hand_by_the_closed_form_over_ticks_of_two_lengths) {
  // Overdamped: x = F / k (1 + (q e^{p t} - p e^{q t}) / (p - q)), p and q the roots of M s^2 + B s + k.
  const double M = 0.65, B = 40, k = 135, force = 1;
  Handle handle({.inertia = M, .hand_damping = B, .hand_stiffness = k}, {.inertia = 1}, 1e-4, false);
  const double root = std::sqrt(B * B - 4 * M * k), p = (-B + root) / (2 * M), q = (-B - root) / (2 * M);
  double t = 0;
  for (int i = 0; i < 3000; ++i) {
    handle.advance(length_of(i), {{0, force, 0}, {}}, {}, {});
    t += length_of(i);
    const double x = force / k * (1 + (q * std::exp(p * t) - p * std::exp(q * t)) / (p - q));
    BOOST_REQUIRE(std::abs(handle.state().X.p.y - x) < 1e-12);
  }
}

BOOST_AUTO_TEST_SUITE_END()
