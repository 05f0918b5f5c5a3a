// The handle follows the cursor by the closed form of a critically damped filter, and no faster than its limit.
#include "devices/mouse/cursor_filter.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>

BOOST_AUTO_TEST_SUITE(cursor_filter_test)

using namespace tactor;

namespace {
constexpr double tau = 0.01;  // s
constexpr CursorFilter::Limits unlimited{tau, 1e9, 1e9};
}  // namespace

BOOST_AUTO_TEST_CASE(a_step_of_the_cursor_is_answered_by_the_closed_form) {
  CursorFilter filter(unlimited, {});
  const Pose cursor{{0.01, -0.02, 0.03}, {}};
  for (int i = 1; i <= 80; ++i) {
    filter.advance(1e-3, cursor, true);
    // x'' = w^2 (c - x) - 2 w x' from rest at 0: x = c (1 - (1 + w t) exp(-w t)).
    const double wt = i * 1e-3 / tau;
    const double share = 1 - (1 + wt) * std::exp(-wt);
    const double rate = wt * std::exp(-wt) / tau;
    BOOST_TEST(norm(filter.state().X.p - share * cursor.p) < 1e-12);
    BOOST_TEST(norm(filter.state().V.v - rate * cursor.p) < 1e-9);
  }
}

BOOST_AUTO_TEST_CASE(a_turn_is_answered_by_the_same_form_about_its_axis) {
  CursorFilter filter(unlimited, {});
  const Vec3 turn{0, 0.3, -0.4};
  for (int i = 1; i <= 80; ++i) {
    filter.advance(1e-3, {{}, from_rotation_vector(turn)}, true);
    const double wt = i * 1e-3 / tau;
    const double share = 1 - (1 + wt) * std::exp(-wt);
    const double rate = wt * std::exp(-wt) / tau;
    BOOST_TEST(norm(to_rotation_vector(filter.state().X.R) - share * turn) < 1e-9);
    BOOST_TEST(norm(filter.state().V.w - rate * turn) < 1e-7);
  }
}

BOOST_AUTO_TEST_CASE(the_steps_may_be_cut_in_any_way) {
  CursorFilter fine(unlimited, {}), coarse(unlimited, {});
  const Pose cursor{{0.1, 0, 0}, {}};
  for (int i = 0; i < 30; ++i) fine.advance(1e-3, cursor, false);
  coarse.advance(30e-3, cursor, false);
  BOOST_TEST(std::abs(fine.state().X.p.x - coarse.state().X.p.x) < 1e-12);
}

BOOST_AUTO_TEST_CASE(the_handle_is_never_faster_than_the_limit) {
  CursorFilter filter({tau, 0.5, 6}, {});
  double way = 0;
  for (int i = 0; i < 1000; ++i) {
    // A cursor that jumps to and fro.
    const double side = (i / 200) % 2 == 0 ? 1 : -1;
    const Vec3 before = filter.state().X.p;
    const Quat turned = filter.state().X.R;
    filter.advance(1e-3, {{side, 0, 0}, from_rotation_vector({0, 0, 1.5 * side})}, true);
    BOOST_TEST(norm(filter.state().V.v) <= 0.5 + 1e-12);
    BOOST_TEST(norm(filter.state().V.w) <= 6.0 + 1e-9);
    BOOST_TEST(norm(filter.state().X.p - before) <= 0.5e-3 + 1e-12);
    BOOST_TEST(norm(to_rotation_vector(filter.state().X.R * inverse(turned))) <= 6e-3 + 1e-9);
    way += norm(filter.state().X.p - before);
  }
  BOOST_TEST(way > 0.4);
}

BOOST_AUTO_TEST_CASE(without_rotation_the_orientation_stays) {
  CursorFilter filter(unlimited, {});
  for (int i = 0; i < 100; ++i) filter.advance(1e-3, {{0.1, 0, 0}, from_rotation_vector({1, 0, 0})}, false);
  BOOST_TEST((filter.state().X.R == Quat{}));
  BOOST_TEST(norm(filter.state().V.w) == 0.0);
}

BOOST_AUTO_TEST_SUITE_END()
