// The device's end of a wave line, with far ends whose answers are known in closed form.
#include <array>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <deque>
#include <numbers>

#include "nodes/passivity/wave_end.hpp"
#include "tests/support/force_stream.hpp"

BOOST_AUTO_TEST_SUITE(wave_end_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr Duration tick{1'000'000};
constexpr double T = 1e-3;  // s

Time at_tick(int n) {
  return Time{} + tick * n;
}

/// A line with a far end that answers each `every` ticks, and whose answer is at the device `delay` ticks later.
struct Line {
  Line(double b, int delay_ticks, int period_ticks = 1, double catch_up = 1e3)
      : end(b, T, catch_up), delay(delay_ticks), every(period_ticks) {
    end.start(at_tick(0), {});
  }
  /// The handle has gone on by `way` at the velocity `v`, in the tick that ends with number n. `tool_way` says how far
  /// the tool goes in a tick in which the outgoing wave goes by that. Returns the force of the tick that begins next.
  template <class ToolWay>
  Vec3 advance(int n, const Vec3& way, const Vec3& v, ToolWay tool_way) {
    end.advance(at_tick(n), way, acting);
    given += dot(acting, way);
    const Vec3 out = end.outgoing();
    tool += tool_way(out - handle);
    handle = out;
    if (n % every == 0) under_way.push_back({at_tick(n), tool, out});
    if (!under_way.empty() && under_way.front().at <= at_tick(n - delay)) {
      far_force = end.arrive(under_way.front(), at_tick(n));
      under_way.pop_front();
    }
    acting = next;
    next = end.force(std::array{acting}, v);
    return next;
  }

  WaveEnd end;
  int delay, every;
  std::deque<WaveEnd::Result> under_way;
  Vec3 tool, handle;
  Vec3 acting, next;  // N, in the tick that begins now, and in the one after it
  Vec3 far_force;
  double given = 0;  // J, by the motors
};

}  // namespace

BOOST_AUTO_TEST_CASE(in_each_tick_the_line_takes_in_what_the_hand_gives) {
  Dice draw(1);
  for (const double b : {0.5, 20.0}) {
    WaveEnd end(b, T, 0.05);
    end.start(at_tick(0), {});
    Vec3 place;
    double given = 0;
    Time at;
    for (int i = 0; i < 500; ++i) {
      const Vec3 way = draw.normal_vector(1e-4), force = draw.normal_vector(3);
      at = at + Duration::from_seconds(draw(0.2e-3, 3e-3));
      end.advance(at, way, force);
      place += way;
      given += dot(force, way);
      BOOST_TEST(std::abs(end.energy_out() - end.energy_played() + given) < 1e-12 * end.energy_out());
      BOOST_TEST(norm(end.outgoing() + end.incoming() - 2 * place) < 1e-12, "no place drifts");
    }
  }
}

BOOST_AUTO_TEST_CASE(a_line_whose_tool_stands_keeps_all_that_leaves) {
  Dice draw(2);
  WaveEnd end(10, T, 0.05);
  end.start(at_tick(0), {});
  double out_by = 0;
  for (int n = 1, next = 7; n < 2000; ++n) {
    end.advance(at_tick(n), draw.normal_vector(1e-4), draw.normal_vector(2));
    if (n != next) continue;
    // Uneven results. All of the wave turns back, whatever it was within the period.
    next += 1 + static_cast<int>(draw(3, 25));
    out_by = end.energy_out();
    end.arrive({at_tick(n), {}, end.outgoing()}, at_tick(n));
    BOOST_TEST(std::abs(end.energy_brought() - out_by) < 1e-12 * out_by);
  }
}

BOOST_AUTO_TEST_CASE(a_matched_line_answers_a_step_from_a_spring_as_the_closed_form_says) {
  // The handle goes off with V. The tool hangs on a spring k without mass: b (v_out - x') = k x. With R the time there
  // and back, F = -b V until R, and from then until 2 R, by v_out = 2 V, F = b V (4 exp(-k (t - R) / b) - 3).
  constexpr double b = 10, k = 2000, V = 0.05;
  for (const int delay : {20, 60}) {
    Line line(b, delay);
    const double stays = std::exp(-k * T / b);
    constexpr int first = 2;           // the tick in which it goes off: two later than its force is asked for
    const double R = (delay + 2) * T;  // what leaves in a tick is played in one, two ticks after it would have been
    for (int n = 1; n < 2 * delay; ++n) {
      const Vec3 way{n > first ? V * T : 0, 0, 0};
      const Vec3 next = line.advance(n, way, {V, 0, 0}, [&](const Vec3& out) {
        // Exact, with the outgoing wave steady in the tick.
        const double rest = out.x / T * b / k;
        return Vec3{(rest - line.tool.x) * (1 - stays), 0, 0};
      });
      const double t = (n + 1.5 - first) * T;  // from when it went off to the middle of the tick in which `next` acts
      if (t < R) {
        BOOST_TEST(std::abs(next.x + b * V) < 1e-9, "the line is a damper until something is back");
      } else if (t > R + 3 * T) {  // the first that is played is less by the reserve
        const double expected = b * V * (4 * std::exp(-k * (t - R) / b) - 3);
        BOOST_TEST(std::abs(next.x - expected) < 0.03 * b * V, n << ": " << next.x << " for " << expected);
      }
    }
    BOOST_TEST(line.given <= 0);
  }
}

