// interpolation.direct against springs in series and motions integrated apart from it, and its fall-back entered,
// counted and left.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "framework/core/segment.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "nodes/interpolation/direct.hpp"
#include "tests/nodes/physics/mechanics/local_contacts.hpp"
#include "tests/support/heap_is_counted.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(direct_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

constexpr double radius = 0.01;
// Two of these meet with stiffnesses in series and the damping of one (see combine).
constexpr Material half_stiff{.stiffness = 2000, .damping = 2, .friction = 0};
constexpr double stiffness = 1000, damping = 2;
const CouplingParameters spring{.k_t = 500, .b_t = 14, .k_r = 0.5, .b_r = 0.005, .force_max = 8, .torque_max = 0.3};

Body ball(const std::string& name, const Vec3& p) {
  Body body;
  body.name = name;
  body.shape = SphereShape{radius};
  body.motion = Motion::translation;
  body.mass = 0.1;
  body.material = half_stiff;
  body.X_WB.p = p;
  return body;
}

/// A ball beside a fixed box whose face is x = 0.
Scene box_scene() {
  Scene scene;
  scene.gravity_W = {};
  scene.bodies.push_back(ball("tool", {0.02, 0, 0}));
  Body box;
  box.name = "box";
  box.shape = BoxShape{{0.1, 0.1, 0.1}};
  box.X_WB.p = {-0.05, 0, 0};
  box.material = half_stiff;
  scene.bodies.push_back(box);
  return scene;
}

/// The node, fed with samples, results and segments, and a device that shows the newest segment.
class Subject {
 public:
  explicit Subject(const Scene& scene, const Direct::Params& params = default_params<Direct>())
      : scene_(scene), node_(params, context_for(scene_)) {
    node_.device.configure({QueuePolicy::drop_oldest, 64});
    node_.coupling.configure({});
    node_.bodies.configure({});
    node_.otherwise.configure({});
    node_.coupling.push({at_ms(0), at_ms(0), sequence_++}, &spring);
  }
  void sample(double ms, const DeviceState& state) { node_.device.push({at_ms(ms), at_ms(ms), sequence_++}, &state); }
  void sample(double ms, const Vec3& p, const Vec3& v = {}) { sample(ms, {{p, {}}, {v, {}}, 0}); }
  void bodies(double stamp_ms, double ms, const BodyStates& b) {
    node_.bodies.push({at_ms(stamp_ms), at_ms(ms), sequence_++}, &b);
  }
  void otherwise(double stamp_ms, double ms, const Vec3& force, Duration trust_time = {}) {
    ForceSegment held = constant_segment(at_ms(ms), {force, {}});
    held.trust_time = trust_time;
    node_.otherwise.push({at_ms(stamp_ms), at_ms(ms), sequence_++}, &held);
  }
  bool tick(double ms) {
    StepContext context(at_ms(ms));
    node_.step(context);
    if (node_.segment.pending() == 0) return false;
    BOOST_REQUIRE(node_.segment.pending() == 1U);
    before_ = shown_;
    shown_ = sent(node_.segment);
    stamp = node_.segment.pending_valid(0);
    node_.segment.clear_pending();
    return true;
  }
  [[nodiscard]] Duration trust_time() const { return shown_.trust_time; }
  [[nodiscard]] Vec3 force(double ms) const { return evaluate(shown_, at_ms(ms)).force; }
  [[nodiscard]] double jump() const { return norm(shown_.c[0].force - displayed(before_, shown_.begin).value.force); }
  [[nodiscard]] double metric(const std::string& name) const { return metrics_of(node_).at(name); }

  Time stamp;

 private:
  Scene scene_;
  Direct node_;
  ForceSegment shown_, before_;
  std::uint64_t sequence_ = 0;
};

/// A handle that goes into the wall x = 0 and out of it, along x.
struct Handle {
  static double x(double t) { return 0.012 - 0.008 * (1 - std::cos(12 * t)); }
  static double v(double t) { return -0.096 * std::sin(12 * t); }
};

