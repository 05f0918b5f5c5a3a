// A parameter that is as in another node takes its value from there, unless the graph gives it.
#include <boost/test/unit_test.hpp>

#include "test_nodes.hpp"

using namespace tactor;
using namespace tactor::testing;

namespace {

double margin(const std::string& surface, const std::string& collision, const Overrides& overrides = {}) {
  const Folder folder;
  const std::string nodes = "duration: 1 s\nnodes:\n  surface: {type: test.surface" + surface + "}\n" + collision;
  return std::get<double>(load_text(folder, nodes, overrides).node("surface")->params.at(0));
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_shared_parameter_is_its_own_then_that_of_the_other_node_then_its_default) {
  const std::string given = "  collision: {type: test.collision, margin: 5 mm}\n";
  BOOST_TEST(margin(", margin: 7 mm", given) == 0.007);
  BOOST_TEST(margin("", given) == 0.005);
  BOOST_TEST(margin("", "  collision: {type: test.collision}\n") == 0.001);
  BOOST_TEST(margin("", "") == 0.002);
  BOOST_TEST(margin("", given, {set_patch("collision.margin=3 mm")}) == 0.003);
  BOOST_TEST(margin("", given, {set_patch("surface.margin=4 mm")}) == 0.004);
}
