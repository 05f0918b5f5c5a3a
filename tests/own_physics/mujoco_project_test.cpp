// What `tactor new physics --mujoco` writes runs, whatever the model, and views draw the scene of the model.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/new/new_mujoco.hpp"
#include "app/view/drawn_scene.hpp"
#include "app/view/hello.hpp"
#include "app/view/shown_streams.hpp"
#include "framework/core/body_poses.hpp"
#include "tests/own_physics/mujoco_models.hpp"
#include "tests/support/page_text.hpp"
#include "tests/support/shipped_graphs.hpp"

BOOST_AUTO_TEST_SUITE(mujoco_project_test, *boost::unit_test::precondition(tactor::test::NeedsMujoco{}))

using namespace tactor;
using namespace tactor::test;
namespace fs = std::filesystem;

namespace {

const std::string box_of_a_table = R"(<geom name="table" type="box" size="0.1 0.1 0.02" pos="0 0 -0.02"/>)";

/// The graph of a new project around the model.
fs::path project(const fs::path& model, const std::string& tool = "") {
  static const TemporaryFolder folder;
  static int count = 0;
  const std::string name = "p" + std::to_string(count++);
  new_mujoco({.name = name, .model = model, .tool = tool, .folder = folder.path()});
  return folder.path() / name / (name + ".yaml");
}

std::string project_refusal(const fs::path& model, const std::string& tool = "") {
  return refusal_of([&] { project(model, tool); });
}

std::string body(const std::string& name, const std::string& inside) {
  return "<body name=\"" + name + "\">" + inside + R"(<geom type="sphere" size="0.01" mass="0.05"/></body>)";
}

const std::string hinge = R"(<joint type="hinge" axis="0 0 1"/>)";

}  // namespace

BOOST_AUTO_TEST_CASE(a_project_presses_on_the_nearest_surface_and_its_rollout_is_nearer_to_physics) {
  const fs::path graph = project(model_file(box_of_a_table + ball(slides, "0.02 0 0.05"), weightless));
  const RunResult held = run(planned(graph, {"duration=4 s"}));
  // The spring of the coupling and the table's, in series, give less than the coupling's alone.
  BOOST_TEST(held.metric("reference.force.rms_N") > 0.05);
  const RunResult rolled = run(planned(graph, {"own_physics/rollout.yaml", "duration=4 s"}));
  BOOST_TEST(rolled.metric("delivered.force.rms_error_N") < 0.5 * held.metric("delivered.force.rms_error_N"));
  // The ball of 10 mm touches where its middle is 10 mm above the table: 3 mm deeper is the end of the way.
  says(text_in(graph), "z: 7 mm}");
}

BOOST_AUTO_TEST_CASE(models_with_includes_elsewhere_meshes_and_blanks_run_where_they_lie) {
  const TemporaryFolder folder;
  const fs::path home = folder.path() / "my models";
  fs::create_directories(home / "parts");
  fs::create_directories(home / "shapes");
  write(home / "shapes/tet.obj", "v 0 0 0\nv 0.03 0 0\nv 0 0.03 0\nv 0 0 0.03\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  write(home / "parts/hand.xml",
        "<mujoco><worldbody><body name=\"the hand\" pos=\"0 0 0.1\"><freejoint/>"
        "<geom type=\"mesh\" mesh=\"tet\" mass=\"0.1\"/></body></worldbody></mujoco>");
  const fs::path model = write(home / "a model.xml",
                               "<mujoco><compiler meshdir=\"shapes\"/><asset><mesh name=\"tet\" file=\"tet.obj\"/>"
                               "</asset><include file=\"parts/hand.xml\"/><worldbody>" +
                                   box_of_a_table + "</worldbody></mujoco>");
  const fs::path graph = project(model);
  says(text_in(graph), "tool: \"the hand\"");
  BOOST_TEST(run(planned(graph, {"duration=1 s"})).metric("dynamics_steps") > 0);
  // Beside the model, the project names it from its own folder.
  new_mujoco({.name = "beside", .model = model, .tool = {}, .folder = home});
  says(text_in(home / "beside/beside.yaml"), "model: \"../a model.xml\"");
  BOOST_TEST(run(planned(home / "beside/beside.yaml", {"duration=0.1 s"})).metric("dynamics_steps") > 0);
}

