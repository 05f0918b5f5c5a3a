// A plan shows each of its stages once, in its role, and messages become rows with their times.
#include "app/view/shown_streams.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cstring>
#include <nlohmann/json.hpp>
#include <span>

#include "app/view/hello.hpp"
#include "framework/core/messages.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"
#include "nodes/physics/contact/local_contacts.hpp"
#include "nodes/physics/mesh/body_volume.hpp"
#include "nodes/physics/mesh/deformed_surfaces.hpp"
#include "nodes/physics/mesh/tet_topology.hpp"

BOOST_AUTO_TEST_SUITE(shown_streams_test)

using namespace tactor;
namespace fs = std::filesystem;

namespace {

Registry& registry() {
  static Registry all({TACTOR_NODE_FOLDER});
  return all;
}

Plan plan_of(const std::string& name, const std::vector<std::string>& overs = {}) {
  const fs::path graphs = fs::path(TACTOR_SOURCE_DIR) / "graphs";
  Overrides overrides;
  for (const std::string& over : overs) overrides.push_back(over_patch(graphs / over));
  return make_plan(load_graph(graphs / name, registry(), overrides));
}

const ShownStream& stream(const std::vector<ShownStream>& streams, const std::string& role,
                          const std::string& method = "") {
  const auto found = std::find_if(streams.begin(), streams.end(),
                                  [&](const ShownStream& s) { return s.role == role && s.method == method; });
  BOOST_REQUIRE_MESSAGE(found != streams.end(), role + " " + method);
  return *found;
}

std::size_t count(const std::vector<ShownStream>& streams, const std::string& role) {
  return static_cast<std::size_t>(
      std::count_if(streams.begin(), streams.end(), [&](const ShownStream& s) { return s.role == role; }));
}

constexpr Stamp stamp{{1'000'000'000}, {1'020'000'000}, 7};

}  // namespace

BOOST_AUTO_TEST_CASE(each_stage_of_a_pipeline_has_its_role) {
  const std::vector<ShownStream> streams = shown_streams(plan_of("bunny/refit.yaml"));
  for (const char* role : {"physics", "predicted", "interpolated", "commanded", "handle", "body", "contacts",
                           "contact_count", "delay", "safety"}) {
    BOOST_TEST_CONTEXT(role) {
      BOOST_TEST(count(streams, role) == 1U);
    }
  }
  BOOST_TEST(stream(streams, "commanded").columns.size() == 6U);
  BOOST_TEST(stream(streams, "body").body.value() == 1U);
}

BOOST_AUTO_TEST_CASE(a_scene_without_torque_shows_none) {
  const std::vector<ShownStream> streams = shown_streams(plan_of("duck/refit.yaml"));
  BOOST_TEST(stream(streams, "commanded").columns.size() == 3U);
}

BOOST_AUTO_TEST_CASE(every_moving_body_is_shown) {
  const std::vector<ShownStream> streams = shown_streams(plan_of("block_pushed/scene.yaml"));
  BOOST_TEST(count(streams, "body") == 2U);
}

BOOST_AUTO_TEST_CASE(surfaces_of_deformable_bodies_are_sets_of_points_whose_array_is_left_alone) {
  const std::vector<ShownStream> streams = shown_streams(plan_of("gel_cube/scene.yaml"));
  BOOST_TEST_REQUIRE(count(streams, "surface") == 1U);
  const ShownStream& surface = stream(streams, "surface");
  BOOST_TEST(surface.is_set);
  BOOST_TEST(surface.columns.size() == 3U);
  BOOST_TEST(surface.least_gap.seconds() >= 0.03);
  ArrayPool<ShownPoint> pool(1, 2);
  const auto points = pool.make(2, [](std::span<ShownPoint> p) {
    p[0].p_W = {1, 2, 3};
    p[1].p_W = {4, 5, 6};
  });
  BOOST_TEST_REQUIRE(points.has_value());
  DeformedSurfaces message{*points};
  ShownRows rows;
  for (int i = 0; i < 3; ++i) surface.add(stamp, &message, rows);
  BOOST_TEST(rows.times == (std::vector<double>{1.02}), boost::test_tools::per_element());
  BOOST_TEST(rows.values == (std::vector<float>{1, 2, 3, 4, 5, 6}), boost::test_tools::per_element());
  BOOST_TEST(message.nodes.size() == 2U);
  BOOST_TEST(message.nodes[1].p_W[2] == 6.0F);
  // Still in use: the pool has no array left.
  BOOST_TEST(!pool.make(1, [](std::span<ShownPoint>) {}).has_value());
}

BOOST_AUTO_TEST_CASE(the_contacts_of_a_local_model_are_shown_up_to_their_count) {
  const std::vector<ShownStream> streams = shown_streams(plan_of("bunny/local.yaml"));
  const ShownStream& patch = stream(streams, "patch");
  LocalContacts message;
  for (std::size_t i = 0; i < message.contact.size(); ++i) {
    message.contact[i][0].p_WC = {static_cast<double>(i + 1), 0, 0};
    message.contact[i][0].n_W = {0, 0, 1};
  }
  message.count = 2;
  ShownRows rows;
  patch.add(stamp, &message, rows);
  BOOST_TEST(rows.values == (std::vector<float>{1, 0, 0, 0, 0, 1, 2, 0, 0, 0, 0, 1}), boost::test_tools::per_element());
  // A count beyond the room is of a message that is broken.
  message.count = LocalContacts::capacity + 1;
  rows = {};
  patch.add(stamp, &message, rows);
  BOOST_TEST(rows.values.size() == patch.columns.size() * message.contact.size());
}

