// A program's own light copy as its rollout: how near it is, and what becomes of one that is wrong, missing or late.
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "framework/core/between_samples.hpp"
#include "tests/own_physics/own_copy.hpp"

BOOST_AUTO_TEST_SUITE(physics_rollout_test)

using namespace tactor;
using namespace tactor::test;

namespace {

using Forces = std::vector<Stamped<Wrench>>;

/// N, root of the mean square of what the device was commanded less the truth, from 0.5 to 1.5 s.
double rms_error(const Forces& commanded, const Forces& truth) {
  double sum = 0;
  int count = 0;
  std::size_t cursor = 0;
  for (const auto& [stamp, wrench] : commanded) {
    if (stamp.valid < Time::from_seconds(0.5) || stamp.valid > Time::from_seconds(1.5)) continue;
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

std::string text_at(double rate) {
  return graph_text("clock: virtual\nduration: 1.6 s", pressing_hand, rate, held, "device.commanded, coupling.force");
}

std::string refused(const std::function<void()>& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "taken";
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_programs_own_copy_shows_its_physics_between_two_results) {
  const auto commanded = [](Plan plan, bool with_copy, Forces& of_physics) {
    Session session(std::move(plan));
    Forces shown;
    keep(session, "device.commanded", shown);
    keep(session, "coupling.force", of_physics);
    PhysicsLoop loop(session);
    if (with_copy) loop.rollout(MassAndWall::numbers, MassAndWall::step);
    run_mass(loop, with_copy);
    session.finish();
    BOOST_TEST(loop.dropped_states() == 0U);
    return shown;
  };
  Forces truth, unused;
  static_cast<void>(commanded(planned_text(text_at(1000)), false, truth));
  const double hold = rms_error(commanded(planned_text(text_at(60)), false, unused), truth);
  const double copy = rms_error(commanded(planned_with_copy(text_at(60)), true, unused), truth);
  BOOST_TEST_MESSAGE("hold " << hold << " N, copy " << copy << " N");
  BOOST_TEST(hold > 0.05);
  BOOST_TEST(copy < 0.1 * hold);
}

BOOST_AUTO_TEST_CASE(a_copy_that_is_missing_late_or_without_a_state_is_told_before_the_run) {
  Session session(planned_with_copy(text_at(60)));
  PhysicsLoop loop(session);
  BOOST_TEST(has(refused([&] { static_cast<void>(loop.next()); }), "physics.engine, the state of a light copy"));
  BOOST_TEST(!session.is_started());
  BOOST_TEST(has(refused([&] { loop.rollout(0, MassAndWall::step); }), "with a step and 1 number or more"));
  BOOST_TEST(has(refused([&] { loop.rollout(6, {}); }), "with a step and 1 number or more"));
  loop.rollout(MassAndWall::numbers, MassAndWall::step);
  BOOST_TEST(has(refused([&] { loop.rollout(6, MassAndWall::step); }), "a light copy already"));
  Session started(planned_text(text_at(60)));
  PhysicsLoop late(started);
  static_cast<void>(late.next());
  BOOST_TEST(has(refused([&] { late.rollout(6, MassAndWall::step); }), "before the session starts"));
}

BOOST_AUTO_TEST_CASE(a_result_without_the_numbers_of_the_copy_is_refused_by_name) {
  Session session(planned_with_copy(text_at(60)));
  PhysicsLoop loop(session);
  loop.rollout(MassAndWall::numbers, MassAndWall::step);
  const auto step = loop.next();
  BOOST_REQUIRE(step.has_value());
  const auto result = [&](const std::vector<double>& state) {
    return refused([&] { loop.result(*step, {.X_WT = Pose{}, .copy_state = state}); });
  };
  BOOST_TEST(has(result({}), "result: copy_state: expected 6 numbers"));
  BOOST_TEST(has(result({1, 2}), "found 2"));
  BOOST_TEST(has(result({0, 0, 0, 0, 0, std::nan("")}), "copy_state: expected finite numbers, found nan"));
  BOOST_TEST(result(std::vector<double>(6)) == "taken");
}

BOOST_AUTO_TEST_CASE(a_copy_that_fails_ends_the_run_with_the_name_of_its_node) {
  const auto check_failure = [](const CopyFunction& step, const std::string& why) {
    Session session(planned_with_copy(text_at(60)));
    PhysicsLoop loop(session);
    loop.rollout(MassAndWall::numbers, step);
    const auto is_told = [&](const RunError& error) {
      const std::string text = error.what();
      BOOST_TEST_MESSAGE(text);
      // Either node may be the first to come to the wall.
      const bool named =
          text.starts_with("node rollout failed at ") || text.starts_with("node resimulation failed at ");
      return named && has(text, "the program's light copy failed in its step from ") && has(text, why);
    };
    BOOST_CHECK_EXCEPTION(run_mass(loop), RunError, is_told);
  };
  check_failure(
      [](std::span<double> state, const CopyStep& step) {
        if (state[2] < MassAndWall::radius) throw std::runtime_error("inside the wall");
        return MassAndWall::step(state, step);
      },
      "inside the wall");
  check_failure(
      [](std::span<double> state, const CopyStep& step) {
        CopyTool tool = MassAndWall::step(state, step);
        if (state[2] < MassAndWall::radius) tool.V_WT.v.y = std::nan("");
        return tool;
      },
      "the tool's pose or velocity is not finite");
}

BOOST_AUTO_TEST_SUITE_END()