BOOST_AUTO_TEST_CASE(the_tool_is_chosen_by_the_stated_rule_or_the_bodies_are_listed) {
  const auto chosen = [](const std::string& world) {
    const fs::path model = model_file(world);
    return choose_tool(load_mujoco_plugin("a test").bodies(model), model);
  };
  BOOST_TEST(chosen(body("any", "<freejoint/>") + body("door", hinge)) == "any");
  BOOST_TEST(chosen(body("any", "<freejoint/>") + body("gripper", slides) + body("ee", slides)) == "ee");
  // The name alone is not enough.
  BOOST_TEST(chosen(body("tool", hinge) + body("any", "<freejoint/>")) == "any");
  const std::string several = project_refusal(model_file(body("a", "<freejoint/>") + body("b", slides)));
  says(several, "several bodies can be the tool; choose one by --tool");
  says(several, "a: free joint, can be the tool");
  says(several, "b: 3 slide joints, can be the tool");
  const std::string arm =
      project_refusal(model_file("<body name=\"upper\">" + hinge + R"(<geom size="0.01"/><body name="fore">)" + hinge +
                                 R"(<geom size="0.01"/></body></body><body name="marker" mocap="true"/>)"));
  says(arm, "no body of the model can be the tool");
  says(arm, "upper: hinge joint\n");
  says(arm, "fore: hinge joint on body 'upper'");
  says(arm, "marker: no joint, moved by mocap");
  says(project_refusal(model_file(plane)), "none that has a name");
  says(project_refusal(model_file(body("a", slides)), "b"), "has no body 'b'");
  says(project_refusal(model_file(body("a", hinge)), "a"), "body 'a' has other joints");
}

BOOST_AUTO_TEST_CASE(a_file_that_is_no_model_is_told_in_the_words_of_mujoco) {
  const fs::path broken = model_file("<body><geom type=\"cube\" size=\"1\"/></body>");
  const std::string said = project_refusal(broken);
  says(said, broken.string() + ": MuJoCo cannot read it: ");
  says(said, "cube");
  says(project_refusal("/nowhere/model.xml"), "found no file /nowhere/model.xml");
}

BOOST_AUTO_TEST_CASE(a_view_is_told_each_geom_with_its_kind_and_its_first_pose) {
  const std::string rotated = "quat=\"0.5 0.5 0.5 0.5\"";  // x to y, y to z, z to x
  const fs::path model = model_file(
      "<geom name=\"ground\" type=\"plane\" size=\"1 1 0.1\" pos=\"0 0 -0.2\"/>"
      "<geom name=\"collision\" type=\"box\" size=\"1 1 1\" pos=\"0 0 -5\" group=\"3\"/>"
      "<geom name=\"clear\" type=\"sphere\" size=\"1\" pos=\"0 0 -9\" rgba=\"1 1 1 0\"/>"
      "<body name=\"tool\" pos=\"0 0 0.3\"><freejoint/><geom type=\"capsule\" size=\"0.01 0.02\" mass=\"0.1\"/></body>"
      "<body name=\"door\" pos=\"1 2 3\" " +
          rotated +
          "><joint type=\"hinge\" axis=\"0 0 1\" limited=\"true\" range=\"0 1\"/>"
          "<geom name=\"leaf\" type=\"box\" size=\"0.1 0.2 0.3\" pos=\"0.1 0 0\"/>"
          "<geom type=\"cylinder\" size=\"0.02 0.05\" pos=\"0 0 0.4\"/>"
          "<geom type=\"ellipsoid\" size=\"0.01 0.02 0.03\"/></body>",
      weightless);
  const Plan plan = planned(project(model));
  // No body stands in the graph.
  BOOST_REQUIRE(plan.graph.scene.bodies.size() == 1U);
  BOOST_TEST(plan.graph.scene.bodies[0].mass == 0.1, boost::test_tools::tolerance(1e-12));
  BOOST_TEST(norm(plan.graph.scene.gravity_W) == 0.0);
  const auto drawn = std::make_shared<const DrawnScene>(drawn_scene(plan.graph));
  const std::vector<ShownStream> streams = shown_streams(plan, *drawn);
  HelloExtras extras;
  extras.drawn = drawn;
  extras.start.p = {0, 0, 0.5};
  const nlohmann::json hello = nlohmann::json::parse(hello_text(plan, streams, extras));
  std::map<std::string, nlohmann::json> told;
  for (const nlohmann::json& one : hello["scene"]["bodies"]) told[one["name"]] = one;
  BOOST_REQUIRE(told.size() == 5U);
  const auto pose_is = [&](const std::string& name, const Vec3& p) {
    for (std::size_t i = 0; i < 3; ++i)
      BOOST_TEST(std::abs(told.at(name)["pose"][i].get<double>() - p[static_cast<int>(i)]) < 1e-12, name);
  };
  BOOST_TEST(told.at("ground").contains("plane"));
  pose_is("ground", {0, 0, -0.2});
  BOOST_TEST(told.at("tool")["capsule"]["length"].get<double>() == 0.04);
  BOOST_TEST(told.at("tool")["tool"].get<bool>());
  pose_is("tool", {0, 0, 0.5});  // where the handle begins
  BOOST_TEST(told.at("leaf")["box"]["size"][2].get<double>() == 0.6);
  BOOST_TEST(told.at("leaf")["moves"].get<bool>());
  pose_is("leaf", {1, 2.1, 3});  // the door's x is y of the world
  pose_is("door", {1.4, 2, 3});  // its z is x
  BOOST_TEST(std::abs(told.at("leaf")["pose"][4].get<double>() - 0.5) < 1e-12);
  BOOST_TEST(told.at("door").contains("mesh"));
  BOOST_TEST(told.at("door 2").contains("mesh"));
  const std::vector<std::string> meshes = mesh_messages(*drawn, [](const std::string&) {});
  BOOST_TEST(hello["meshes"].get<std::size_t>() == 2U);
  BOOST_TEST(meshes.size() == 2U);
  BOOST_TEST(std::count_if(streams.begin(), streams.end(), [](const ShownStream& s) { return s.role == "body"; }) == 4);
}

