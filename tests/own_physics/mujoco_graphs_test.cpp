// The shipped graphs with several bodies of MuJoCo, with its rollout.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <string>

#include "framework/node/plugin.hpp"
#include "tests/support/shipped_graphs.hpp"

namespace {

boost::test_tools::assertion_result has_mujoco(boost::unit_test::test_unit_id) {
  boost::test_tools::assertion_result result(tactor::has_plugin("libtactor_mujoco.so"));
  if (!result) result.message() << "this build has no MuJoCo";
  return result;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(mujoco_graphs_test, *boost::unit_test::precondition(has_mujoco))

using namespace tactor;
using namespace tactor::test;

BOOST_AUTO_TEST_CASE(a_block_a_door_and_a_peg_are_rolled_out_nearer_to_physics_than_a_force_that_is_held) {
  for (const std::string name : {"block", "door", "peg"}) {
    BOOST_TEST_CONTEXT(name) {
      const std::string graph = "own_physics/" + name + ".yaml";
      const RunResult held = run(planned(graph, {"duration=1 s"}), {}, {});
      const RunResult rolled = run(planned(graph, {"own_physics/rollout.yaml", "duration=1 s"}), {}, {});
      BOOST_TEST(rolled.metric("rollout.ticks") > 800);
      for (const char* none : {"rollout.held_ticks", "rollout.failed_steps", "rollout.overruns",
                               "rollout.rejected_models", "prediction.rejected_results", "dynamics_dropped_states"}) {
        BOOST_TEST(rolled.metric(none) == 0, none);
      }
      const std::string error = "delivered.force.rms_error_N";
      BOOST_TEST(held.metric(error) > 0);
      BOOST_TEST(rolled.metric(error) < 0.5 * held.metric(error));
    }
  }
}

BOOST_AUTO_TEST_CASE(in_each_tick_nothing_is_predicted_and_the_report_says_so) {
  const RunResult run_whole =
      run(planned("own_physics/block.yaml", {"own_physics/each_tick.yaml", "duration=1 s"}), {}, {});
  BOOST_TEST(run_whole.metric("rollout.failed_steps") == 0);
  BOOST_TEST(run_whole.metric("rollout.overruns") == 0);
  BOOST_TEST(run_whole.metric("rollout.held_ticks") < 20);
  const auto says_so = [](const std::string& text) { return text.find("nothing is predicted") != std::string::npos; };
  BOOST_TEST(std::any_of(run_whole.remarks.begin(), run_whole.remarks.end(), says_so));
}

BOOST_AUTO_TEST_CASE(of_a_pile_of_25_bodies_the_rollout_moves_what_fits_its_budget) {
  const std::string graph = "own_physics/pile.yaml", over = "own_physics/rollout.yaml", brief = "duration=150 ms";
  const RunResult few = run(planned(graph, {over, brief}), {}, {});
  BOOST_TEST(few.metric("rollout.ticks") > 50);
  BOOST_TEST(few.metric("rollout.failed_steps") == 0);
  BOOST_TEST(few.metric("rollout.least_moving_bodies") >= 1);
  BOOST_TEST(few.metric("rollout.most_moving_bodies") < 26);
  const RunResult none = run(planned(graph, {over, brief, "resimulation.budget=0 s"}), {}, {});
  BOOST_TEST(none.metric("rollout.most_moving_bodies") == 1);
}

BOOST_AUTO_TEST_SUITE_END()
