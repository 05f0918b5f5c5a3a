// Trajectories pass their way-points, their velocities are their derivatives, and tremor keeps to its band and size.
#include "nodes/source/trajectory.hpp"

#include <unistd.h>

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "framework/core/check.hpp"

BOOST_AUTO_TEST_SUITE(trajectory_test)

using namespace tactor;

namespace {

constexpr double pi = std::numbers::pi;

const Table bent{7, {0.1, 0, 0,    0,    0,   0,    0,     //
                     0.5, 1, -0.5, 0.25, 0.3, -0.2, 1.1,   //
                     1.3, 0, 0.5,  0.25, 0.9, 0.4,  -0.7,  //
                     1.5, 2, 0,    0,    0,   0,    0.2}};

TrajectorySource::Params params_of(const Table& points, PathKind kind, double tremor = 0) {
  TrajectorySource::Params params;
  params.points = points;
  params.interpolation = kind;
  params.tremor_amplitude = tremor;
  params.tremor_low = 8;
  params.tremor_high = 12;
  params.tremor_components = 16;
  return params;
}

const Scene scene;

NodeContext context_of(std::uint64_t seed = 1, bool torque = true) {
  NodeContext context;
  context.name = "hand";
  context.scene = &scene;
  context.seed = seed;
  context.torque = torque;
  return context;
}

double distance(const Vec3& a, const Vec3& b) {
  return norm(a - b);
}
double angle_between(const Quat& a, const Quat& b) {
  return norm(to_rotation_vector(a * inverse(b)));
}

struct TemporaryFile {
  explicit TemporaryFile(const std::string& text) {
    std::string name = (std::filesystem::temp_directory_path() / "tactor_XXXXXX").string();
    const int descriptor = mkstemp(name.data());
    BOOST_REQUIRE(descriptor >= 0);
    ::close(descriptor);
    path = name;
    std::ofstream(path) << text;
  }
  ~TemporaryFile() { std::filesystem::remove(path); }
  std::filesystem::path path;
};

void check_refused(const TrajectorySource::Params& params, const std::string& expected) {
  try {
    const TrajectorySource source(params, context_of());
    BOOST_ERROR("accepted, expected: " + expected);
  } catch (const InputError& e) {
    BOOST_TEST(std::string(e.what()).find(expected) != std::string::npos, e.what() << " lacks " << expected);
  }
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_kind_of_path_passes_its_way_points) {
  for (const PathKind kind : {PathKind::minimum_jerk, PathKind::linear, PathKind::cubic}) {
    const TrajectorySource source(params_of(bent, kind), context_of());
    for (std::size_t i = 0; i < bent.rows(); ++i) {
      const Target at = source.at(bent.at(i, 0));
      BOOST_TEST(distance(at.X_WH.p, {bent.at(i, 1), bent.at(i, 2), bent.at(i, 3)}) < 1e-14);
      BOOST_TEST(angle_between(at.X_WH.R, from_rotation_vector({bent.at(i, 4), bent.at(i, 5), bent.at(i, 6)})) < 1e-14);
      if (kind == PathKind::minimum_jerk) {
        BOOST_TEST(norm(at.V_WH.v) < 1e-14);
        BOOST_TEST(norm(at.V_WH.w) < 1e-14);
      }
    }
    for (const double outside : {0.0, 0.0999, 1.5, 99.0}) {
      const Target at = source.at(outside);
      BOOST_TEST(norm(at.V_WH.v) == 0.0);
      BOOST_TEST(at.X_WH.p.x == (outside < 1 ? 0.0 : 2.0));
    }
  }
}

BOOST_AUTO_TEST_CASE(minimum_jerk_has_its_closed_form_halfway) {
  const TrajectorySource source(params_of({7, {0, 0, 0, 0, 0, 0, 0, 2, 0.4, 0, 0, 0, 0, 0}}, PathKind::minimum_jerk),
                                context_of());
  BOOST_TEST(std::abs(source.at(1).X_WH.p.x - 0.2) < 1e-15);
  // Peak speed 15/8 of the mean.
  BOOST_TEST(std::abs(source.at(1).V_WH.v.x - 1.875 * 0.2) < 1e-15);
  const double tau = 0.3;
  BOOST_TEST(std::abs(source.at(0.6).X_WH.p.x -
                      0.4 * (10 * std::pow(tau, 3) - 15 * std::pow(tau, 4) + 6 * std::pow(tau, 5))) < 1e-15);
}

BOOST_AUTO_TEST_CASE(velocities_are_the_derivatives_of_the_motion) {
  for (const PathKind kind : {PathKind::minimum_jerk, PathKind::linear, PathKind::cubic}) {
    const TrajectorySource source(params_of(bent, kind, 0.001), context_of());
    const double h = 1e-5;
    for (double t = 0.1037; t < 1.5; t += 0.0171) {
      const Target before = source.at(t - h);
      const Target after = source.at(t + h);
      const Target at = source.at(t);
      BOOST_TEST(distance((after.X_WH.p - before.X_WH.p) / (2 * h), at.V_WH.v) < 1e-6);
      BOOST_TEST(distance(to_rotation_vector(after.X_WH.R * inverse(before.X_WH.R)) / (2 * h), at.V_WH.w) < 1e-6);
    }
  }
}

BOOST_AUTO_TEST_CASE(rotation_takes_the_shorter_arc) {
  const double a = 170 * pi / 180;
  for (const PathKind kind : {PathKind::minimum_jerk, PathKind::linear, PathKind::cubic}) {
    const TrajectorySource source(params_of({7, {0, 0, 0, 0, 0, 0, a, 1, 0, 0, 0, 0, 0, -a}}, kind), context_of());
    BOOST_TEST(angle_between(source.at(0.5).X_WH.R, from_rotation_vector({0, 0, pi})) < 1e-12);
  }
}

BOOST_AUTO_TEST_CASE(the_spline_is_the_natural_one) {
  // Through (0,0), (1,1), (2,0): second derivative -3 in the middle, 0 at the ends; y(1/2) = 11/16.
  const TrajectorySource source(
      params_of({7, {0, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0}}, PathKind::cubic), context_of());
  BOOST_TEST(std::abs(source.at(0.5).X_WH.p.x - 11.0 / 16) < 1e-15);
  BOOST_TEST(std::abs(source.at(0).V_WH.v.x - 1.5) < 1e-15);
  BOOST_TEST(std::abs(source.at(1).V_WH.v.x) < 1e-15);

  const TrajectorySource longer(params_of(bent, PathKind::cubic), context_of());
  const auto acceleration = [&](double t) {
    const double h = 1e-6;
    return (longer.at(t + h).V_WH.v - longer.at(t - h).V_WH.v) / (2 * h);
  };
  for (const double knot : {0.5, 1.3}) {
    BOOST_TEST(distance(acceleration(knot - 2e-6), acceleration(knot + 2e-6)) < 0.01);
  }
  BOOST_TEST(norm(acceleration(0.1 + 2e-6)) < 0.01);
}

BOOST_AUTO_TEST_CASE(tremor_has_the_size_asked_for_on_each_axis) {
  const double rms = 0.002;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Tremor tremor(rms, 8, 12, 16, seed);
    Vec3 square;
    const int n = 60'000;
    for (int i = 0; i < n; ++i) {
      const Vec3 p = tremor.at(i / 41.3).p;
      for (int axis = 0; axis < 3; ++axis) square[axis] += p[axis] * p[axis] / n;
    }
    for (int axis = 0; axis < 3; ++axis) BOOST_TEST(std::abs(std::sqrt(square[axis]) / rms - 1) < 0.05);
  }
}

