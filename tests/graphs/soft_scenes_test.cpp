// Scenes that deform: what is refused, and what is said of them.
#include <boost/test/unit_test.hpp>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "framework/core/temporary_folder.hpp"
#include "tests/support/page_text.hpp"
#include "tests/support/shipped_graphs.hpp"

BOOST_AUTO_TEST_SUITE(soft_scenes_test, *boost::unit_test::precondition(tactor::test::NeedsMeshes{}))

using namespace tactor;
using namespace tactor::test;
namespace fs = std::filesystem;

namespace {

const fs::path gel = "gel_cube/scene.yaml";
const std::string box = "box: {size: [80 mm, 80 mm, 40 mm]}";
const std::string fixed = "fixed: {behind: {p: [0, 0, -20 mm], n: [0, 0, 1]}}";
const std::string sides = "3 0 2 1\n3 0 3 2\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n";
/// A box of 40 mm without its top.
const std::string open_box =
    "OFF\n8 10 0\n0 0 0\n0.04 0 0\n0.04 0.04 0\n0 0.04 0\n0 0 0.04\n0.04 0 0.04\n0.04 0.04 0.04\n0 0.04 0.04\n" + sides;
/// A box of 40 mm with one corner pulled out through the opposite one.
const std::string cuts_itself =
    "OFF\n8 12 0\n0 0 0\n0.04 0 0\n0.04 0.04 0\n0 0.04 0\n0 0 0.04\n0.04 0 0.04\n-0.02 -0.02 -0.02\n0 0.04 0.04\n" +
    sides + "3 4 5 6\n3 4 6 7\n";

using Changes = std::vector<std::pair<std::string, std::string>>;

struct Fixture {
  TemporaryFolder folder;
  const std::string scene = text_in(graphs / gel);

  /// The shipped scene with texts replaced, each of which it has.
  fs::path changed(const Changes& changes) const {
    std::string text = scene;
    for (const auto& [before, after] : changes) text = replaced(text, before, after);
    return write(folder.path() / "scene.yaml", text);
  }

  void refused(const std::string& reason, const Changes& changes) const { says(refusal(changed(changes)), reason); }

  /// The scene's text from `begin` up to `end`.
  std::string part(const std::string& begin, const std::string& end) const {
    return scene.substr(scene.find(begin), scene.find(end) - scene.find(begin));
  }
};

}  // namespace

BOOST_FIXTURE_TEST_CASE(dynamics_of_rigid_bodies_refuses_a_scene_that_deforms, Fixture) {
  for (const std::string kind : {"dynamics.rigid", "dynamics.translation"}) {
    refused(kind + " moves rigid bodies, and body 'gel' deforms; use dynamics.deformable",
            {{"type: dynamics.deformable", "type: " + kind}});
  }
}

BOOST_AUTO_TEST_CASE(a_step_of_rigid_bodies_in_the_tick_refuses_a_scene_that_deforms) {
  says(refusal(gel, {"methods/direct.yaml"}),
       "interpolation.direct steps rigid bodies, and body 'gel' deforms; use --over local");
}

BOOST_AUTO_TEST_CASE(the_cost_of_a_node_that_is_left_out_is_told) {
  says(explained(gel, {"collision.cost={constant: 5 ms}"}),
       "its declared cost is left out too: give a cost to the node that does its work");
}

BOOST_FIXTURE_TEST_CASE(an_open_mesh_cannot_deform, Fixture) {
  write(folder.path() / "open.off", open_box);
  refused("open.off", {{box, "mesh: open.off"}});
}

BOOST_FIXTURE_TEST_CASE(a_surface_that_cuts_itself_is_refused_with_the_place_and_what_to_try, Fixture) {
  write(folder.path() / "bow.off", cuts_itself);
  refused("the surface cuts itself", {{box, "mesh: bow.off"}});
  refused("or try `tactor mesh repair", {{box, "mesh: bow.off"}});
}

BOOST_FIXTURE_TEST_CASE(a_run_refuses_what_check_refuses_with_the_line, Fixture) {
  const std::vector<std::tuple<std::string, std::string, std::string>> refusals{
      {"expected a file that exists", box, "mesh: nowhere.off"},
      {"did you mean \"young\"?", "young: 20 kPa", "youngs: 20 kPa"},
      {"expected a number from 0 to 0.495", "poisson: 0.45", "poisson: 0.5"},
      {"hold all its nodes", "p: [0, 0, -20 mm]", "p: [0, 0, 40 mm]"},
      {"contains no centroid of a tetrahedron", fixed,
       fixed + "\n      inclusions: {lump: {p: [1, 0, 0], radius: 5 mm, young: 200 kPa}}"}};
  for (const auto& [reason, before, after] : refusals) {
    BOOST_TEST_CONTEXT(reason) {
      const std::string error = refusal_of_run(changed({{before, after}}), {"duration=0.1 s"});
      says_like(error, R"(scene\.yaml:\d+:\d+: )");
      says(error, reason);
    }
  }
}

BOOST_FIXTURE_TEST_CASE(faces_of_a_name_that_the_mesh_does_not_have_are_refused, Fixture) {
  refused("it has no faces named 'bottom'", {{fixed, "fixed: {faces: bottom}"}});
}

BOOST_FIXTURE_TEST_CASE(a_region_that_holds_nothing_is_refused_with_where_the_body_is, Fixture) {
  refused("holds no node of it; the body lies between", {{"p: [0, 0, -20 mm]", "p: [0, 0, -30 mm]"}});
}

BOOST_FIXTURE_TEST_CASE(a_scene_without_a_tool_is_refused, Fixture) {
  refused("nothing in the scene moves", {{part("    tool:\n", "\nnodes:"), ""}});
}

BOOST_FIXTURE_TEST_CASE(dynamics_of_deformable_bodies_needs_one, Fixture) {
  refused("dynamics.deformable needs a body with motion: deformable",
          {{part("      young:", "      material:"), ""}, {"motion: deformable", "motion: static"}});
}

BOOST_FIXTURE_TEST_CASE(a_body_that_nothing_holds_is_warned_of_where_it_has_weight_and_only_there, Fixture) {
  const std::string warning = "find no balance under their weight";
  says_not(notes_of(changed({{fixed, "drag: 0 1/s"}})), warning);
  const std::string heavy =
      notes_of(changed({{fixed, "drag: 0 1/s"}, {"gravity: [0, 0, 0]", "gravity: [0, 0, -9.81]"}}));
  says(heavy, warning);
  says(heavy, "body 'gel' is held nowhere and falls: give it `fixed`");
}

BOOST_AUTO_TEST_CASE(a_body_softer_than_any_tissue_is_warned_of) {
  for (const auto& [young, warned] :
       {std::pair<std::string, bool>{"20", true}, {"20 kPa", false}, {"0.1 kPa", false}}) {
    const std::string notes = notes_of(gel, {"scene.bodies.gel.young=" + young});
    BOOST_TEST((notes.find("young is " + young + " Pa, softer than any tissue") != std::string::npos) == warned, notes);
  }
}

BOOST_AUTO_TEST_CASE(check_tells_tetrahedra_solver_and_why_collision_is_left_out) {
  const std::string notes = notes_of(gel);
  says_like(notes, R"(body 'gel': [\d,]+ tetrahedra, [\d,]+ nodes)");
  says(notes, "solver auto is eigen, because there are fewer than 1,000 tetrahedra");
  says(explained(gel), "dynamics.deformable finds those contacts itself");
}

BOOST_AUTO_TEST_SUITE_END()
