// Physics of a program under the virtual clock: what it is given, when its results are seen, what becomes of them.
#include <boost/test/unit_test.hpp>
#include <chrono>
#include <cmath>
#include <cstring>
#include <thread>

#include "framework/core/between_samples.hpp"
#include "tests/own_physics/ball.hpp"

BOOST_AUTO_TEST_SUITE(physics_loop_test)

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr std::int64_t ms = 1'000'000;

/// m, of a mass on the coupling's spring and damper and a spring of `wall` to zero, which starts at rest at x_0.
class SpringAndWall {
 public:
  SpringAndWall(double k, double b, double wall, double m, double x_D, double x_0)
      : decay_(b / (2 * m)),
        omega_(std::sqrt((k + wall) / m - decay_ * decay_)),
        rest_(k * x_D / (k + wall)),
        from_(x_0 - rest_) {}
  [[nodiscard]] double at(double t) const {
    return rest_ + from_ * std::exp(-decay_ * t) * (std::cos(omega_ * t) + decay_ / omega_ * std::sin(omega_ * t));
  }

 private:
  double decay_, omega_, rest_, from_;
};

template <class T>
std::string bytes_of(const std::vector<Stamped<T>>& messages) {
  std::string bytes;
  for (const Stamped<T>& message : messages) {
    bytes.append(reinterpret_cast<const char*>(&message.stamp), sizeof message.stamp);
    bytes.append(reinterpret_cast<const char*>(&message.value), sizeof message.value);
  }
  return bytes;
}

/// N, root of the mean square of what the device displayed less the truth, over the second behind 0.5 s.
double error_of(const std::vector<Stamped<Wrench>>& displayed, const std::vector<Stamped<Wrench>>& truth) {
  double sum = 0;
  int count = 0;
  std::size_t cursor = 0;
  for (const auto& [stamp, wrench] : displayed) {
    const double t = stamp.valid.seconds();
    if (t < 0.5 || t > 1.5) continue;
    const Vec3 expected = value_between(
        truth, stamp.valid, cursor, [](const Stamped<Wrench>& s) { return s.stamp.valid; },
        [](const Stamped<Wrench>& s) { return s.value.force; });
    const Vec3 off = wrench.force - expected;
    sum += dot(off, off);
    ++count;
  }
  BOOST_REQUIRE(count > 900);
  return std::sqrt(sum / count);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_step_goes_from_sample_to_sample_and_its_result_is_seen_a_period_later) {
  Session session(planned_text(graph_text("clock: virtual\nduration: 1 s", pressing_hand, 50, held,
                                          "device.state, physics.state, physics.bodies")));
  std::vector<Stamped<DeviceState>> handle;
  std::vector<Stamped<PhysicsState>> state;
  std::vector<Stamped<BodyStates>> bodies;
  keep(session, "device.state", handle);
  keep(session, "physics.state", state);
  keep(session, "physics.bodies", bodies);
  int steps = 0;
  run_ball(session, [&](const PhysicsStep& step) {
    ++steps;
    BOOST_TEST(step.begin.ns == 20 * ms * (steps - 1));
    BOOST_TEST(step.end.ns == 20 * ms * steps);
    BOOST_TEST(step.coupling.k_t == 500.0);
    const DeviceState middle = step.handle_at(Time{step.begin.ns + 5 * ms});
    BOOST_TEST(norm(middle.X_WD.p - (0.75 * step.from.X_WD.p + 0.25 * step.handle.X_WD.p)) < 1e-15);
    BOOST_TEST((step.handle_at(Time{0}).X_WD == step.from.X_WD));
  });
  session.finish();
  BOOST_TEST(steps == 49);
  BOOST_REQUIRE(state.size() == 48U);
  BOOST_TEST(bodies.size() == 48U);
  for (std::size_t k = 0; k < state.size(); ++k) {
    const auto& [stamp, value] = state[k];
    BOOST_TEST(stamp.valid.ns == 20 * ms * static_cast<int>(k + 1));
    BOOST_TEST(stamp.produced.ns == stamp.valid.ns + 20 * ms);
    const auto& sample = handle.at(20 * (k + 1));
    BOOST_REQUIRE(sample.stamp.valid == stamp.valid);
    BOOST_TEST((value.X_WD == sample.value.X_WD));
    BOOST_TEST((bodies[k].value.X_WB[0] == value.X_WT));
    BOOST_TEST(bodies[k].value.count == 1);
  }
}