/// Balls of 0.1 kg in a row along x, the first on the spring, by explicit steps of 1 us. With one ball, it meets the
/// wall x = 0; with two, the second one is free.
class Truth {
 public:
  explicit Truth(double x) : count_(1), x_{x, 0} {}
  Truth(double x, double other) : count_(2), x_{x, other} {}
  void advance(double until) {
    constexpr double h = 1e-6, mass = 0.1;
    for (; t_ < until - h / 2; t_ += h) {
      const double apart = count_ == 1 ? x_[0] - radius : x_[0] - x_[1] - 2 * radius;
      const double approach = count_ == 1 ? v_[0] : v_[0] - v_[1];
      const double push = std::max(0.0, -stiffness * apart - damping * approach);
      v_[0] += h * (push - reaction()) / mass;
      if (count_ == 2) v_[1] -= h * push / mass;
      x_[0] += h * v_[0];
      x_[1] += h * v_[1];
    }
  }
  /// N, on the device.
  [[nodiscard]] double reaction() const {
    return -spring.k_t * (Handle::x(t_) - x_[0]) - spring.b_t * (Handle::v(t_) - v_[0]);
  }
  [[nodiscard]] double x(std::size_t i) const { return x_[i]; }

 private:
  int count_;
  double t_ = 0;
  double x_[2], v_[2] = {0, 0};
};

DeviceState handle_at(double t) {
  return {{{Handle::x(t), 0, 0}, {}}, {{Handle::v(t), 0, 0}, {}}, 0};
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_ball_pressed_on_a_face_is_felt_by_the_springs_in_series) {
  for (const double depth : {0.001, 0.004}) {
    Subject subject(box_scene());
    const Vec3 handle{radius - depth, 0, 0};
    for (int ms = 0; ms <= 600; ++ms) {
      subject.sample(ms, handle);
      if (ms == 3) subject.bodies(0, ms, one_body({radius, 0, 0}));
      BOOST_TEST(subject.tick(ms) == (ms >= 3));
      // The newest sample is what is shown.
      if (ms >= 3) BOOST_REQUIRE(subject.stamp.ns == at_ms(ms).ns);
    }
    const double in_series = spring.k_t * stiffness / (spring.k_t + stiffness);
    BOOST_TEST(subject.force(601).x == in_series * depth, tt::tolerance(1e-6));
    BOOST_TEST(std::abs(subject.force(601).y) < 1e-9);
    BOOST_TEST(subject.metric("direct.ticks") == 598.0);
    BOOST_TEST(subject.metric("fallbacks") == 0.0);
  }
}

BOOST_AUTO_TEST_CASE(what_is_displayed_instead_of_a_step_is_trusted_as_it_states) {
  Subject subject(box_scene());
  const Duration trust{300'000'000};
  for (int ms = 0; ms <= 20; ++ms) {
    subject.sample(ms, Vec3{0.02, 0, 0});
    if (ms == 5) subject.otherwise(0, ms, {1, 0, 0}, trust);
    if (ms == 10) subject.bodies(0, ms, one_body({0.02, 0, 0}));
    if (!subject.tick(ms)) continue;
    if (ms < 10) BOOST_TEST((subject.trust_time() == trust));
  }
  // Now it steps, and shows the force of the newest sample.
  BOOST_TEST(subject.metric("direct.ticks") > 5);
  BOOST_TEST((subject.trust_time() == Duration{}));
}