BOOST_AUTO_TEST_CASE(the_mesh_of_a_deformable_body_is_the_boundary_of_its_tetrahedra) {
  const Plan plan = plan_of("gel_cube/scene.yaml");
  const Scene& scene = plan.graph.scene;
  const std::vector<std::string> meshes = mesh_messages(scene, [](const std::string&) {});
  const nlohmann::json hello = nlohmann::json::parse(hello_text(plan, shown_streams(plan), {}));
  std::size_t deforming = 0;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const nlohmann::json& told = hello["scene"]["bodies"][b];
    if (scene.bodies[b].motion != Motion::deformable) {
      BOOST_TEST(!told.contains("deforms"));
      continue;
    }
    ++deforming;
    BOOST_TEST(told["deforms"].get<bool>());
    BOOST_TEST(!told["moves"].get<bool>());
    const TetMesh mesh = load_body_volume(scene.bodies[b]).mesh;
    std::uint32_t counts[2];
    std::memcpy(counts, meshes.at(told["mesh"].get<std::size_t>()).data() + 8, sizeof counts);
    BOOST_TEST(counts[0] == surface_nodes(mesh).size());
    BOOST_TEST(counts[1] == mesh.faces.size());
  }
  BOOST_TEST(deforming > 0U);
}

BOOST_AUTO_TEST_CASE(methods_side_by_side_are_choices_with_streams_of_their_own) {
  const Plan plan = plan_of("bunny/scene.yaml", {"methods/side_by_side.yaml"});
  const auto methods = method_switch(plan);
  BOOST_REQUIRE(methods.has_value());
  BOOST_TEST(methods->parameter == "select.use");
  std::vector<std::string> labels;
  for (const MethodSwitch::Choice& choice : methods->choices) labels.push_back(choice.label);
  BOOST_TEST(labels == (std::vector<std::string>{"hold", "fixed", "refitted", "local"}),
             boost::test_tools::per_element());
  const std::vector<ShownStream> streams = shown_streams(plan);
  BOOST_TEST(stream(streams, "predicted", "first").output == "prediction.forecast");
  BOOST_TEST(stream(streams, "predicted", "second").output == "fixed.forecast");
  BOOST_TEST(stream(streams, "predicted", "third").output == "refitted.forecast");
  BOOST_TEST(!method_switch(plan_of("bunny/refit.yaml")).has_value());
}

BOOST_AUTO_TEST_CASE(a_physics_force_is_shown_when_it_arrives_and_a_displayed_one_when_it_is_displayed) {
  const std::vector<ShownStream> streams = shown_streams(plan_of("bunny/refit.yaml"));
  const Wrench wrench{{1, 2, 3}, {4, 5, 6}};
  ShownRows rows;
  stream(streams, "physics").add(stamp, &wrench, rows);
  stream(streams, "commanded").add(stamp, &wrench, rows);
  BOOST_TEST(rows.times == (std::vector<double>{1.02, 1.0}), boost::test_tools::per_element());
  BOOST_TEST(rows.values == (std::vector<float>{1, 2, 3, 4, 5, 6, 1, 2, 3, 4, 5, 6}), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(a_forecast_is_shown_at_the_time_for_which_it_is_expected) {
  const std::vector<ShownStream> streams = shown_streams(plan_of("duck/refit.yaml"));
  Forecast forecast;
  forecast.predicted_D_W[0].force = {1, 2, 3};
  forecast.horizon = 0.016;
  ShownRows rows;
  stream(streams, "predicted").add(stamp, &forecast, rows);
  forecast.count = 0;
  stream(streams, "predicted").add(stamp, &forecast, rows);
  BOOST_REQUIRE(rows.times.size() == 1U);
  BOOST_TEST(rows.times[0] == 1.016, boost::test_tools::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(of_contacts_those_that_touch_are_shown_and_a_set_replaces_the_one_before) {
  const std::vector<ShownStream> streams = shown_streams(plan_of("bunny/refit.yaml"));
  ContactSet contacts;
  contacts.count = 2;
  contacts.contact[0].p_WC = {1, 2, 3};
  contacts.contact[0].n_W = {0, 0, 1};
  contacts.contact[0].distance = -0.001;
  contacts.contact[1].distance = 0.001;
  ShownRows rows;
  const ShownStream& shown = stream(streams, "contacts");
  shown.add(stamp, &contacts, rows);
  shown.add(stamp, &contacts, rows);
  BOOST_TEST(rows.times.size() == 1U);
  BOOST_TEST(rows.values == (std::vector<float>{1, 2, 3, 0, 0, 1, -0.001F}), boost::test_tools::per_element());
  contacts.count = 0;
  shown.add(stamp, &contacts, rows);
  BOOST_TEST(rows.values.empty());
}

BOOST_AUTO_TEST_CASE(a_delay_is_the_age_of_the_sample_behind_a_result) {
  const std::vector<ShownStream> streams = shown_streams(plan_of("duck/refit.yaml"));
  ShownRows rows;
  const Wrench wrench{};
  stream(streams, "delay").add(stamp, &wrench, rows);
  BOOST_TEST(rows.values.at(0) == 0.02F);
}

BOOST_AUTO_TEST_SUITE_END()
