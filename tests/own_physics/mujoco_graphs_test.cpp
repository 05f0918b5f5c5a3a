// The shipped graphs with several bodies of MuJoCo, with its rollout.
#include <boost/test/unit_test.hpp>

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

BOOST_AUTO_TEST_SUITE_END()