BOOST_AUTO_TEST_CASE(a_mass_on_the_coupling_and_a_wall_moves_as_its_equation_says) {
  Session session(planned_text(
      graph_text("clock: virtual\nduration: 0.2 s", still_hand, 100, held, "physics.state, coupling.force")));
  std::vector<Stamped<PhysicsState>> state;
  std::vector<Stamped<Wrench>> force;
  keep(session, "physics.state", state);
  keep(session, "coupling.force", force);
  constexpr double wall = 2000, m = 0.05, x_0 = 3e-3, x_D = -2e-3;
  double x = x_0, v = 0;
  std::optional<SpringAndWall> exact;
  CouplingParameters coupling;
  PhysicsLoop loop(session);
  while (const auto step = loop.next()) {
    BOOST_REQUIRE(std::abs(step->handle.X_WD.p.z - x_D) < 1e-9);
    coupling = step->coupling;
    exact.emplace(coupling.k_t, coupling.b_t, wall, m, x_D, x_0);
    constexpr double h = 1e-5;
    for (int i = 0; i < 1000; ++i) {
      const ExplicitTool tool{.X_WT = {{0, 0, x}, {}}, .V_WT = {{0, 0, v}, {}}, .mass = m};
      v += h / m * (explicit_wrench(coupling, step->handle, tool, h).force.z - wall * x);
      x += h * v;
    }
    loop.result(*step, {.X_WT = Pose{{0, 0, x}, {}}, .V_WT = {{0, 0, v}, {}}});
  }
  session.finish();
  BOOST_REQUIRE(state.size() == 18U);
  BOOST_REQUIRE(force.size() == 18U);
  for (std::size_t k = 0; k < state.size(); ++k) {
    const double expected = exact->at(state[k].stamp.valid.seconds());
    near(state[k].value.X_WT.p.z, expected, 0.01 * x_0);
    near(force[k].value.force.z, -coupling.k_t * (x_D - expected) + coupling.b_t * state[k].value.V_WT.v.z, 0.02);
    BOOST_TEST((force[k].stamp.valid == state[k].stamp.valid));
    // Nobody said what the contacts push with.
    BOOST_TEST(state[k].value.damped == 1);
  }
}

