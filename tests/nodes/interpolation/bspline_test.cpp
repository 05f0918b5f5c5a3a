// The B-spline's properties, and the continuity that each way of joining segments promises.
#include "nodes/interpolation/bspline.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <utility>
#include <vector>

#include "framework/core/segment.hpp"
#include "tests/support/force_stream.hpp"

BOOST_AUTO_TEST_SUITE(bspline_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr double T = 0.010;

Wrench along_x(double x) {
  return {{x, 0, 0}, {0, 0.1 * x, 0}};
}

double cubic(const std::array<Wrench, 6>& c, double u) {
  return c[0].force.x + u * (c[1].force.x + u * (c[2].force.x + u * c[3].force.x));
}

struct Driven {
  explicit Driven(BSpline::Join join, BSpline::ControlPoints points = BSpline::ControlPoints::predicted,
                  PeriodMode mode = PeriodMode::last, bool torque = true)
      : node(params(join, points, mode), context(torque)) {
    node.forecast.configure({QueuePolicy::latest, 1});
  }
  static BSpline::Params params(BSpline::Join join, BSpline::ControlPoints points, PeriodMode mode) {
    BSpline::Params p;
    p.join = join;
    p.control_points = points;
    p.period_estimate = mode;
    return p;
  }
  ForceSegment feed(Time now, const Wrench& current, const Wrench& predicted) {
    const Forecast f{current, {predicted}, T};
    return step_with(node, node.forecast, {now, now, sequence++}, f, node.segment);
  }
  BSpline node;
  std::uint64_t sequence = 0;
};

Time at(double seconds) {
  return Time::from_seconds(seconds);
}

// Derivative of order `d` (0, 1, 2) at s of a segment, in N, N/s, N/s^2, from the coefficients alone.
double derivative(const ForceSegment& g, int d, double s) {
  const double h = (g.end - g.begin).seconds();
  const double c1 = g.c[1].force.x;
  const double c2 = g.c[2].force.x;
  const double c3 = g.c[3].force.x;
  if (d == 0) return cubic(g.c, s);
  if (d == 1) return (c1 + 2 * c2 * s + 3 * c3 * s * s) / h;
  return (2 * c2 + 6 * c3 * s) / (h * h);
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_segment_is_the_printed_basis) {
  const std::array<Wrench, 4> P{along_x(1), along_x(-2), along_x(5), along_x(0.5)};
  for (double u = 0; u <= 1; u += 0.125) {
    const double w[4] = {std::pow(1 - u, 3) / 6, (3 * u * u * u - 6 * u * u + 4) / 6,
                         (-3 * u * u * u + 3 * u * u + 3 * u + 1) / 6, u * u * u / 6};
    BOOST_TEST(std::abs(w[0] + w[1] + w[2] + w[3] - 1) < 1e-15);
    double expected = 0;
    for (std::size_t i = 0; i < 4; ++i) expected += w[i] * P[i].force.x;
    BOOST_TEST(std::abs(cubic(bspline_cubic(P), u) - expected) < 1e-14);
  }
}

BOOST_AUTO_TEST_CASE(the_segment_stays_within_its_control_points) {
  Dice draw(1);
  for (int trial = 0; trial < 1000; ++trial) {
    std::array<Wrench, 4> P;
    double low = 1e9;
    double high = -1e9;
    for (Wrench& p : P) {
      p = along_x(draw.normal());
      low = std::min(low, p.force.x);
      high = std::max(high, p.force.x);
    }
    const double x = cubic(bspline_cubic(P), draw(0, 1));
    BOOST_TEST((x >= low - 1e-14 && x <= high + 1e-14));
  }
}

BOOST_AUTO_TEST_CASE(a_constant_is_reproduced_and_a_line_comes_two_periods_before_its_last_control_point) {
  for (const BSpline::Join join : {BSpline::Join::paper, BSpline::Join::continuous}) {
    Driven constant(join);
    Driven line(join);
    ForceSegment a;
    ForceSegment b;
    for (int k = 0; k < 20; ++k) {
      a = constant.feed(at(k * T), along_x(3), along_x(3));
      b = line.feed(at(k * T), along_x(k), along_x(k + 1));
    }
    for (double s = 0; s <= 1; s += 0.25) {
      BOOST_TEST(std::abs(derivative(a, 0, s) - 3) < 1e-9);
      // The value at the arrival of F_19, with F_{20|19} = 20 as the last control point, is 18.
      BOOST_TEST(std::abs(derivative(b, 0, s) - (18 + s)) < 1e-9);
    }
  }
}

BOOST_AUTO_TEST_CASE(predicted_control_points_join_with_c2_where_forecasts_are_on_time) {
  for (const BSpline::Join join : {BSpline::Join::paper, BSpline::Join::continuous}) {
    Driven spline(join);
    Dice draw(2);
    ForceSegment before = spline.feed(at(0), along_x(0), along_x(0));
    for (int k = 1; k < 200; ++k) {
      const ForceSegment after = spline.feed(at(k * T), along_x(draw.normal()), along_x(draw.normal()));
      for (int d = 0; d < 3; ++d) {
        BOOST_TEST(std::abs(derivative(after, d, 0) - derivative(before, d, 1)) < 1e-9 * std::pow(1 / T, d));
      }
      before = after;
    }
  }
}

BOOST_AUTO_TEST_CASE(the_continued_curve_is_the_papers_where_forecasts_are_on_time) {
  Driven paper(BSpline::Join::paper);
  Driven continued(BSpline::Join::continuous);
  Dice draw(3);
  for (int k = 0; k < 100; ++k) {
    const Wrench x = k == 0 ? Wrench{} : along_x(draw.normal());
    const ForceSegment a = paper.feed(at(k * T), x, x);
    const ForceSegment b = continued.feed(at(k * T), x, x);
    for (double s = 0; s <= 1; s += 0.25) BOOST_TEST(std::abs(derivative(a, 0, s) - derivative(b, 0, s)) < 1e-9);
  }
}

BOOST_AUTO_TEST_CASE(mixed_control_points_jump_by_the_prediction_errors) {
  Driven spline(BSpline::Join::paper, BSpline::ControlPoints::mixed);
  Dice draw(4);
  double F1 = 0;
  double expected1 = 0;
  ForceSegment before = spline.feed(at(0), along_x(0), along_x(0));
  for (int k = 1; k < 50; ++k) {
    const double F = draw.normal();
    const double expected = draw.normal();
    const ForceSegment after = spline.feed(at(k * T), along_x(F), along_x(expected));
    // Only the control point of weight 1/6 at the join changes, from F_{t|t-1} to F_t.
    BOOST_TEST(std::abs(derivative(after, 0, 0) - derivative(before, 0, 1) - (F - expected1) / 6) < 1e-9);
    before = after;
    F1 = F;
    expected1 = expected;
  }
  BOOST_TEST(F1 != 0.0);
}

BOOST_AUTO_TEST_CASE(early_forecasts_keep_c2_and_late_ones_keep_the_value) {
  for (const PeriodMode mode : {PeriodMode::last, PeriodMode::mean}) {
    Driven spline(BSpline::Join::continuous, BSpline::ControlPoints::predicted, mode);
    Dice draw(5);
    Time now = at(0);
    ForceSegment before = spline.feed(now, {}, {});
    int early = 0;
    int late = 0;
    for (int k = 0; k < 2000; ++k) {
      now = now + Duration::from_seconds(T * std::exp(draw(-1, 1)));
      const ForceSegment after = spline.feed(now, along_x(draw.normal()), along_x(draw.normal()));
      const bool in_time = now <= before.end;
      (in_time ? early : late) += 1;
      BOOST_TEST(std::abs(evaluate(after, now).force.x - evaluate(before, now).force.x) < 1e-12);
      const double s = normalised_time(before, now);
      for (int d = 1; d < 3; ++d) {
        const double expected = in_time ? derivative(before, d, s) : 0.0;
        BOOST_TEST(std::abs(derivative(after, d, 0) - expected) <= 1e-10 * std::abs(expected));
      }
      before = after;
    }
    BOOST_TEST(early > 100);
    BOOST_TEST(late > 100);
  }
}

BOOST_AUTO_TEST_CASE(hermite_joins_keep_c1_and_end_where_the_printed_segment_ends) {
  for (const BSpline::ControlPoints points : {BSpline::ControlPoints::mixed, BSpline::ControlPoints::predicted}) {
    Driven spline(BSpline::Join::hermite, points);
    Driven printed(BSpline::Join::paper, points);
    Dice draw(7);
    Time now = at(0);
    ForceSegment before = spline.feed(now, {}, {});
    printed.feed(now, {}, {});
    for (int k = 0; k < 2000; ++k) {
      now = now + Duration::from_seconds(T * std::exp(draw(-1, 1)));
      const Wrench current = along_x(draw.normal());
      const Wrench predicted = along_x(draw.normal());
      const ForceSegment after = spline.feed(now, current, predicted);
      const ForceSegment goal = printed.feed(now, current, predicted);
      BOOST_TEST(std::abs(evaluate(after, now).force.x - evaluate(before, now).force.x) < 1e-12);
      const double slope = now <= before.end ? derivative(before, 1, normalised_time(before, now)) : 0.0;
      BOOST_TEST(std::abs(derivative(after, 1, 0) - slope) <= 1e-10 * std::abs(slope));
      BOOST_TEST(std::abs(derivative(after, 0, 1) - derivative(goal, 0, 1)) < 1e-9);
      BOOST_TEST(std::abs(derivative(after, 1, 1) - derivative(goal, 1, 1)) * T < 1e-9);
      before = after;
    }
  }
}

BOOST_AUTO_TEST_CASE(joined_curves_stay_bounded_on_uneven_arrivals) {
  for (const auto& [join, mode] :
       {std::pair(BSpline::Join::continuous, PeriodMode::last), std::pair(BSpline::Join::continuous, PeriodMode::mean),
        std::pair(BSpline::Join::hermite, PeriodMode::last), std::pair(BSpline::Join::hermite, PeriodMode::mean)}) {
    for (const double spread : {0.0, 0.1, 0.7, 1.5, 3.0}) {
      Driven spline(join, BSpline::ControlPoints::predicted, mode);
      Dice draw(6);
      Time now = at(0);
      ForceSegment before = spline.feed(now, {}, {});
      double largest = 0;
      for (int k = 0; k < 20000; ++k) {
        const Time next = now + Duration::from_seconds(T * std::exp(spread * draw(-1, 1)));
        for (int i = 0; i <= 8; ++i) {
          const Time t{now.ns + (next - now).ns * i / 8};
          largest = std::max(largest, std::abs(evaluate(before, t).force.x));
        }
        now = next;
        before = spline.feed(now, {}, along_x(draw(-1, 1) > 0 ? 1 : -1));
      }
      BOOST_TEST_MESSAGE("join " << static_cast<int>(join) << " mode " << static_cast<int>(mode) << " spread " << spread
                                 << " largest " << largest);
      BOOST_TEST(largest < 2.0, "largest " << largest << " at a spread of " << spread);
    }
  }
}

BOOST_AUTO_TEST_CASE(no_torque_is_interpolated_in_a_translation_only_scene) {
  for (const BSpline::Join join : {BSpline::Join::paper, BSpline::Join::hermite, BSpline::Join::continuous}) {
    Driven spline(join, BSpline::ControlPoints::mixed, PeriodMode::last, false);
    for (int k = 0; k < 10; ++k) {
      const ForceSegment g = spline.feed(at(k * T), along_x(k), along_x(k + 1));
      for (const Wrench& c : g.c) BOOST_TEST(norm(c.torque) == 0.0);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_force_that_is_not_finite_is_passed_on_and_forgotten) {
  for (const auto join : {BSpline::Join::paper, BSpline::Join::hermite, BSpline::Join::continuous}) {
    Driven clean(join), hit(join);
    for (int k = 0; k < 6; ++k) {
      for (Driven* driven : {&clean, &hit}) driven->feed(at(k * T), along_x(k), along_x(k + 1));
    }
    const double nan = std::nan("");
    for (const auto& [current, predicted] : {std::pair{along_x(nan), along_x(7)}, {along_x(6), along_x(INFINITY)}}) {
      BOOST_TEST(!is_finite(evaluate(hit.feed(at(6 * T), current, predicted), at(6.5 * T))));
    }
    // The sequence of good forecasts is the same for both, and so is what they give.
    const ForceSegment a = clean.feed(at(6 * T), along_x(6), along_x(7));
    const ForceSegment b = hit.feed(at(6 * T), along_x(6), along_x(7));
    for (std::size_t i = 0; i < 4; ++i) BOOST_TEST(std::abs(a.c[i].force.x - b.c[i].force.x) < 1e-12);
  }
}

BOOST_AUTO_TEST_SUITE_END()