namespace {

/// The largest error of the displayed force as a share of the largest force.
double error_of(Integrator integrator) {
  Direct::Params params = default_params<Direct>();
  params.integrator = integrator;
  Subject subject(box_scene(), params);
  Truth truth(Handle::x(0));
  double worst = 0, largest = 0;
  for (int ms = 0; ms <= 1500; ++ms) {
    subject.sample(ms, handle_at(1e-3 * ms));
    // It comes 20 ms late, and all others are wrong.
    if (ms % 20 == 0 && ms > 0) subject.bodies(ms - 20, ms, one_body({Handle::x(0) + (ms > 20 ? 0.005 : 0), 0, 0}));
    if (!subject.tick(ms)) continue;
    truth.advance(1e-3 * (ms + 1));
    if (ms < 100) continue;
    worst = std::max(worst, std::abs(subject.force(ms + 1).x - truth.reaction()));
    largest = std::max(largest, std::abs(truth.reaction()));
  }
  BOOST_TEST_MESSAGE("error " << worst << " N of " << largest << " N");
  BOOST_TEST(largest > 1.0);
  BOOST_TEST(subject.metric("fallbacks") == 0.0);
  return worst / largest;
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_device_shows_the_force_of_its_own_time_after_a_single_result) {
  // What steps of 1 ms make of it.
  const double euler = error_of(Integrator::implicit_euler), midpoint = error_of(Integrator::midpoint);
  BOOST_TEST(euler < 0.02);
  BOOST_TEST(midpoint < 0.7 * euler);
}

BOOST_AUTO_TEST_CASE(a_ball_that_the_tool_pushes_away_moves_as_its_equation_says) {
  Scene scene;
  scene.gravity_W = {};
  scene.bodies = {ball("tool", {Handle::x(0), 0, 0}), ball("other", {Handle::x(0) - 0.025, 0, 0})};
  // In steps that are short beside the 22 ms of the impact.
  auto params = default_params<Direct>();
  params.rate = 10'000;
  Subject subject(scene, params);
  Truth truth(Handle::x(0), Handle::x(0) - 0.025);
  BodyStates start;
  start.count = 2;
  for (std::size_t i = 0; i < 2; ++i) start.X_WB[i] = scene.bodies[i].X_WB;
  double worst = 0, largest = 0;
  for (int k = 0; k <= 5000; ++k) {
    const double ms = 0.1 * k;
    subject.sample(ms, handle_at(1e-3 * ms));
    if (k == 0) subject.bodies(-0.1, ms, start);
    BOOST_REQUIRE(subject.tick(ms));
    truth.advance(1e-3 * (ms + 0.1));
    const double off = std::abs(subject.force(ms + 0.1).x - truth.reaction());
    if (off > worst)
      BOOST_TEST_MESSAGE(ms << " ms: off " << off << " of " << truth.reaction() << ", x " << truth.x(0) << " "
                            << truth.x(1));
    worst = std::max(worst, off);
    largest = std::max(largest, std::abs(truth.reaction()));
  }
  BOOST_TEST_MESSAGE("error " << worst << " N of " << largest << " N");
  // It was hit, and has gone ahead of the tool.
  BOOST_TEST(truth.x(1) < Handle::x(0) - 0.05);
  BOOST_TEST(largest > 0.5);
  BOOST_TEST(worst < 0.05 * largest);
  BOOST_TEST(subject.metric("fallbacks") == 0.0);
}

BOOST_AUTO_TEST_CASE(the_force_is_within_the_device_limit) {
  Subject subject(box_scene());
  for (int ms = 0; ms <= 300; ++ms) {
    subject.sample(ms, Vec3{radius - 0.045, 0, 0});
    if (ms == 0) subject.bodies(-1, ms, one_body({radius, 0, 0}));
    BOOST_REQUIRE(subject.tick(ms));
    BOOST_TEST(norm(subject.force(ms + 1)) <= spring.force_max * (1 + 1e-9));
  }
  BOOST_TEST(subject.force(301).x == spring.force_max, tt::tolerance(1e-9));
}

namespace {

/// N/m, of the whole face of the box below: patches side by side.
const double face_stiffness = stiffness * 4 * radius * radius / half_stiff.patch_area;

/// A box on the spring instead of the ball: it has contact samples, which take work to look at.
Scene two_boxes() {
  Scene scene = box_scene();
  scene.bodies[0].shape = BoxShape{{2 * radius, 2 * radius, 2 * radius}};
  return scene;
}

}  // namespace

BOOST_AUTO_TEST_CASE(steps_that_never_fit_show_the_other_segment_and_are_counted) {
  auto params = default_params<Direct>();
  params.most_work = 1;
  Subject subject(two_boxes(), params);
  for (int ms = 0; ms <= 200; ++ms) {
    subject.sample(ms, Vec3{radius - 0.001, 0, 0});
    if (ms % 10 == 0) {
      subject.bodies(ms, ms, one_body({radius - 0.0005, 0, 0}));
      subject.otherwise(ms - 15, ms, {ms < 100 ? 2.0 : 3.0, 0, 0});
    }
    BOOST_REQUIRE(subject.tick(ms));
    if (ms > 0) BOOST_TEST(subject.jump() < 1e-9);
    if (ms == 99 || ms == 200) BOOST_TEST(subject.force(ms + 1).x == (ms == 99 ? 2.0 : 3.0), tt::tolerance(1e-6));
  }
  BOOST_TEST(subject.stamp.ns == at_ms(185).ns);
  BOOST_TEST(subject.metric("direct.ticks") == 0.0);
  // A first step is tried at the second sample.
  BOOST_TEST(subject.metric("direct.fallback_ticks") == 200.0);
  BOOST_TEST(subject.metric("fallbacks") == subject.metric("direct.fallback_ticks"));
}

BOOST_AUTO_TEST_CASE(a_step_that_does_not_fit_falls_back_without_a_jump_and_stepping_returns_where_it_fits) {
  // How much work the contact is, where all may be done.
  const auto run = [](int most_work, Subject& subject) {
    double last_fallbacks = 0, returned_at = 0;
    for (int ms = 0; ms <= 1000; ++ms) {
      // In free space, 2 mm into the box from 300 ms on, and out again from 600 ms on.
      const auto eased = [](double u) { return u <= 0 ? 0 : u >= 1 ? 1 : u * u * u * (10 - 15 * u + 6 * u * u); };
      const auto x_at = [&](double t) { return 0.015 - 0.007 * (eased((t - 100) / 200) - eased((t - 600) / 200)); };
      const Vec3 handle{x_at(ms), 0, 0};
      subject.sample(ms, handle, {500 * (x_at(ms + 1) - x_at(ms - 1)), 0, 0});
      // The pipeline's results are 10 ms late, and its tool is where the springs have it.
      const double deep = std::max(0.0, radius - handle.x);
      if (ms % 10 == 0 && ms >= 10) {
        const double tool = handle.x + deep * face_stiffness / (face_stiffness + spring.k_t);
        subject.bodies(ms - 1, ms, one_body({tool, 0, 0}));
        subject.otherwise(ms - 10, ms, {deep > 0 ? 3.0 : 0, 0, 0});
      }
      if (!subject.tick(ms)) continue;
      BOOST_REQUIRE(is_finite(subject.force(ms + 1)));
      // The step that follows is not quite the one that was expected, where the tool meets the box above all.
      if (ms > 10) BOOST_TEST(subject.jump() < 0.1);
      const double fallbacks = subject.metric("direct.fallback_ticks");
      if (fallbacks > last_fallbacks) returned_at = ms;
      last_fallbacks = fallbacks;
      // Pressed and at rest: what a step makes of it, or what the pipeline does.
      if (ms == 590) {
        const double in_series = spring.k_t * face_stiffness / (spring.k_t + face_stiffness);
        BOOST_TEST(subject.force(591).x == (most_work > 1000 ? in_series * 0.002 : 3), tt::tolerance(0.005));
      }
      if (ms == 1000) BOOST_TEST(norm(subject.force(1001)) < 1e-3);
    }
    return returned_at;
  };
  auto params = default_params<Direct>();
  params.most_work = 100'000;
  Subject free(two_boxes(), params);
  run(params.most_work, free);
  BOOST_TEST(free.metric("fallbacks") == 0.0);
  const double most = free.metric("direct.work_most");
  BOOST_TEST_MESSAGE("work " << free.metric("direct.work_mean") << ", most " << most);
  BOOST_REQUIRE(most >= 2);

  params.most_work = static_cast<std::int32_t>(most / 2);
  Subject bounded(two_boxes(), params);
  const double returned_at = run(params.most_work, bounded);
  BOOST_TEST(bounded.metric("fallbacks") > 250.0);
  BOOST_TEST(bounded.metric("fallbacks") < 550.0);
  BOOST_TEST(returned_at > 600);
  BOOST_TEST(returned_at < 800);
  BOOST_TEST(bounded.metric("direct.ticks") > 400.0);
}

BOOST_AUTO_TEST_CASE(from_a_late_result_each_sample_is_stepped_to_over_some_ticks) {
  // 40 samples since the result, 4 a tick, while one more comes a tick: n ticks go through 4 n of 39 + n.
  Subject subject(box_scene());
  for (int ms = 0; ms <= 100; ++ms) {
    subject.sample(ms, handle_at(1e-3 * ms));
    if (ms == 40) subject.otherwise(0, ms, {1, 0, 0});
    if (ms == 40) subject.bodies(0, ms, one_body({Handle::x(0), 0, 0}));
    if (!subject.tick(ms)) continue;
    // Where contact begins the force is foretold as far as a tick may catch up; it changes by 0.05 N a tick.
    if (ms > 40) BOOST_TEST(subject.jump() < 0.02);
    BOOST_TEST(subject.stamp.ns == at_ms(ms < 52 ? 0 : ms).ns);
  }
  // Those before the first step are no fall-back.
  BOOST_TEST(subject.metric("direct.fallback_ticks") == 0.0);
  BOOST_TEST(subject.metric("direct.ticks") == 49.0);
}

BOOST_AUTO_TEST_CASE(what_is_not_finite_is_refused_and_counted) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  for (const double value : {std::nan(""), inf, -inf}) {
    Subject subject(box_scene());
    BodyStates bad = one_body({value, 0, 0});
    BodyStates two = one_body({radius, 0, 0});
    two.count = 2;
    int hostile = 0;
    for (int ms = 0; ms <= 300; ++ms) {
      DeviceState state{{{radius - 0.002, 0, 0}, {}}, {}, 0};
      if (ms % 7 == 3) {
        ++hostile;
        if (ms % 3 == 0) state.X_WD.p.y = value;
        if (ms % 3 == 1) state.V_WD.v.x = value;
        if (ms % 3 == 2) state.X_WD.R.w = value;
      }
      subject.sample(ms, state);
      if (ms == 0) subject.bodies(0, ms, bad);
      if (ms == 5) subject.bodies(0, ms, two);
      if (ms == 10) subject.bodies(9, ms, one_body({radius, 0, 0}));
      if (!subject.tick(ms)) continue;
      BOOST_REQUIRE(ms >= 10);
      BOOST_REQUIRE(is_finite(subject.force(ms)));
      BOOST_REQUIRE(norm(subject.force(ms + 1)) <= spring.force_max);
    }
    BOOST_TEST(subject.metric("direct.rejected_samples") == hostile);
    BOOST_TEST(subject.metric("direct.rejected_results") == 2.0);
    BOOST_TEST(subject.force(301).x == 500.0 * 1000 / 1500 * 0.002, tt::tolerance(1e-3));
  }
}