BOOST_AUTO_TEST_CASE(tremor_stays_within_its_band) {
  const Tremor tremor(0.001, 8, 12, 16, 5);
  const int n = 6400;
  const double rate = 100;
  std::vector<double> windowed(n);
  for (int i = 0; i < n; ++i) windowed[std::size_t(i)] = tremor.at(i / rate).p.x * (1 - std::cos(2 * pi * i / n));
  double inside = 0;
  double outside = 0;
  for (int bin = 0; bin < n / 2; ++bin) {
    // Goertzel's recurrence for one frequency.
    const double c = 2 * std::cos(2 * pi * bin / n);
    double s1 = 0;
    double s2 = 0;
    for (const double x : windowed) {
      const double s0 = x + c * s1 - s2;
      s2 = s1;
      s1 = s0;
    }
    const double power = s1 * s1 + s2 * s2 - c * s1 * s2;
    const double frequency = bin * rate / n;
    (frequency > 7.9 && frequency < 12.1 ? inside : outside) += power;
  }
  BOOST_TEST(inside > 0.0);
  BOOST_TEST(outside < 1e-5 * inside);
}

BOOST_AUTO_TEST_CASE(the_motion_is_the_same_at_every_rate_and_another_with_another_seed) {
  TrajectorySource slow(params_of(bent, PathKind::minimum_jerk, 0.001), context_of(7));
  TrajectorySource fast(params_of(bent, PathKind::minimum_jerk, 0.001), context_of(7));
  TrajectorySource other(params_of(bent, PathKind::minimum_jerk, 0.001), context_of(8));
  for (std::int64_t i = 0; i < 20'000; ++i) {
    StepContext now(Time{i * 100'000});
    fast.step(now);
    BOOST_REQUIRE(fast.target.pending() == 1U);
    if (i % 10 == 0) {
      slow.step(now);
      other.step(now);
      BOOST_TEST(slow.target.pending_valid(0).ns == now.now().ns);
      const auto& a = *static_cast<const Target*>(slow.target.pending_value(0));
      const auto& b = *static_cast<const Target*>(fast.target.pending_value(0));
      const auto& c = *static_cast<const Target*>(other.target.pending_value(0));
      BOOST_REQUIRE((a.X_WH == b.X_WH && a.V_WH.v == b.V_WH.v));
      BOOST_REQUIRE(!(a.X_WH == c.X_WH));
      slow.target.clear_pending();
      other.target.clear_pending();
    }
    fast.target.clear_pending();
  }
}

BOOST_AUTO_TEST_CASE(a_tool_that_cannot_rotate_gets_no_rotation) {
  const TrajectorySource source(params_of(bent, PathKind::minimum_jerk), context_of(1, false));
  BOOST_TEST((source.at(0.9).X_WH.R == Quat{}));
  BOOST_TEST(norm(source.at(0.9).V_WH.w) == 0.0);
}

BOOST_AUTO_TEST_CASE(a_file_gives_the_path_of_the_table_in_any_units) {
  const TemporaryFile file(
      "x_mm,t [ms],rz [deg],y_cm\n"
      "0,100,0,0\n"
      "1000, 500 ,90,-50\r\n"
      "-2e2,1.3e3,0.5,50\n\n");
  TrajectorySource::Params params = params_of({}, PathKind::minimum_jerk);
  params.file = file.path;
  const TrajectorySource from_file(params, context_of());
  const TrajectorySource from_table(params_of({7, {0.1, 0,    0,    0, 0, 0, 0,       //
                                                   0.5, 1,    -0.5, 0, 0, 0, pi / 2,  //
                                                   1.3, -0.2, 0.5,  0, 0, 0, 0.5 * pi / 180}},
                                              PathKind::minimum_jerk),
                                    context_of());
  for (double t = 0; t < 1.5; t += 0.01) {
    BOOST_TEST(distance(from_file.at(t).X_WH.p, from_table.at(t).X_WH.p) < 1e-14);
    BOOST_TEST(angle_between(from_file.at(t).X_WH.R, from_table.at(t).X_WH.R) < 1e-14);
  }
}

BOOST_AUTO_TEST_CASE(broken_way_points_are_refused_with_their_place) {
  check_refused(params_of({}, PathKind::linear), "hand: exactly one of points and file is expected, found neither");
  check_refused(params_of({7, {0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0}}, PathKind::linear),
                "hand: points: the times of way-points must increase; way-point 2");
  TrajectorySource::Params band = params_of(bent, PathKind::linear, 0.001);
  band.tremor_low = 20;
  check_refused(band, "tremor_low must not be above tremor_high");
  struct Case {
    const char* text;
    const char* expected;
  };
  for (const Case& c : {
           Case{"", "holds no rows"},
           Case{"t_s,x_m\n", "holds no rows"},
           Case{"t_s,x_m\n0,1\n1,nan\n", ":3: a number is expected in column x_m, found 'nan'"},
           Case{"t_s,x_m\n0,1\n1,0x10\n", ":3: a number is expected"},
           Case{"t_s,x_m\n0,1\n1,\n", ":3: a number is expected in column x_m, found ''"},
           Case{"t_s,x_m\n0,1\n1,2,3\n", ":3: expected 2 cells as in the first line, found 3"},
           Case{"t_s,x_m\n0,1\n1\n", ":3: expected 2 cells as in the first line, found 1"},
           Case{"t_s,x_m\n0,1\n\n1,2\n", ":3: an empty line is not allowed here"},
           Case{"t_s,x_m\n0,1\n0,2\n", ":3: the times of way-points must increase"},
           Case{"t_s,x_m,x_m\n0,1,1\n", ":1: the heading 'x_m' stands twice"},
           Case{"t_s,x_m,x_mm\n0,1,1\n", ":1: column 'x_mm' gives x a second time"},
           Case{"t_s,,x_m\n0,1,1\n", ":1: a heading is empty"},
           Case{"t_s,x\n0,1\n", ":1: column 'x' names no unit; write x_m"},
           Case{"t_s,x_N\n0,1\n", ":1: column 'x_N' is in N, expected a unit such as m"},
           Case{"t_s,force_N\n0,1\n", ":1: column 'force_N' is not one of t x y z rx ry rz"},
           Case{"x_m,y_m\n0,1\n", ":1: there is no column t"},
       }) {
    const TemporaryFile file(c.text);
    TrajectorySource::Params params = params_of({}, PathKind::linear);
    params.file = file.path;
    check_refused(params, c.expected);
    params.points = bent;
    check_refused(params, "found both");
  }
}

BOOST_AUTO_TEST_CASE(a_target_that_halts_stays_where_path_and_tremor_have_led_it) {
  for (const PathKind kind : {PathKind::minimum_jerk, PathKind::linear, PathKind::cubic}) {
    TrajectorySource::Params params = params_of(bent, kind, 1e-3);
    const TrajectorySource going(params, context_of());
    params.halt = Duration::from_seconds(0.9);
    const TrajectorySource halting(params, context_of());
    for (const double t : {0.0, 0.5, 0.8999}) {
      BOOST_TEST(distance(halting.at(t).X_WH.p, going.at(t).X_WH.p) == 0);
      BOOST_TEST(distance(halting.at(t).V_WH.v, going.at(t).V_WH.v) == 0);
    }
    for (const double t : {0.9, 0.9001, 1.2, 100.0}) {
      const Target at = halting.at(t);
      BOOST_TEST(distance(at.X_WH.p, going.at(0.9).X_WH.p) == 0);
      BOOST_TEST(angle_between(at.X_WH.R, going.at(0.9).X_WH.R) < 1e-14);
      BOOST_TEST(norm(at.V_WH.v) == 0);
      BOOST_TEST(norm(at.V_WH.w) == 0);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_path_that_begins_again_repeats_its_motion_and_not_its_tremor) {
  // A closed path: the last point is where the first one is.
  const Table closed{7, {0, 0, 0, 0, 0, 0, 0, 0.4, 1, -0.5, 0.25, 0.3, -0.2, 0.4, 1.5, 0, 0, 0, 0, 0, 0}};
  for (const PathKind kind : {PathKind::minimum_jerk, PathKind::linear, PathKind::cubic}) {
    TrajectorySource::Params params = params_of(closed, kind);
    params.repeat_after = Duration::from_seconds(1.5);
    const TrajectorySource path(params, context_of());
    // A spline begins otherwise, without a second derivative.
    for (const double t : {0.1, 0.4, 0.77, 1.4}) {
      // Of a spline the pass before, whose own computation differs.
      const double second = kind == PathKind::cubic ? 3 + t : t;
      for (const int pass : {3, 5, 7, 1000}) {
        BOOST_TEST(distance(path.at(second).X_WH.p, path.at(1.5 * pass + t).X_WH.p) <
                   (kind == PathKind::cubic ? 1e-2 : 1e-9));
        BOOST_TEST(distance(path.at(second).V_WH.v, path.at(1.5 * pass + t).V_WH.v) <
                   (kind == PathKind::cubic ? 0.1 : 1e-8));
      }
    }
    // It is one motion: no jump where a pass begins.
    for (const double joint : {1.5, 3.0, 4.5, 6.0, 7.5, 9.0, 15.0}) {
      BOOST_TEST(distance(path.at(joint - 1e-7).X_WH.p, path.at(joint + 1e-7).X_WH.p) < 1e-5);
      if (kind == PathKind::linear) continue;
      BOOST_TEST(distance(path.at(joint - 1e-7).V_WH.v, path.at(joint + 1e-7).V_WH.v) < 1e-3);
    }
    params.tremor_amplitude = 1e-3;
    const TrajectorySource shaking(params, context_of());
    BOOST_TEST(distance(shaking.at(3.2).X_WH.p - path.at(3.2).X_WH.p, shaking.at(4.7).X_WH.p - path.at(4.7).X_WH.p) >
               1e-4);
  }
  TrajectorySource::Params params = params_of(closed, PathKind::minimum_jerk);
  params.repeat_after = Duration::from_seconds(1.4);
  check_refused(params, "repeat_after: expected at least the time of the last way-point, 1.5");
}

BOOST_AUTO_TEST_CASE(a_path_of_any_length_that_begins_again_stays_among_its_points) {
  // Sums of such times differ in their last digits, and two points at nearly one time would throw a spline far off.
  for (int ms = 1001; ms < 1400; ms += 7) {
    const double end = 1e-3 * ms;
    const Table closed{7, {0,         0.02,  0, 0, 0, 0, 0, 0.3 * end, 0.012, 0, 0, 0, 0, 0,
                           0.6 * end, 0.025, 0, 0, 0, 0, 0, end,       0.02,  0, 0, 0, 0, 0}};
    TrajectorySource::Params params = params_of(closed, PathKind::cubic);
    params.repeat_after = Duration::from_seconds(end);
    const TrajectorySource path(params, context_of());
    for (double t = 0; t < 20 * end; t += 0.013) BOOST_TEST(std::abs(path.at(t).X_WH.p.x - 0.02) < 0.02);
  }
}

BOOST_AUTO_TEST_CASE(a_path_that_ends_elsewhere_needs_time_for_the_way_back) {
  const Table open{7, {0, 0.02, 0, 0, 0, 0, 0, 1, 0.01, 0, 0, 0, 0, 0}};
  TrajectorySource::Params params = params_of(open, PathKind::minimum_jerk);
  params.repeat_after = Duration::from_seconds(1);
  check_refused(params, "repeat_after: expected more than the time of the last way-point, 1.000000 s");
  params.repeat_after = Duration::from_seconds(1.5);
  const TrajectorySource path(params, context_of());
  for (const int pass : {1, 2, 4, 9}) {
    BOOST_TEST(std::abs(path.at(1.5 * pass).X_WH.p.x - 0.02) < 1e-9);
    BOOST_TEST(std::abs(path.at(1.5 * pass + 1).X_WH.p.x - 0.01) < 1e-9);
  }
}

BOOST_AUTO_TEST_SUITE_END()
