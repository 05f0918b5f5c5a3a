// Any shipped graph can be led by a mouse: its device is replaced, its limits stay, and nothing leads it but the feed.
#include "app/view/mouse_graph.hpp"

#include <boost/test/unit_test.hpp>
#include <cctype>
#include <cstdio>
#include <fstream>

#include "framework/core/check.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"

BOOST_AUTO_TEST_SUITE(mouse_graph_test)

using namespace tactor;
namespace fs = std::filesystem;

namespace {

Registry& registry() {
  static Registry all({TACTOR_NODE_FOLDER});
  return all;
}

GraphSpec shipped(const std::string& name, const std::vector<std::string>& sets = {}) {
  Overrides overrides;
  for (const std::string& set : sets) overrides.push_back(set_patch(set));
  return load_graph(fs::path(TACTOR_SOURCE_DIR) / "graphs" / name, registry(), overrides);
}

double param(const NodeSpec& node, const char* name) {
  return std::get<double>(node.params[node.info->param(name).value()]);
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_mouse_takes_the_place_of_the_device_with_its_limits) {
  GraphSpec graph = shipped("wall/scene.yaml", {"device.force_max=3 N", "device.speed_max=0.6 m/s"});
  const Pose start{{0.01, 0.02, 0.03}, from_rotation_vector({0, 0.1, 0})};
  BOOST_TEST(lead_by_mouse(graph, start, registry()) == "device");
  const NodeSpec& mouse = *graph.node("device");
  BOOST_TEST(mouse.info->type == "device.mouse");
  BOOST_TEST(param(mouse, "force_max") == 3.0);
  BOOST_TEST(param(mouse, "rate") == 1000.0);
  BOOST_TEST(param(mouse, "follow_speed") == 0.3);
  BOOST_TEST(std::get<std::int64_t>(mouse.params[mouse.info->param("dead_man_button").value()]) == 1);
  BOOST_TEST(std::get<std::vector<double>>(mouse.params[mouse.info->param("start").value()])[1] == 0.02);
  const Plan plan = make_plan(std::move(graph));
  // The trajectory leads nothing any more.
  for (const NodeSpec& node : plan.nodes) BOOST_TEST((node.info->role != Role::source || node.info->fed), node.name);
  std::size_t feeds = 0;
  for (const PlannedEdge& edge : plan.edges) {
    if (edge.spec.to_node == "device" && edge.spec.to_port == "cursor") ++feeds;
  }
  BOOST_TEST(feeds == 1U);
}

BOOST_AUTO_TEST_CASE(the_handle_begins_where_the_graph_has_it_first) {
  // By the first row of the trajectory, which the device shows at its first tick.
  const Pose first = first_handle_pose(shipped("duck/scene.yaml", {"device.encoder_step=0 m"}));
  std::ifstream file(fs::path(TACTOR_SOURCE_DIR) / "graphs/trajectories/duck_1.csv");
  std::string line;
  while (std::getline(file, line) &&
         (line.empty() || std::isalpha(static_cast<unsigned char>(line[0])) || line[0] == '#')) {
  }
  double t = 0, x = 0, y = 0, z = 0;
  BOOST_REQUIRE(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf", &t, &x, &y, &z) == 4);
  BOOST_TEST(norm(first.p - Vec3{x, y, z}) < 2e-4);  // the tremor of the hand
}

BOOST_AUTO_TEST_CASE(every_shipped_scene_can_be_led) {
  std::size_t scenes = 0;
  for (const auto& folder : fs::directory_iterator(fs::path(TACTOR_SOURCE_DIR) / "graphs")) {
    if (!fs::exists(folder.path() / "scene.yaml")) continue;
    BOOST_TEST_CONTEXT(folder.path()) {
      GraphSpec graph = load_graph(folder.path() / "scene.yaml", registry());
      lead_by_mouse(graph, {}, registry());
      take_out_sinks(graph);
      graph.record = {"device.commanded"};
      BOOST_CHECK_NO_THROW(make_plan(std::move(graph)));
      ++scenes;
    }
  }
  BOOST_TEST(scenes >= 6U);
}

BOOST_AUTO_TEST_CASE(a_graph_without_a_device_or_with_two_is_refused) {
  GraphSpec none = shipped("wall/scene.yaml");
  std::erase_if(none.nodes, [](const NodeSpec& node) { return node.info->actuator; });
  BOOST_CHECK_THROW(device_of(none), InputError);
  GraphSpec two = shipped("wall/scene.yaml");
  NodeSpec copy = *two.node("device");
  copy.name = "other";
  two.nodes.push_back(copy);
  BOOST_CHECK_EXCEPTION(device_of(two), InputError, [](const InputError& error) {
    return std::string(error.what()).find("device and other") != std::string::npos;
  });
}

BOOST_AUTO_TEST_SUITE_END()