BOOST_AUTO_TEST_CASE(a_run_has_the_same_bytes_however_slow_the_program_is_and_however_it_asks) {
  const auto made = [](bool slow) {
    Session session(planned_text(graph_text("clock: virtual\nduration: 0.6 s", pressing_hand, 60, rolled_out,
                                            "device.commanded, physics.state")));
    std::vector<Stamped<Wrench>> commanded;
    std::vector<Stamped<PhysicsState>> state;
    keep(session, "device.commanded", commanded);
    keep(session, "physics.state", state);
    if (!slow) {
      run_ball(session);
    } else {
      Ball ball;
      PhysicsLoop loop(session);
      while (loop.is_running()) {
        const auto step = loop.next_within(Duration{700'000});
        if (!step) continue;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        ball.move(*step);
        const ContactSet set = ball.contacts();
        loop.result(
            *step,
            {.X_WT = ball.pose(), .V_WT = ball.twist(), .contact_T_W = Wrench{ball.push(), {}}, .contacts = &set});
      }
    }
    session.finish();
    BOOST_TEST(state.size() > 30U);
    return bytes_of(commanded) + bytes_of(state);
  };
  const std::string fast = made(false);
  BOOST_TEST(!fast.empty());
  BOOST_TEST((fast == made(true)));
}

BOOST_AUTO_TEST_CASE(local_adds_the_weight_of_the_tool_where_the_scene_has_gravity_and_none_where_physics_carries_it) {
  constexpr double g = 9.81;
  const std::string high_hand = R"(
  trajectory:
    type: source.trajectory
    points:
      - {t: 0 s, z: 50 mm}
      - {t: 1 s, z: 50 mm}
)";
  const std::string text = graph_text("clock: virtual\nduration: 1 s", high_hand, 60, rolled_out, "device.commanded");
  for (const double gravity : {0.0, g}) {
    const std::string scene = "gravity: [0, 0, " + std::to_string(-gravity) + "]";
    Session session(planned_text(replaced(text, "gravity: [0, 0, 0]", scene)));
    std::vector<Stamped<Wrench>> commanded;
    keep(session, "device.commanded", commanded);
    PhysicsLoop loop(session);
    const ContactSet none;
    // The tool hangs at rest in the spring, or where the handle is.
    while (const auto step = loop.next()) {
      const Vec3 sag{0, 0, -Ball::mass * gravity / step->coupling.k_t};
      loop.result(*step, {.X_WT = Pose{step->handle.X_WD.p + sag, {}}, .V_WT = Twist{}, .contacts = &none});
    }
    session.finish();
    BOOST_REQUIRE(!commanded.empty());
    BOOST_TEST(std::abs(commanded.back().value.force.z + Ball::mass * gravity) < 0.02, gravity);
  }
}

BOOST_AUTO_TEST_CASE(local_goes_on_from_the_contacts_that_a_program_tells) {
  const auto displayed = [](double rate, const std::string& method, std::vector<Stamped<Wrench>>& truth) {
    Session session(planned_text(graph_text("clock: virtual\nduration: 1.6 s", pressing_hand, rate, method,
                                            "device.commanded, coupling.force")));
    std::vector<Stamped<Wrench>> commanded;
    keep(session, "device.commanded", commanded);
    keep(session, "coupling.force", truth);
    run_ball(session);
    session.finish();
    return commanded;
  };
  std::vector<Stamped<Wrench>> truth, unused;
  static_cast<void>(displayed(1000, held, truth));
  const double hold = error_of(displayed(60, held, unused), truth);
  const double local = error_of(displayed(60, rolled_out, unused), truth);
  // The wall of the scene has another stiffness, but physics has told its own.
  const std::string on_surface = std::regex_replace(rolled_out, std::regex("contacts: anchors"), "contacts: surface");
  BOOST_TEST(error_of(displayed(60, on_surface, unused), truth) < 0.1 * hold);
  BOOST_TEST_MESSAGE("hold " << hold << " N, local " << local << " N");
  BOOST_TEST(hold > 0.05);
  BOOST_TEST(local < 0.1 * hold);
}

BOOST_AUTO_TEST_CASE(results_between_two_samples_are_told_with_the_handle_between_them) {
  Session session(planned_text(
      graph_text("clock: virtual\nduration: 0.6 s", pressing_hand, 100, held, "device.state, physics.state")));
  std::vector<Stamped<PhysicsState>> state;
  std::vector<Stamped<DeviceState>> handle;
  keep(session, "physics.state", state);
  keep(session, "device.state", handle);
  PhysicsLoop loop(session);
  while (const auto step = loop.next()) {
    // Two results of one step: a quarter of a millisecond before its last sample but one, and at its end.
    loop.result(*step, {.time = Time{step->end.ns - 1'250'000}, .X_WT = Pose{}});
    loop.result(*step, {.X_WT = Pose{}});
  }
  session.finish();
  BOOST_REQUIRE(state.size() == 116U);
  const Stamped<PhysicsState>& between_samples = state[80];  // of the step that ends at 410 ms
  BOOST_TEST(between_samples.stamp.valid.ns == 408'750'000);
  const Vec3 a = handle.at(408).value.X_WD.p, b = handle.at(409).value.X_WD.p;
  BOOST_TEST(norm(b - a) > 1e-6);
  BOOST_TEST(norm(between_samples.value.X_WD.p - (0.25 * a + 0.75 * b)) < 1e-12);
  BOOST_TEST((state[81].value.X_WD == handle.at(410).value.X_WD));
}

BOOST_AUTO_TEST_CASE(a_result_for_a_time_after_its_step_has_the_handle_of_that_time) {
  Session session(planned_text(
      graph_text("clock: virtual\nduration: 0.6 s", pressing_hand, 100, held, "device.state, physics.state")));
  std::vector<Stamped<PhysicsState>> state;
  std::vector<Stamped<DeviceState>> handle;
  keep(session, "physics.state", state);
  keep(session, "device.state", handle);
  PhysicsLoop loop(session);
  while (const auto step = loop.next()) {
    if (step->end.ns != 400 * ms) continue;
    session.advance(Duration{5 * ms});
    loop.result(*step, {.time = Time{step->end.ns + 4 * ms + ms / 2}, .X_WT = Pose{}});
  }
  session.finish();
  BOOST_REQUIRE(state.size() == 1U);
  const Vec3 a = handle.at(404).value.X_WD.p, b = handle.at(405).value.X_WD.p;
  BOOST_TEST(norm(b - handle.at(400).value.X_WD.p) > 1e-6);
  BOOST_TEST(norm(state[0].value.X_WD.p - 0.5 * (a + b)) < 1e-12);
}

BOOST_AUTO_TEST_CASE(a_hand_that_nobody_feeds_is_told_at_the_end) {
  const std::string text =
      replaced(graph_text("clock: virtual\nduration: 0.1 s", "\n  hand: {type: source.feed, message: Target}\n", 100,
                          held, "device.commanded"),
               "trajectory.target -> device.target", "hand.message -> device.target");
  Session session(planned_text(text));
  PhysicsLoop loop(session);
  BOOST_CHECK_EXCEPTION(static_cast<void>(loop.next()), RunError, [](const RunError& error) {
    return std::string(error.what()).find("nobody filled device.target, which node hand feeds") != std::string::npos;
  });
}

BOOST_AUTO_TEST_CASE(samples_that_no_step_can_go_to_are_counted_and_end_the_run_where_all_are_so) {
  const std::string text =
      replaced(replaced(graph_text("clock: virtual\nduration: 1 s", still_hand, 100, held, "physics.state"),
                        "  physics: {", "  hand: {type: source.feed, message: DeviceState}\n  physics: {"),
               "device.state -> physics.device", "hand.message -> physics.device");
  DeviceState good, bad, turned;
  bad.X_WD.p.x = std::nan("");
  turned.X_WD.R = {3, 0, 0, 0};
  for (const bool all : {false, true}) {
    Session session(planned_text(text));
    PhysicsLoop loop(session);
    session.start();
    auto hand = session.feed("hand");
    session.advance(Duration{50 * ms});
    // A rotation of another length is made a rotation.
    if (!all) BOOST_TEST(hand.send(turned));
    for (int i = 0; i < 100; ++i) {
      session.advance(Duration{ms});
      BOOST_TEST(hand.send(bad));
    }
    if (all) {
      BOOST_CHECK_EXCEPTION(static_cast<void>(loop.next_within(Duration{20 * ms})), RunError,
                            [](const RunError& error) {
                              return std::string(error.what()).find("none of the 100 samples") != std::string::npos;
                            });
      continue;
    }
    BOOST_TEST(hand.send(good));
    const auto step = loop.next_within(Duration{20 * ms});
    BOOST_REQUIRE(step.has_value());
    BOOST_TEST(step->from.X_WD.R.w == 1.0);
    BOOST_TEST(loop.refusals().refused(RefusalReason::not_finite) == 100U);
    // There is no handle before the first sample.
    says_like(refusal_of([&] { loop.result(*step, {.time = Time{20 * ms}, .X_WT = Pose{}}); }),
              "^result: time: expected 0.05.* s, that of the first sample of the handle, to .*found 0.02 s");
    loop.result(*step, {.X_WT = Pose{}});
  }
}

BOOST_AUTO_TEST_SUITE_END()
