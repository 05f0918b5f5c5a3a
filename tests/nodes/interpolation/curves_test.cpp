// Joins and curves of the interpolations that evaluate several steps of a forecast, against closed forms.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <vector>

#include "nodes/interpolation/blend.hpp"
#include "nodes/interpolation/catmull_rom.hpp"
#include "nodes/interpolation/hermite.hpp"
#include "tests/support/force_stream.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(curves_test)

using namespace tactor;
using namespace tactor::test;

namespace {

Duration ms(int n) {
  return Duration{1'000'000} * n;
}

Wrench along(double x) {
  return {{x, 0, -2 * x}, {0, 0.1 * x, 0}};
}

// A cubic force over seconds, with its derivatives.
struct Cubic {
  double value(double t) const { return 1 - 20 * t + 3e3 * t * t - 4e4 * t * t * t; }
  double rate(double t) const { return -20 + 6e3 * t - 1.2e5 * t * t; }
  double curvature(double t) const { return 6e3 - 2.4e5 * t; }
};

// What is forecast of `force` at `stamp`, each step right.
template <class Force>
Stamped<Forecast> right(const Force& force, double stamp_s, double horizon, std::int32_t count, std::uint64_t n = 0) {
  Stamped<Forecast> s;
  s.stamp = {Time::from_seconds(stamp_s), Time::from_seconds(stamp_s), n};
  s.value.current_D_W = along(force(stamp_s));
  s.value.horizon = horizon;
  s.value.count = count;
  for (std::int32_t i = 0; i < count; ++i) {
    s.value.predicted_D_W[static_cast<std::size_t>(i)] = along(force(stamp_s + (i + 1) * horizon));
  }
  return s;
}

Stamped<Forecast> drawn(Dice& draw, double stamp_s, double horizon, std::uint64_t n) {
  return right([&draw](double) { return draw.normal(); }, stamp_s, horizon, Forecast::capacity, n);
}

template <class N>
ForceSegment arrive(N& node, const Stamped<Forecast>& f, Time now) {
  return step_with(node, node.forecast, {f.stamp.valid, now, f.stamp.sequence}, f.value, node.segment);
}

ForceSegment tick(Blend& node, Time now) {
  StepContext c(now);
  node.step(c);
  TACTOR_DEMAND(node.segment.pending() == 1);
  const ForceSegment g = *static_cast<const ForceSegment*>(node.segment.pending_value(0));
  node.segment.clear_pending();
  return g;
}

template <class N>
struct Driven {
  explicit Driven(typename N::Params params = {}) : node(params, context()) {
    node.forecast.configure({QueuePolicy::latest, 1});
  }
  N node;
};

Blend::Params blend_params(Blend::Continuity continuity, double tau = 0.002, CurveShape shape = CurveShape::cubic) {
  return {Duration::from_seconds(tau), shape, continuity, 1000};
}

// The largest jumps between `before` and `after` at `now` of value, slope and curvature, by one-sided differences of
// the displayed force with steps of h = 2 us: slopes to h^2 of the third derivative, curvatures to h^2 of the fourth.
struct Jumps {
  double value, rate, curvature;
};
Jumps jumps(const ForceSegment& before, const ForceSegment& after, Time now) {
  constexpr double h = 2e-6;
  const auto x = [&](const ForceSegment& g, int i) { return evaluate(g, now + Duration{2'000 * i}).force.x; };
  const auto rate = [&](const ForceSegment& g, int side) {
    return side * (-3 * x(g, 0) + 4 * x(g, side) - x(g, 2 * side)) / (2 * h);
  };
  const auto curvature = [&](const ForceSegment& g, int side) {
    return (2 * x(g, 0) - 5 * x(g, side) + 4 * x(g, 2 * side) - x(g, 3 * side)) / (h * h);
  };
  return {std::abs(x(after, 0) - x(before, 0)), std::abs(rate(after, 1) - rate(before, -1)),
          std::abs(curvature(after, 1) - curvature(before, -1))};
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_curve_of_three_steps_is_a_cubic_force_and_its_derivatives) {
  const Cubic force;
  for (const std::int32_t count : {3, 4}) {
    const ForecastCurve curve(right([&](double t) { return force.value(t); }, 0.02, 0.009, count), CurveShape::cubic);
    for (double u = 0; u < count; u += 0.13) {
      const double t = 0.02 + u * 0.009;
      const ForceState s = curve.at(Time::from_seconds(t));
      BOOST_TEST(std::abs(s.value.force.x - force.value(t)) < 1e-10);
      BOOST_TEST(std::abs(s.rate.force.z + 2 * force.rate(t)) < 1e-6);
      BOOST_TEST(std::abs(s.curvature.torque.y - 0.1 * force.curvature(t)) < 1e-3);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_curve_goes_through_its_knots_along_lines_and_is_held_at_both_ends) {
  Dice draw(1);
  for (std::int32_t count = 1; count <= Forecast::capacity; ++count) {
    for (const CurveShape shape : {CurveShape::linear, CurveShape::cubic}) {
      Stamped<Forecast> f = drawn(draw, 0.1, 0.008, 0);
      f.value.count = count;
      const ForecastCurve curve(f, shape);
      const auto knot = [&](int i) {
        return i == 0 ? f.value.current_D_W.force.x : f.value.predicted_D_W[static_cast<std::size_t>(i - 1)].force.x;
      };
      const auto x = [&](double t_ms) { return curve.at(at_ms(t_ms)).value.force.x; };
      for (int i = 0; i <= count; ++i) BOOST_TEST(std::abs(x(100 + 8 * i) - knot(i)) < 1e-6);
      for (int i = 0; i < count && shape == CurveShape::linear; ++i) {
        BOOST_TEST(std::abs(x(100 + 8 * i + 2) - (0.75 * knot(i) + 0.25 * knot(i + 1))) < 1e-12);
      }
      BOOST_TEST(x(50) == knot(0));
      BOOST_TEST(x(100 + 8 * count + 1) == knot(count));
      BOOST_TEST(x(9e3) == knot(count));
      BOOST_TEST(norm(curve.at(at_ms(9e3)).rate.force) == 0.0);
      BOOST_TEST(!curve.is_over(at_ms(100 + 8 * count - 1)));
      BOOST_TEST(curve.is_over(at_ms(100 + 8 * count + 1)));
    }
  }
  Stamped<Forecast> f = drawn(draw, 0.1, 0.0, 0);
  BOOST_TEST(ForecastCurve(f, CurveShape::cubic).at(at_ms(101)).value.force.x == f.value.predicted_D_W[3].force.x);
}

BOOST_AUTO_TEST_CASE(hermite_segments_reproduce_a_cubic_force) {
  // Forecasts of a cubic force arrive a period late; from the second segment on the displayed force is that force.
  const Cubic force;
  const auto follow = [&](auto& node) {
    for (int k = 0; k < 6; ++k) {
      const Time now = at_ms(10.0 * (k + 1));
      const ForceSegment g = arrive(
          node, right([&](double t) { return force.value(t); }, 0.01 * k, 0.01, 4, static_cast<std::uint64_t>(k)), now);
      if (k == 0) continue;
      for (double u = 0; u <= 1; u += 0.1) {
        const double t = 0.01 * (k + 1 + u);
        BOOST_TEST(std::abs(evaluate(g, Time::from_seconds(t)).force.x - force.value(t)) < 1e-9);
      }
    }
  };
  Driven<HermiteCubic> cubic;
  Driven<HermiteQuintic> quintic;
  follow(cubic.node);
  follow(quintic.node);
}

BOOST_AUTO_TEST_CASE(a_quintic_has_the_values_slopes_and_curvatures_of_both_ends) {
  Dice draw(3);
  const auto state = [&draw] {
    return ForceState{along(draw.normal()), along(draw.normal(100)), along(draw.normal(1e4))};
  };
  for (int i = 0; i < 20; ++i) {
    const ForceState a = state();
    const ForceState b = state();
    const Time begin = at_ms(5);
    const ForceSegment g = quintic_between(begin, ms(8), a, b);
    const ForceSegment c = cubic_between(begin, ms(8), a, b);
    const ForceState at_begin = displayed(g, begin);
    const ForceState at_end = displayed(g, g.end);
    const ForceState cubic_end = displayed(c, c.end);
    for (const auto& [x, y] : {std::pair{at_begin, a}, {at_end, b}}) {
      BOOST_TEST(norm((x - y).value.force) < 1e-12);
      BOOST_TEST(norm((x - y).rate.force) < 1e-9);
      BOOST_TEST(norm((x - y).curvature.force) < 1e-6);
    }
    BOOST_TEST(norm((cubic_end - b).value.force) < 1e-12);
    BOOST_TEST(norm((cubic_end - b).rate.force) < 1e-9);
    BOOST_TEST(norm(displayed(g, g.end + ms(1)).rate.force) == 0.0);
  }
}

BOOST_AUTO_TEST_CASE(hermite_joins_are_smooth_whether_forecasts_come_early_on_time_or_late) {
  const auto follow = [](auto& node, bool quintic) {
    Dice draw(4);
    Time now = at_ms(100);
    ForceSegment before = arrive(node, drawn(draw, 0.09, 0.01, 0), now);
    for (std::uint64_t k = 1; k < 60; ++k) {
      const double kind = draw(0, 3);
      const Duration wait = kind < 1   ? before.end - before.begin
                            : kind < 2 ? Duration::from_seconds(draw(0.004, 0.009))
                                       : Duration::from_seconds(draw(0.012, 0.03));
      const bool late = kind >= 2;
      now = now + wait;
      const ForceSegment after = arrive(node, drawn(draw, now.seconds() - 0.01, 0.01, k), now);
      const Jumps j = jumps(before, after, now);
      BOOST_TEST(j.value < 1e-12);
      // A held end is at rest: what follows starts there with no slope, which is C1 (and C2) with what was shown last.
      const double slope = late ? std::abs(evaluate_rate(after, now).force.x) : j.rate;
      BOOST_TEST(slope < 0.5, "step " << k);
      const double curvature = late ? std::abs(evaluate_curvature(after, now).force.x) : j.curvature;
      if (quintic) BOOST_TEST(curvature < 2e3, "step " << k);
      before = after;
    }
  };
  Driven<HermiteCubic> cubic;
  Driven<HermiteQuintic> quintic;
  follow(cubic.node, false);
  follow(quintic.node, true);
}

BOOST_AUTO_TEST_CASE(catmull_rom_is_its_own_formula) {
  for (const CatmullRom::Start start : {CatmullRom::Start::current, CatmullRom::Start::predicted}) {
    for (const std::int32_t count : {1, 2, 3, 4}) {
      Driven<CatmullRom> driven(CatmullRom::Params{start});
      CatmullRom& node = driven.node;
      Dice draw(5);
      double last = 0;
      for (std::uint64_t k = 0; k < 10; ++k) {
        Stamped<Forecast> f = drawn(draw, 0.01 * static_cast<double>(k), 0.008, k);
        f.value.count = count;
        const Time now = at_ms(10.0 * static_cast<double>(k) + 9);
        const ForceSegment g = arrive(node, f, now);
        const double current = f.value.current_D_W.force.x;
        if (k == 0) last = current;
        const auto step = [&](int i) {
          return f.value.predicted_D_W[static_cast<std::size_t>(std::min(i, count) - 1)].force.x;
        };
        const std::vector<double> P = start == CatmullRom::Start::current
                                          ? std::vector<double>{last, current, step(1), step(2)}
                                          : std::vector<double>{current, step(1), step(2), step(3)};
        for (double u = 0; u <= 1; u += 0.125) {
          // By weights of the four points, u = 0 at now, 1 one period of 8 ms later.
          const double w0 = -0.5 * u + u * u - 0.5 * u * u * u;
          const double w1 = 1 - 2.5 * u * u + 1.5 * u * u * u;
          const double w2 = 0.5 * u + 2 * u * u - 1.5 * u * u * u;
          const double w3 = -0.5 * u * u + 0.5 * u * u * u;
          const double x = evaluate(g, now + Duration{static_cast<std::int64_t>(8'000'000 * u)}).force.x;
          BOOST_TEST(std::abs(x - (w0 * P[0] + w1 * P[1] + w2 * P[2] + w3 * P[3])) < 1e-12);
        }
        BOOST_TEST(std::abs(evaluate(g, now + ms(50)).force.x - P[2]) < 1e-12);
        last = current;
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(blend_shows_a_right_forecast_as_it_is) {
  const Cubic force;
  for (const Blend::Continuity continuity : {Blend::Continuity::c1, Blend::Continuity::c2}) {
    Driven<Blend> driven(blend_params(continuity, 0.001));
    Blend& node = driven.node;
    std::uint64_t arrived = 0;
    for (int k = 0; k < 70; ++k) {
      // Forecasts of an uneven period: stamped at 0, 7, 14, ... ms, they arrive 7 to 12 ms later.
      while (7.0 * static_cast<double>(arrived) + 7 + static_cast<double>(arrived % 3) * 2.5 <= k) {
        const auto f =
            right([&](double t) { return force.value(t); }, 7e-3 * static_cast<double>(arrived), 0.007, 4, arrived);
        node.forecast.push(f.stamp, &f.value);
        ++arrived;
      }
      if (arrived == 0) continue;
      const ForceSegment g = tick(node, at_ms(k));
      // The start from zero has decayed after thirty time constants.
      const double t = 1e-3 * k;
      if (k > 40) BOOST_TEST(std::abs(evaluate(g, at_ms(k)).force.x - force.value(t)) < 1e-7);
    }
  }
}

BOOST_AUTO_TEST_CASE(blend_decays_as_two_or_three_equal_poles_do) {
  // A constant of 0 becomes one of 1: what is left of the difference is (1 + s) exp(-s) or (1 + s + s^2 / 2) exp(-s).
  constexpr double tau = 0.003;
  for (const Blend::Continuity continuity : {Blend::Continuity::c1, Blend::Continuity::c2}) {
    Driven<Blend> driven(blend_params(continuity, tau));
    Blend& node = driven.node;
    const auto zero = right([](double) { return 0.0; }, 0, 0.01, 4, 0);
    const auto one = right([](double) { return 1.0; }, 0.01, 0.01, 4, 1);
    node.forecast.push(zero.stamp, &zero.value);
    for (int k = 0; k < 20; ++k) tick(node, at_ms(k));
    node.forecast.push(one.stamp, &one.value);
    for (int k = 20; k < 60; ++k) {
      const ForceSegment g = tick(node, at_ms(k));
      const double s = 1e-3 * (k - 20) / tau;
      const double left = (1 + s + (continuity == Blend::Continuity::c2 ? 0.5 * s * s : 0.0)) * std::exp(-s);
      BOOST_TEST(std::abs(1 - evaluate(g, at_ms(k)).force.x - left) < 1e-12);
    }
  }
}

BOOST_AUTO_TEST_CASE(blended_joins_are_smooth_whenever_forecasts_arrive_and_nothing_jumps_after_missed_ticks) {
  for (const Blend::Continuity continuity : {Blend::Continuity::c1, Blend::Continuity::c2}) {
    for (const CurveShape shape : {CurveShape::linear, CurveShape::cubic}) {
      Driven<Blend> driven(blend_params(continuity, 0.002, shape));
      Blend& node = driven.node;
      Dice draw(6);
      std::uint64_t n = 0;
      ForceSegment before = arrive(node, drawn(draw, 0, 0.01, n), at_ms(10));
      double arrival = 10;
      double largest = 0;
      double now_ms = 10;
      while (now_ms < 2000) {
        // Early and late forecasts, 3 to 60 ms apart, 2 to 30 ms after their stamps, most of them between two ticks.
        double next = std::floor(now_ms) + (draw(0, 1) < 0.05 ? 3 : 1);
        const bool arrives = arrival <= next;
        if (arrives) next = std::max(arrival, now_ms + 0.01);
        now_ms = next;
        const Time now = at_ms(now_ms);
        ForceSegment after;
        if (arrives) {
          after = arrive(node, drawn(draw, 1e-3 * (arrival - draw(2, 30)), 0.01, ++n), now);
          arrival = now_ms + draw(3, 60);
        } else {
          after = tick(node, now);
        }
        const bool missed = now > before.end;
        const Jumps j = jumps(before, after, now);
        BOOST_TEST(j.value < 1e-12);
        const double rate = missed ? std::abs(evaluate_rate(after, now).force.x) : j.rate;
        BOOST_TEST(rate < 1, "at " << now_ms << " ms");
        const double curvature = missed ? std::abs(evaluate_curvature(after, now).force.x) : j.curvature;
        if (continuity == Blend::Continuity::c2) BOOST_TEST(curvature < 2e3, "at " << now_ms << " ms");
        largest = std::max(largest, j.curvature);
        before = after;
      }
      // The difference test sees what c1 does not promise.
      if (continuity == Blend::Continuity::c1) BOOST_TEST(largest > 1e5);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_late_forecast_is_held_at_its_last_step_and_counted) {
  Driven<Blend> driven(blend_params(Blend::Continuity::c1, 0.0005));
  Blend& node = driven.node;
  const auto f = right([](double t) { return 100 * t; }, 0, 0.01, 3, 0);
  node.forecast.push(f.stamp, &f.value);
  ForceSegment g;
  for (int k = 10; k <= 80; ++k) g = tick(node, at_ms(k));
  BOOST_TEST(std::abs(evaluate(g, at_ms(80)).force.x - 3) < 1e-9);
  const Report report = report_of(node);
  // From 31 ms to 80 ms.
  BOOST_TEST(report.metrics().at(0).second == 50.0);
}

BOOST_AUTO_TEST_SUITE_END()
