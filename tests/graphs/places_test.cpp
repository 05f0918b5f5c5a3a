// An error points at the file and line where the value was written that it is about, however late the value is looked
// at.
#include <boost/test/unit_test.hpp>
#include <string>
#include <vector>

#include "framework/core/temporary_folder.hpp"
#include "tests/support/page_text.hpp"
#include "tests/support/shipped_graphs.hpp"

BOOST_AUTO_TEST_SUITE(places_test, *boost::unit_test::precondition(tactor::test::NeedsMeshes{}))

using namespace tactor;
using namespace tactor::test;
namespace fs = std::filesystem;

namespace {

const std::string base_graph = R"(clock: virtual
duration: 1 s
scene:
  bodies:
    wall:
      mesh: good.off
    tool:
      sphere: {radius: 4 mm}
      motion: translation
nodes:
  trajectory:
    type: source.trajectory
    points: [{t: 0 s, x: 0 mm}, {t: 1 s, x: 10 mm}]
  device: {type: device.simulated}
  collision: {type: collision.primitive}
  dynamics: {type: dynamics.translation}
  coupling: {type: coupling.adaptive}
  refit: {type: prediction.refit}
  prediction: {type: prediction.ar}
  metrics: {type: sink.metrics}
edges:
  - trajectory.target -> device.target
  - device.state -> collision.device
  - device.state -> dynamics.device
  - collision.contacts -> dynamics.contacts
  - dynamics.state -> collision.state
  - coupling.parameters -> dynamics.coupling
  - dynamics.state -> coupling.state
  - coupling.force -> refit.force
  - coupling.force -> prediction.force
  - refit.coefficients -> prediction.coefficients
  - prediction.forecast -> metrics.forecast
  - coupling.force -> metrics.force
  - device.commanded -> metrics.commanded
)";
/// Of 10 mm, closed and counter-clockwise from outside.
const std::string tetrahedron = "OFF\n4 4 0\n0 0 0\n0.01 0 0\n0 0.01 0\n0 0 0.01\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

struct Fixture {
  TemporaryFolder folder;
  fs::path base = file("base.yaml", base_graph);

  Fixture() {
    file("good.off", tetrahedron);
    file("bad.off", replaced(tetrahedron, "0.01 0 0", "nonsense 0 0"));
    file("huge.off", replaced(tetrahedron, "0.01", "100"));
  }

  fs::path file(const std::string& name, const std::string& text) const { return write(folder.path() / name, text); }

  /// The base graph with a bad mesh.
  fs::path own() const { return file("own.yaml", replaced(base_graph, "good.off", "bad.off")); }

  /// A run refuses the graph with the place, which is in the folder or an option, and says all of these.
  void refused(const std::string& place, const fs::path& graph, const Over& over,
               const std::vector<std::string>& expected) const {
    const std::string error = refusal_of_run(graph, over);
    for (const std::string& text : expected) says(error, text);
    const bool is_there = error.starts_with(place) || error.starts_with((folder.path() / place).string());
    BOOST_TEST(is_there, "expected " << place << ", found " << error);
  }
};

}  // namespace

BOOST_FIXTURE_TEST_CASE(the_graph_is_good, Fixture) {
  BOOST_TEST(refusal(base) == "");
}

BOOST_FIXTURE_TEST_CASE(a_mesh_is_reported_where_the_graph_names_it, Fixture) {
  refused("own.yaml:6:", own(), {}, {"body 'wall'", "bad.off:4"});
}

BOOST_FIXTURE_TEST_CASE(a_mesh_of_an_overriding_file_is_reported_there, Fixture) {
  const fs::path over = file("over.yaml", "title: over\n\nscene:\n  bodies:\n    wall: {mesh: bad.off}\n");
  refused("over.yaml:5:18:", base, {over.string()}, {"bad.off:4"});
}