BOOST_AUTO_TEST_CASE(an_other_segment_that_is_not_finite_is_shown_as_it_is_for_the_safety_gate) {
  auto params = default_params<Direct>();
  params.most_work = 1;
  Subject subject(two_boxes(), params);
  for (int ms = 0; ms <= 100; ++ms) {
    subject.sample(ms, Vec3{radius - 0.001, 0, 0});
    if (ms == 0) subject.bodies(0, ms, one_body({radius, 0, 0}));
    if (ms % 10 == 0) subject.otherwise(ms, ms, {ms == 50 ? std::nan("") : 1.0, 0, 0});
    BOOST_REQUIRE(subject.tick(ms));
    BOOST_TEST(is_finite(subject.force(ms + 1)) == !(ms >= 50 && ms < 60));
  }
  BOOST_TEST(subject.force(101).x == 1.0, tt::tolerance(1e-6));
}

BOOST_AUTO_TEST_CASE(no_tick_calls_the_heap, *boost::unit_test::precondition(tactor::test::heap_is_counted)) {
  BOOST_TEST(Direct::declare().realtime_safe);
  auto params = default_params<Direct>();
  for (const int most_work : {2000, 1}) {
    params.most_work = most_work;
    Subject subject(two_boxes(), params);
    std::int64_t calls = 0;
    for (int ms = 0; ms < 500; ++ms) {
      subject.sample(ms, Vec3{radius + 0.001 * std::sin(0.02 * ms) - 0.0005, 0, 0});
      if (ms % 10 == 0) {
        subject.bodies(ms - 12, ms, one_body({radius, 0, 0}));
        subject.otherwise(ms - 12, ms, {0.5, 0, 0});
      }
      // The contact query may grow once, until it has met the most contacts.
      const std::int64_t before = thread_heap_calls();
      subject.tick(ms);
      if (ms > 400) calls += thread_heap_calls() - before;
    }
    BOOST_TEST(calls == 0);
    BOOST_TEST((subject.metric("direct.fallback_ticks") > 0) == (most_work == 1));
  }
}

BOOST_AUTO_TEST_CASE(integrator_and_stick_velocity_are_those_of_dynamics_unless_a_graph_gives_them) {
  const NodeInfo info = Direct::declare();
  for (const std::string name : {"integrator", "stick_velocity"}) {
    const auto param =
        std::find_if(info.params.begin(), info.params.end(), [&](const ParamInfo& p) { return p.name == name; });
    BOOST_REQUIRE((param != info.params.end()));
    BOOST_TEST((param->as_in == Role::dynamics));
  }
}

BOOST_AUTO_TEST_SUITE_END()
