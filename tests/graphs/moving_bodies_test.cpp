// Graphs in which several bodies move: they run end to end, and what they lack is told before they run.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "framework/core/messages.hpp"
#include "framework/core/temporary_folder.hpp"
#include "tests/support/page_text.hpp"
#include "tests/support/shipped_graphs.hpp"

BOOST_AUTO_TEST_SUITE(moving_bodies_test, *boost::unit_test::precondition(tactor::test::NeedsMeshes{}))

using namespace tactor;
using namespace tactor::test;
namespace fs = std::filesystem;

namespace {

const fs::path block_scene = graphs / "block_pushed/scene.yaml";

struct Fixture {
  TemporaryFolder folder;
  std::vector<Stamped<BodyStates>> bodies;
  std::vector<Stamped<PhysicsState>> states;

  fs::path graph(const std::string& text) const { return write(folder.path() / "graph.yaml", text); }

  void play(const std::string& text) {
    const RunResult result =
        run(planned(graph(text)), {kept("dynamics.bodies", bodies), kept("dynamics.state", states)},
            {.without_reference = true});
    BOOST_TEST(result.metric("dynamics_damped_steps") == 0);
    BOOST_TEST(result.metric("dynamics_stopped_steps") == 0);
  }

  /// By a check and by a run, with the place in the file that says it.
  void refused(const std::string& text, const std::vector<std::string>& words) const {
    const fs::path file = graph(text);
    for (const std::string& error : {refusal(file), refusal_of_run(file)}) {
      for (const std::string& word : words) says(error, word);
    }
  }
};

double largest(const Vec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

}  // namespace

BOOST_FIXTURE_TEST_CASE(a_pushed_block_rests_where_friction_and_springs_put_it, Fixture) {
  play("extends: " + block_scene.string() + "\nrecord: [dynamics.bodies]\n");
  BOOST_TEST_REQUIRE(!bodies.empty());
  for (const Stamped<BodyStates>& each : bodies) BOOST_TEST_REQUIRE(each.value.count == 2);
  BOOST_TEST(largest(bodies.front().value.X_WB[1].p - Vec3{0, 0, 0.015}) < 1e-4);
  const BodyStates& last = bodies.back().value;
  const Pose& block = last.X_WB[1];
  // Pushed until the ball is 8 mm short of the middle, less what sliding friction stretches the coupling (500 N/m)
  // and presses the contact (two surfaces of 4 N/mm) by. A contact of speed below 0.1 mm/s creeps on.
  const double friction = 0.3 * 0.2 * 9.81;
  near(block.p.x, 0.030 - friction / 500 - friction / 2000, 2e-4);
  near(block.p.y, 0, 1e-4);
  near(block.p.z, 0.015, 2e-4);
  BOOST_TEST(largest({block.R.x, block.R.y, block.R.z}) < 2e-3);
  BOOST_TEST(std::max(largest(last.V_WB[1].v), largest(last.V_WB[1].w)) < 1e-6);
  // The ball is back where the hand is, lower by its weight over the coupling's stiffness.
  BOOST_TEST(largest(last.X_WB[0].p - Vec3{-0.05, 0, 0.015 - 0.05 * 9.81 / 500}) < 1e-4);
}

BOOST_FIXTURE_TEST_CASE(in_free_space_the_block_gets_the_momentum_that_the_tool_gives, Fixture) {
  play("extends: " + block_scene.string() +
       "\nscene: {gravity: [0, 0, 0], bodies: {table: ~}}\n"
       "nodes: {collision: {cost: {base: 0.1 ms, per_contact: 0 ms, jitter: 0 %}}}\n"
       "record: [dynamics.state, dynamics.bodies]\n");
  BOOST_TEST_REQUIRE(bodies.size() > 1U);
  BOOST_TEST_REQUIRE(states.size() == bodies.size());
  Vec3 given;
  const auto momentum = [this](std::size_t i) { return 0.2 * bodies[i].value.V_WB[1].v; };
  double wrong = 0;
  for (std::size_t i = 1; i < bodies.size(); ++i) {
    BOOST_TEST((bodies[i].stamp.valid - bodies[i - 1].stamp.valid).ns == 1'000'000);
    given += -0.001 * states[i].value.contact_T_W.force;
    wrong = std::max(wrong, largest(momentum(i) - momentum(0) - given));
  }
  BOOST_TEST(momentum(bodies.size() - 1).x > 0.001);
  BOOST_TEST(wrong < 1e-12);
}

BOOST_FIXTURE_TEST_CASE(collision_that_is_not_told_where_several_bodies_are_is_refused, Fixture) {
  const std::string untold = replaced(text_in(block_scene), "  - dynamics.bodies -> collision.bodies\n", "");
  refused(untold, {"graph.yaml:",
                   "nodes.collision: expected an edge into collision.bodies (BodyStates), because 2 bodies move: tool, "
                   "block, found none; outputs of that type: dynamics.bodies"});
  // One body is told of by the state, or by nothing.
  BOOST_TEST(refusal(graph(replaced(untold, "motion: rigid\n      mass: 200 g", "motion: static"))) == "");
}

BOOST_FIXTURE_TEST_CASE(a_massless_coupling_for_bodies_of_mass_is_refused, Fixture) {
  refused("extends: " + block_scene.string() + "\nnodes: {coupling: {type: coupling.static}}\n",
          {"block_pushed/scene.yaml:",
           "edge coupling.parameters -> dynamics.coupling: dynamics (dynamics.rigid) does not take the massless "
           "parameters of coupling (coupling.static)",
           "use dynamics.quasistatic"});
  BOOST_TEST(refusal(graph("extends: " + (graphs / "peg_in_hole/scene.yaml").string() +
                           "\nnodes:\n  coupling: {type: coupling.static}\n"
                           "  dynamics: {type: dynamics.quasistatic}\n")) == "");
}

BOOST_AUTO_TEST_SUITE_END()