BOOST_FIXTURE_TEST_CASE(a_mesh_of_an_extending_file_is_reported_there, Fixture) {
  const fs::path child = file("child.yaml", "extends: base.yaml\nscene:\n  bodies:\n    wall:\n      mesh: bad.off\n");
  refused("child.yaml:5:13:", child, {}, {"bad.off:4"});
}

BOOST_FIXTURE_TEST_CASE(a_mesh_of_the_command_line_is_reported_there, Fixture) {
  const std::string said = "scene.bodies.wall.mesh=" + (folder.path() / "bad.off").string();
  refused("--set " + said + ":", base, {said}, {"bad.off:4"});
}

BOOST_FIXTURE_TEST_CASE(a_value_of_the_command_line_is_not_blamed_for_another_one, Fixture) {
  refused("own.yaml:6:", own(), {"collision.margin=2 mm"}, {"bad.off:4"});
}

BOOST_FIXTURE_TEST_CASE(the_size_of_a_body_is_reported_at_its_scale_or_its_mesh, Fixture) {
  const fs::path mesh = file("mesh.yaml", "scene:\n  bodies:\n    wall: {mesh: huge.off}\n");
  refused("mesh.yaml:3:18:", base, {mesh.string()}, {"write scale: 0.001"});
  const fs::path scale = file("scale.yaml", "scene:\n  bodies:\n    wall:\n      scale: 1e9\n");
  refused("scale.yaml:4:14:", base, {scale.string()}, {"a body must be 1 um to 1 km long"});
}

BOOST_FIXTURE_TEST_CASE(way_points_of_a_file_are_reported_where_it_is_named, Fixture) {
  file("path.csv", "t_s,x_mm\n0,0\n1,1\n1,2\n");
  const fs::path over = file("over.yaml", "nodes:\n  trajectory:\n    points: ~\n    file: path.csv\n");
  refused("over.yaml:4:11:", base, {over.string()}, {"path.csv:4", "must increase"});
}

BOOST_FIXTURE_TEST_CASE(a_recording_and_its_columns_are_reported_where_they_are_named, Fixture) {
  file("forces.csv", "t_s,F_N\n0,0\n1,1\n2,oops\n");
  const fs::path replay = file("replay.yaml",
                               "duration: 1 s\nnodes:\n  recording:\n    type: source.recording\n    file: forces.csv\n"
                               "    columns: {time: t_s, force.x: F_N}\n  metrics: {type: sink.metrics}\n"
                               "edges: [recording.force -> metrics.force, recording.force -> metrics.commanded]\n");
  refused("replay.yaml:5:11:", replay, {}, {"forces.csv:4"});
  file("forces.csv", "t_s,F_N\n0,0\n1,1\n2,2\n");
  const fs::path over = file("over.yaml", "nodes:\n  recording:\n    columns:\n      force.x: G_N\n");
  refused("over.yaml:3:5:", replay, {over.string()}, {"G_N"});
}

BOOST_FIXTURE_TEST_CASE(a_parameter_that_a_node_refuses_late_is_reported_where_it_was_written, Fixture) {
  const fs::path over = file("over.yaml", "nodes:\n  refit:\n    window: 30\n    order: 20\n");
  refused("over.yaml:4:12:", base, {over.string()}, {"order: expected at most window / 3"});
  refused("--set refit.order=200:", base, {"refit.order=200"}, {"order"});
  refused("--set trajectory.tremor_low=30 Hz:", base, {"trajectory.tremor_low=30 Hz"},
          {"tremor_low must not be above tremor_high"});
}

BOOST_FIXTURE_TEST_CASE(the_motion_of_a_body_that_its_dynamics_refuses_is_reported_there, Fixture) {
  const fs::path over = file("over.yaml", "scene:\n  bodies:\n    tool:\n      motion: rigid\n");
  refused("over.yaml:4:15:", base, {over.string()}, {"has motion: rigid"});
}

BOOST_AUTO_TEST_SUITE_END()