BOOST_AUTO_TEST_CASE(what_meets_a_damper_of_the_impedance_does_not_come_back) {
  constexpr double b = 10, V = 0.05;
  Line line(b, 20);
  for (int n = 1; n < 200; ++n) {
    // b (v_out - v_T) = b v_T
    const Vec3 next = line.advance(n, {V * T, 0, 0}, {V, 0, 0}, [](const Vec3& out) { return 0.5 * out; });
    BOOST_TEST(std::abs(next.x + b * V) < 1e-9);
    if (n > 23) BOOST_TEST(std::abs(line.far_force.x + b * V) < 1e-9, "the far end feels the same force");
  }
}

BOOST_AUTO_TEST_CASE(moved_freely_the_line_is_a_mass_of_impedance_by_half_the_time_there_and_back) {
  // A tool without mass goes with the wave: v_in(t) = v_out(t - 2 D). Where the handle is accelerated by a steadily,
  // the mean of F over the time there and back is -b D a; about it the line rings.
  constexpr double b = 10, a = 0.5;
  for (const int delay : {10, 40}) {
    Line line(b, delay);
    const int there_and_back = delay + 2;
    double sum = 0;
    for (int n = 1; n <= 12 * there_and_back; ++n) {
      // The tick that the force is for is two after the one that has ended; each goes by the velocity of its middle.
      const auto v = [](int tick_number) { return Vec3{a * (tick_number - 0.5) * T, 0, 0}; };
      const Vec3 force = line.advance(n, T * v(n), v(n + 2), [](const Vec3& out) { return out; });
      if (n > 2 * there_and_back) sum += force.x;
      BOOST_TEST(line.given <= 0);
    }
    const double expected = -b * 0.5 * there_and_back * T * a, mean = sum / (10 * there_and_back);
    BOOST_TEST(std::abs(mean - expected) < 0.1 * std::abs(expected), mean << " N for " << expected);
  }
}

BOOST_AUTO_TEST_CASE(at_rest_the_line_is_a_spring_of_impedance_over_half_the_time_there_and_back) {
  // Handle and hand of 0.3 kg and 10 N s/m are pressed against a tool that stands.
  constexpr double b = 5, mass = 0.3, damping = 10, push = 2;
  for (const int delay : {10, 50}) {
    Line line(b, delay, 10, 0.05);
    double x = 0, v = 0;
    for (int n = 1; n < 20000; ++n) {
      v += T / mass * (line.acting.x + push - damping * v);
      x += T * v;
      line.advance(n, {T * v, 0, 0}, {v, 0, 0}, [](const Vec3&) { return Vec3{}; });
    }
    // A part of the wave leaves, half a period before the result that tells of it in the mean. That is here `delay`
    // ticks later, and it is played from the tick after, half a period later in the mean.
    const double half = 0.5 * (delay + 10 + 1) * T;
    BOOST_TEST(std::abs(-line.acting.x - push) < 1e-3 * push);
    BOOST_TEST(std::abs(push / x - b / half) < 0.1 * b / half, push / x << " N/m for " << b / half);
    BOOST_TEST(line.given <= 0);
  }
}

BOOST_AUTO_TEST_CASE(a_far_end_that_gives_energy_cannot_give_more_than_left) {
  Dice draw(5);
  WaveEnd end(10, T, 0.05);
  end.start(at_tick(0), {});
  Vec3 acting, next;
  double given = 0, most = 0, allowed = 0;
  for (int n = 1; n < 5000; ++n) {
    // A hand that goes to and fro, and a tool that is driven on its own by more.
    const double phase = 2 * std::numbers::pi * n * T;
    const Vec3 v{0.02 * std::cos(3 * phase), 0.01 * std::sin(2 * phase), 0};
    const Vec3 way = T * v;
    end.advance(at_tick(n), way, acting);
    given += dot(acting, way);
    most = std::max(most, given);
    allowed = std::max(allowed, std::abs(dot(acting, way)));
    if (n % 12 == 0) {
      end.arrive({at_tick(n), {0.02 * std::sin(5 * phase), 0, 0.01 * draw.normal()}, end.outgoing()}, at_tick(n));
      BOOST_TEST(end.energy_brought() <= end.energy_out());
    }
    acting = next;
    next = end.force(std::array{acting}, v);
  }
  BOOST_TEST(end.energy_brought() > 0.9 * end.energy_out(), "it would give more if it could");
  BOOST_TEST(most <= allowed, most << " J of " << allowed);
}

BOOST_AUTO_TEST_CASE(a_result_is_played_once_and_then_leaves_the_damper) {
  constexpr double b = 10;
  WaveEnd end(b, T, 0.05);
  end.start(at_tick(0), {});
  // Against the damper, so that nothing is played before.
  for (int n = 1; n <= 10; ++n) end.advance(at_tick(n), {1e-4, 0, 0}, {-1, 0, 0});
  end.arrive({at_tick(10), {}, end.outgoing()}, at_tick(10));
  const double brought = end.energy_brought();
  BOOST_TEST(std::abs(brought - 10 * b * 1e-8 / T) < 1e-12);
  Vec3 acting, next = end.force(std::array{Vec3{}}, {});
  for (int n = 11; n < 200; ++n) {
    end.advance(at_tick(n), {}, acting);  // the handle stands
    acting = next;
    next = end.force(std::array{acting}, {});
    BOOST_TEST(end.energy_played() <= brought * (1 + 1e-12));
    // The tool stands, so the wave turns round: 2 N, but for a quarter of a period that is kept in reserve.
    if (n > 11 && n < 18) BOOST_TEST(std::abs(acting.x + 2 / std::sqrt(1.25)) < 1e-9);
  }
  BOOST_TEST(norm(next) < 1e-3);
  BOOST_TEST(std::abs(end.force(std::array{Vec3{}}, {0, 0.1, 0}).y + 0.1 * b) < 1e-3);
}

BOOST_AUTO_TEST_SUITE_END()
