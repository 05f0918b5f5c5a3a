// What a shipped scene does not need is left out of its runs, and a check says why.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <vector>

#include "app/run/summary.hpp"
#include "tests/support/page_text.hpp"
#include "tests/support/shipped_graphs.hpp"

BOOST_AUTO_TEST_SUITE(left_out_test, *boost::unit_test::precondition(tactor::test::NeedsMeshes{}))

using namespace tactor;
using namespace tactor::test;

namespace {

RunResult brief_run(const std::string& graph) {
  return run(planned(graph, {"duration=0.5 s"}));
}

/// Why it is left out; empty where it is not.
std::string why_left_out(const RunResult& result, const std::string& what) {
  for (const LeftOut& left : result.left_out) {
    if (left.what.find(what) != std::string::npos) return left.why;
  }
  return {};
}

bool has_node(const RunResult& result, const std::string& name) {
  return std::any_of(result.nodes.begin(), result.nodes.end(), [&](const NodeCost& node) { return node.node == name; });
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_translation_only_scene_computes_no_torque_and_says_so) {
  const RunResult result = brief_run("duck/refit.yaml");
  BOOST_TEST(why_left_out(result, "torque") != "");
  for (const auto& [name, value] : result.metrics) BOOST_TEST(!name.starts_with("delivered.torque"), name);
  says(explained("duck/refit.yaml"), "torque");
}

BOOST_AUTO_TEST_CASE(fixed_coefficients_start_no_refitter) {
  const RunResult result = brief_run("duck/fixed.yaml");
  BOOST_TEST(!has_node(result, "refit"));
  BOOST_TEST(result.metric("refits") == 0);
  BOOST_TEST(std::count_if(result.left_out.begin(), result.left_out.end(),
                           [](const LeftOut& left) { return left.what.find("node refit") != std::string::npos; }) == 1);
  BOOST_TEST(why_left_out(result, "node refit").size() > 5U);
  says(explained("duck/fixed.yaml"), "coefficients are fixed");
}

BOOST_AUTO_TEST_CASE(the_collision_that_suits_the_scene_is_chosen_and_told) {
  const std::vector<std::tuple<std::string, std::string, std::string>> scenes{
      {"duck/off.yaml", "collision.primitive", "the moving body tool is a sphere"},
      {"peg_in_hole/off.yaml", "collision.sdf", "the moving body tool is a mesh"},
      {"peg_free/off.yaml", "collision.none", "the scene has nothing to hit"}};
  for (const auto& [graph, kind, why] : scenes) {
    const std::string text = explained(graph);
    says(text, "collision.auto is " + kind);
    says(text, why);
  }
  const RunResult result = brief_run("duck/off.yaml");
  BOOST_TEST(node_of(result, "collision").type == "collision.primitive");
  BOOST_TEST(to_json(result).at("chosen").dump() ==
             R"([{"node":"collision","asked":"collision.auto","type":"collision.primitive",)"
             R"("why":"the moving body tool is a sphere"}])");
}

BOOST_AUTO_TEST_CASE(nothing_to_hit_needs_no_collision) {
  const RunResult result = brief_run("peg_free/off.yaml");
  BOOST_TEST(why_left_out(result, "collision") != "");
  BOOST_TEST(!has_node(result, "collision"));
}

BOOST_AUTO_TEST_SUITE_END()