BOOST_AUTO_TEST_CASE(the_poses_of_more_bodies_than_a_scene_may_have_are_told_and_only_where_somebody_reads_them) {
  constexpr int bodies = 25;
  constexpr double g = 9.81;
  std::string world = ball(slides, "-1 0 5");
  for (int i = 0; i < bodies; ++i) {
    world += "<body name=\"b" + std::to_string(i) + "\" pos=\"" + std::to_string(i) + " 0 9\"><freejoint/>" +
             R"(<geom type="sphere" size="0.1" mass="1"/></body>)";
  }
  const Plan plan = planned(project(model_file(world), "tool"), {"duration=0.5 s", "physics.cost={constant: 10 ms}"});
  const DrawnScene drawn = drawn_scene(plan.graph);
  std::vector<ShownStream> streams = shown_streams(plan, drawn);
  std::erase_if(streams, [](const ShownStream& s) { return s.role != "body"; });
  BOOST_REQUIRE(streams.size() == 1U + bodies);
  std::vector<ShownRows> rows(streams.size());
  const auto listener = [&](Session& session) {
    session.on_message("physics.poses", [&](const Stamp& stamp, const void* value) {
      for (std::size_t i = 0; i < streams.size(); ++i) {
        rows[i] = {};
        streams[i].add(stamp, value, rows[i]);
      }
      if (stamp.valid.seconds() < 0.3) return;
      const double t = stamp.valid.seconds(), fallen = 9 - 0.5 * g * t * t;
      for (std::size_t i = 1; i < streams.size(); ++i) {
        BOOST_REQUIRE(std::abs(rows[i].values[0] - static_cast<double>(i - 1)) < 1e-6);
        BOOST_REQUIRE(std::abs(rows[i].values[2] - fallen) < 0.01);
      }
    });
  };
  const RunResult result = run(plan, {listener});
  BOOST_TEST(result.metric("dynamics_steps") > 0);
  BOOST_TEST(!rows[1].values.empty());
}

BOOST_AUTO_TEST_CASE(a_name_that_the_graph_and_the_model_have_is_refused_with_both_places) {
  const fs::path graph = project(model_file(box_of_a_table + ball(slides), weightless));
  const fs::path over = graph.parent_path() / "over.yaml";
  const auto said = [&](const std::string& name) {
    write(over, "format: 2\nscene: {bodies: {" + name + ": {sphere: {radius: 1 mm}}}}\n");
    return refusal_of([&] { drawn_scene(loaded(graph, {over.string()})); });
  };
  says(said("table"), "over.yaml:2:");
  says(said("table"), "node physics (" + graph.string() + ":");
  says(said("tool"), "has a tool of this name");
  BOOST_TEST(said("else").empty());
}

BOOST_AUTO_TEST_SUITE_END()
