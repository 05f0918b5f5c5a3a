// What a graph file says reaches the spec in SI units; files extend one another; the command line comes last.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <fstream>
#include <numbers>

#include "framework/graph/plan.hpp"
#include "framework/yaml/yaml_values.hpp"
#include "test_nodes.hpp"

BOOST_AUTO_TEST_SUITE(graph_files_test)

using namespace tactor;
using namespace tactor::testing;
namespace fs = std::filesystem;

namespace {

const fs::path good = fs::path(TACTOR_SOURCE_DIR) / "tests/framework/graph/good";

struct Fixture {
  Registry registry = test_registry();
  Folder folder;

  GraphSpec load(const std::string& name, const Overrides& overrides = {}) {
    return load_graph(folder.path() / name, registry, overrides);
  }
};

const ParamValue& param(const GraphSpec& spec, const std::string& node, const std::string& name) {
  const NodeSpec* found = spec.node(node);
  BOOST_REQUIRE(found != nullptr);
  return found->params.at(found->info->param(name).value());
}

std::vector<std::string> edge_names(const GraphSpec& spec) {
  std::vector<std::string> names;
  for (const EdgeSpec& edge : spec.edges) names.push_back(edge.name());
  return names;
}

const std::string base = R"(title: the base
duration: 1 s
scene:
  bodies:
    tool: {sphere: {radius: 4 mm}, motion: rigid, mass: 50 g, material: {friction: 0.5, stiffness: 100}}
    wall: {sphere: {radius: 1 m}}
nodes:
  device: {type: test.device, rate: 500, cost: {per_contact: 1 ms, base: 2 ms}}
  gate: {type: test.gate}
  judge: {type: test.judge}
edges:
  - device.commanded -> gate.in
  - gate.out -> judge.commanded: queue(8, block)
record: [gate.out, device.commanded]
)";

bool same(const CostModel& a, const CostModel& b) {
  return a.kind == b.kind && a.base == b.base && a.each == b.each && a.jitter == b.jitter && a.min == b.min &&
         a.max == b.max && a.trace == b.trace && a.trace_file == b.trace_file;
}

bool same(const Body& a, const Body& b) {
  return a.name == b.name && a.shape == b.shape && a.X_WB == b.X_WB && a.motion == b.motion && a.mass == b.mass &&
         a.inertia == b.inertia && a.material.stiffness == b.material.stiffness &&
         a.material.damping == b.material.damping && a.material.friction == b.material.friction &&
         a.material.patch_area == b.material.patch_area;
}

}  // namespace

BOOST_FIXTURE_TEST_CASE(values_reach_the_spec_in_si_units, Fixture) {
  const GraphSpec spec = load_graph(good / "pipeline.yaml", registry);
  BOOST_TEST(spec.name == "pipeline");
  BOOST_TEST((spec.clock == Clock::real));
  BOOST_TEST(spec.duration.ns == 2'500'000'000);
  BOOST_TEST(spec.seed == 18446744073709551615U);
  BOOST_TEST(std::get<double>(param(spec, "device", "rate")) == 4000.0);
  BOOST_TEST(std::get<double>(param(spec, "device", "encoder_step")) == 1e-5, boost::test_tools::tolerance(1e-15));
  BOOST_TEST(std::get<double>(param(spec, "coupling", "stiffness")) == 800.0, boost::test_tools::tolerance(1e-15));
  BOOST_TEST(std::get<std::int64_t>(param(spec, "values", "count")) == -5);
  BOOST_TEST(std::get<std::string>(param(spec, "values", "label")) == "a \"quoted\" text: with \\ and \t tab");
  BOOST_TEST(std::get<std::string>(param(spec, "values", "data")) == (good / "trace.csv").string());
  const auto gains = std::get<std::vector<double>>(param(spec, "values", "gains"));
  BOOST_TEST(gains == (std::vector<double>{1, 2, 3000}), boost::test_tools::per_element());
  const auto rows = std::get<Table>(param(spec, "values", "rows"));
  const std::vector<double> expected{1e-3, 2e-3, 2e-3, 0.25, 3e-3, 4e-3};
  BOOST_TEST_REQUIRE(rows.values.size() == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) BOOST_TEST(std::abs(rows.values[i] - expected[i]) < 1e-17);
  BOOST_TEST((std::get<Mapping>(param(spec, "values", "names")) == Mapping{{"a", "x"}, {"b c", "y: z"}}));
}

BOOST_FIXTURE_TEST_CASE(a_live_graph_may_go_on_until_it_is_stopped, Fixture) {
  const std::string text = "clock: real\nduration: until stopped\nnodes: {device: {type: test.motor}}\n";
  const GraphSpec spec = load_graph(folder.write("endless.yaml", text), registry);
  BOOST_TEST((spec.duration == until_stopped));
  const GraphSpec again = load_graph(folder.write("again.yaml", to_yaml(spec)), registry);
  BOOST_TEST((again.duration == until_stopped));
  // The device is what it runs for.
  BOOST_TEST(make_plan(spec).nodes.size() == 1U);
  // No time of a file means the same.
  BOOST_TEST((Duration::from_seconds(longest_time_s) < until_stopped));
}

BOOST_FIXTURE_TEST_CASE(bodies_reach_the_scene, Fixture) {
  const GraphSpec spec = load_graph(good / "pipeline.yaml", registry);
  const Body& wall = spec.scene.bodies.at(0);
  BOOST_TEST(wall.material.stiffness == 2000.0, boost::test_tools::tolerance(1e-15));
  BOOST_TEST(wall.material.patch_area == 1e-4, boost::test_tools::tolerance(1e-14));
  // Roll is zero, so x goes to Rz(0.3) Ry(90 deg) x = -z.
  BOOST_TEST(norm(rotate(wall.X_WB.R, {1, 0, 0}) - Vec3{0, 0, -1}) < 1e-15);
  // z goes to Rz(0.3) x.
  BOOST_TEST(norm(rotate(wall.X_WB.R, {0, 0, 1}) - Vec3{std::cos(0.3), std::sin(0.3), 0}) < 1e-15);
  const Body& tool = spec.scene.bodies.at(1);
  BOOST_TEST((spec.scene.tool() == &tool));
  BOOST_TEST(spec.scene.rotates());
  BOOST_TEST(tool.mass == 0.05, boost::test_tools::tolerance(1e-15));
  BOOST_TEST((tool.inertia == Vec3{1e-6, 2e-6, 2.5e-6}));
  BOOST_TEST((tool.X_WB.R == Quat{0.6, 0, 0.8, 0}));
}

BOOST_FIXTURE_TEST_CASE(costs_and_queues_reach_the_spec, Fixture) {
  const GraphSpec spec = load_graph(good / "pipeline.yaml", registry);
  const CostModel& collision = spec.node("collision")->cost;
  BOOST_TEST((collision.kind == CostModel::Kind::per_item));
  BOOST_TEST(collision.each.ns == 500'000);
  BOOST_TEST(collision.base.ns == 6'000'000);
  BOOST_TEST(collision.jitter == 0.1, boost::test_tools::tolerance(1e-15));
  BOOST_TEST(collision.min.ns == 1'000'000);
  BOOST_TEST(collision.max.value().ns == 20'000'000);
  const CostModel& trace = spec.node("coupling")->cost;
  BOOST_TEST((trace.trace == std::vector<Duration>{{5'000'000}, {6'100'000}, {7'000'000}}));
  BOOST_TEST((spec.node("predictor")->cost.kind == CostModel::Kind::none));

  BOOST_TEST(spec.edges[0].queue_is_default);
  BOOST_TEST((spec.edges[1].queue.policy == QueuePolicy::drop_newest));
  BOOST_TEST(spec.edges[1].queue.capacity == 64U);
  BOOST_TEST((spec.edges[2].queue.policy == QueuePolicy::block));
  BOOST_TEST(spec.edges[2].delay.ns == 1'000'000);
  BOOST_TEST(!spec.edges[3].queue_is_default);
  BOOST_TEST(spec.edges[5].delay.ns == 250'000);
  BOOST_TEST(spec.edges[5].queue_is_default);
  // The default is the input's own.
  BOOST_TEST((spec.edges[7].queue.policy == QueuePolicy::drop_oldest));
  BOOST_TEST(spec.edges[7].queue.capacity == 512U);
}

BOOST_FIXTURE_TEST_CASE(written_yaml_loads_to_the_same_graph, Fixture) {
  const GraphSpec spec = load_graph(good / "pipeline.yaml", registry);
  const fs::path file = folder.write("pipeline.yaml", to_yaml(spec));
  const GraphSpec again = load_graph(file, registry);
  BOOST_TEST(again.name == spec.name);
  BOOST_TEST(again.title == spec.title);
  BOOST_TEST((again.clock == spec.clock));
  BOOST_TEST(again.duration.ns == spec.duration.ns);
  BOOST_TEST(again.seed == spec.seed);
  BOOST_TEST((again.live == spec.live));
  BOOST_TEST((again.scene.gravity_W == spec.scene.gravity_W));
  BOOST_TEST((again.scene.camera == spec.scene.camera));
  BOOST_TEST_REQUIRE(again.scene.bodies.size() == spec.scene.bodies.size());
  for (std::size_t i = 0; i < spec.scene.bodies.size(); ++i) {
    BOOST_TEST(same(again.scene.bodies[i], spec.scene.bodies[i]));
  }
  BOOST_TEST_REQUIRE(again.nodes.size() == spec.nodes.size());
  for (std::size_t i = 0; i < spec.nodes.size(); ++i) {
    BOOST_TEST(again.nodes[i].name == spec.nodes[i].name);
    BOOST_TEST(again.nodes[i].info == spec.nodes[i].info);
    BOOST_TEST((again.nodes[i].params == spec.nodes[i].params));
    BOOST_TEST(same(again.nodes[i].cost, spec.nodes[i].cost));
    BOOST_TEST((again.nodes[i].scheduling == spec.nodes[i].scheduling));
  }
  BOOST_TEST_REQUIRE(again.edges.size() == spec.edges.size());
  for (std::size_t i = 0; i < spec.edges.size(); ++i) {
    BOOST_TEST(again.edges[i].name() == spec.edges[i].name());
    BOOST_TEST((again.edges[i].queue.policy == spec.edges[i].queue.policy));
    BOOST_TEST(again.edges[i].queue.capacity == spec.edges[i].queue.capacity);
    BOOST_TEST(again.edges[i].queue_is_default == spec.edges[i].queue_is_default);
    BOOST_TEST(again.edges[i].delay.ns == spec.edges[i].delay.ns);
  }
  BOOST_TEST(again.record == spec.record, boost::test_tools::per_element());
  BOOST_TEST(to_yaml(again) == to_yaml(spec));
}

BOOST_FIXTURE_TEST_CASE(deformable_bodies_are_read_in_SI_units_and_written_so_that_they_load_to_the_same, Fixture) {
  const fs::path file = folder.write("soft.yaml", R"(duration: 1 s
nodes: {v: {type: test.values}}
scene:
  bodies:
    gel:
      box: {size: [80 mm, 80 mm, 40 mm]}
      motion: deformable
      young: 12 kPa
      poisson: 0.4
      density: 1060 kg/m^3
      damping: 5 ms
      drag: 3 1/s
      tetrahedra: 500
      fixed:
        - behind: {p: [0, 0, -20 mm], n: [0, 0, 2]}
        - box: {low: [-40 mm, 0, 0], high: [-40 mm, 1 cm, 0]}
        - faces: lower side
      inclusions:
        lump: {p: [1 mm, 2 mm, 3 mm], radius: 5 mm, young: 0.2 MPa}
    other: {box: {size: [1 cm, 1 cm, 1 cm]}, motion: deformable, cell_size: 2 mm}
)");
  const GraphSpec spec = load_graph(file, registry);
  const Deformable& d = spec.scene.bodies.at(0).deformable;
  BOOST_TEST(d.young == 12e3);
  BOOST_TEST(d.poisson == 0.4);
  BOOST_TEST(d.density == 1060);
  BOOST_TEST(d.damping == 0.005);
  BOOST_TEST(d.drag == 3);
  BOOST_TEST(d.tetrahedra == 500);
  BOOST_TEST_REQUIRE(d.fixed.size() == 3U);
  BOOST_TEST((d.fixed[0] == FixedRegion{HalfSpaceRegion{{0, 0, -0.02}, {0, 0, 2}}}));
  BOOST_TEST((d.fixed[1] == FixedRegion{BoxRegion{{-0.04, 0, 0}, {-0.04, 0.01, 0}}}));
  BOOST_TEST((d.fixed[2] == FixedRegion{NamedFaces{"lower side"}}));
  BOOST_TEST_REQUIRE(d.inclusions.size() == 1U);
  BOOST_TEST((d.inclusions[0].p == Vec3{0.001, 0.002, 0.003}));
  BOOST_TEST(d.inclusions[0].radius == 0.005);
  BOOST_TEST(d.inclusions[0].young == 0.2e6);
  BOOST_TEST(spec.scene.bodies.at(1).deformable.cell_size == 0.002);

  const GraphSpec again = load_graph(folder.write("again.yaml", to_yaml(spec)), registry);
  BOOST_TEST_REQUIRE(again.scene.bodies.size() == 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    BOOST_TEST((again.scene.bodies[i].motion == Motion::deformable));
    BOOST_TEST((again.scene.bodies[i].deformable == spec.scene.bodies[i].deformable));
  }
  BOOST_TEST(to_yaml(again) == to_yaml(spec));
}

BOOST_FIXTURE_TEST_CASE(written_yaml_names_a_trace_by_its_absolute_path_whatever_its_letters, Fixture) {
  const fs::path trace = folder.write("it's a \"trace\": #1/of costs.csv", "0.005\n");
  const fs::path file = folder.write("it's a \"trace\": #1/graph.yaml",
                                     "duration: 1 s\nnodes:\n  v: {type: test.values, cost: {trace: of costs.csv}}\n");
  // A graph that the command line names relative to the folder it runs in.
  const GraphSpec spec = load_graph(fs::relative(file), registry);
  BOOST_TEST(spec.node("v")->cost.trace_file == trace);
  const GraphSpec again = load_graph(folder.write("elsewhere/graph.yaml", to_yaml(spec)), registry);
  BOOST_TEST(again.node("v")->cost.trace_file == trace);
  BOOST_TEST((again.node("v")->cost.trace == std::vector<Duration>{{5'000'000}}));
}

BOOST_FIXTURE_TEST_CASE(aliases_repeat_a_value, Fixture) {
  const GraphSpec spec =
      load_text(folder, "duration: &t 1 s\nnodes:\n  v: &v {type: test.values, pause: *t}\n  w: *v\n");
  BOOST_TEST(std::get<double>(param(spec, "w", "pause")) == 1.0);
}

BOOST_FIXTURE_TEST_CASE(an_extending_file_changes_only_what_it_names, Fixture) {
  static_cast<void>(folder.write("base.yaml", base));
  static_cast<void>(folder.write("middle.yaml", "extends: base.yaml\nduration: 2 s\nnodes:\n  device: {rate: 600}\n"));
  static_cast<void>(folder.write("top.yaml",
                                 "extends: middle.yaml\nnodes:\n  device: {encoder_step: 1 mm, cost: {base: 3 ms}}\n"
                                 "scene: {bodies: {tool: {mass: 70 g, material: {friction: 0.1}}}}\n"));
  const GraphSpec spec = load("top.yaml");
  BOOST_TEST(spec.title == "the base");
  BOOST_TEST(spec.duration.ns == 2'000'000'000);
  BOOST_TEST(std::get<double>(param(spec, "device", "rate")) == 600.0);
  BOOST_TEST(std::get<double>(param(spec, "device", "encoder_step")) == 1e-3);
  BOOST_TEST(spec.node("device")->cost.base.ns == 3'000'000);
  BOOST_TEST(spec.node("device")->cost.each.ns == 1'000'000);
  BOOST_TEST(spec.scene.bodies.at(0).mass == 0.07, boost::test_tools::tolerance(1e-15));
  BOOST_TEST(spec.scene.bodies.at(0).material.friction == 0.1);
  BOOST_TEST(spec.scene.bodies.at(0).material.stiffness == 100.0);
  BOOST_TEST(spec.edges.size() == 2U);
}

BOOST_FIXTURE_TEST_CASE(a_null_takes_out_a_value_of_the_extended_file_so_that_its_default_holds, Fixture) {
  static_cast<void>(folder.write("base.yaml", base));
  static_cast<void>(folder.write("top.yaml", "extends: base.yaml\nnodes:\n  device: {rate: ~, cost: ~}\n"));
  const GraphSpec plain = load("base.yaml");
  const GraphSpec spec = load("top.yaml");
  BOOST_TEST((plain.node("device")->cost.kind != CostModel::Kind::none));
  BOOST_TEST((spec.node("device")->cost.kind == CostModel::Kind::none));
  const auto& params = spec.node("device")->info->params;
  const auto rate = std::find_if(params.begin(), params.end(), [](const auto& p) { return p.name == "rate"; });
  BOOST_REQUIRE((rate != params.end() && rate->default_value));
  BOOST_TEST(std::get<double>(param(plain, "device", "rate")) != std::get<double>(*rate->default_value));
  BOOST_TEST(std::get<double>(param(spec, "device", "rate")) == std::get<double>(*rate->default_value));
}

BOOST_FIXTURE_TEST_CASE(of_several_files_extended_the_later_lies_over_the_earlier, Fixture) {
  static_cast<void>(folder.write("base.yaml", base));
  static_cast<void>(
      folder.write("slow.yaml", "title: slow\nduration: 9 s\nnodes:\n  device: {rate: 300, encoder_step: 2 mm}\n"));
  static_cast<void>(folder.write("fast.yaml", "title: fast\nnodes:\n  device: {rate: 900}\n"));
  static_cast<void>(folder.write("top.yaml", "extends: [base.yaml, slow.yaml, fast.yaml]\nduration: 4 s\n"));
  const GraphSpec spec = load("top.yaml");
  BOOST_TEST(spec.name == "top");
  BOOST_TEST(spec.title == "fast");
  BOOST_TEST(spec.duration.ns == 4'000'000'000);
  BOOST_TEST(std::get<double>(param(spec, "device", "rate")) == 900.0);
  BOOST_TEST(std::get<double>(param(spec, "device", "encoder_step")) == 2e-3);
  // The same by the command line.
  const GraphSpec laid =
      load("base.yaml", {over_patch(folder.path() / "slow.yaml"), over_patch(folder.path() / "fast.yaml")});
  BOOST_TEST(laid.name == "base_slow_fast");
  BOOST_TEST(laid.title == "fast, here with slow");
  BOOST_TEST(laid.duration.ns == 9'000'000'000);
  BOOST_TEST(std::get<double>(param(laid, "device", "rate")) == 900.0);
}

BOOST_FIXTURE_TEST_CASE(files_that_each_extend_several_are_read_within_bounds, Fixture) {
  static_cast<void>(folder.write("f0.yaml", base));
  for (int i = 1; i <= 12; ++i) {
    const std::string below = "f" + std::to_string(i - 1) + ".yaml";
    static_cast<void>(folder.write("f" + std::to_string(i) + ".yaml", "extends: [" + below + ", " + below + "]\n"));
  }
  BOOST_TEST(load("f4.yaml").nodes.size() == 3U);
  const auto too_many = [](const GraphError& e) {
    return std::string(e.what()).find("expected at most 64 files in all") != std::string::npos;
  };
  BOOST_CHECK_EXCEPTION(load("f12.yaml"), GraphError, too_many);
}

BOOST_FIXTURE_TEST_CASE(a_node_of_another_type_takes_nothing_over, Fixture) {
  static_cast<void>(folder.write("base.yaml", base));
  static_cast<void>(folder.write("top.yaml",
                                 "extends: base.yaml\nnodes:\n  gate: {type: test.twist}\nedges:\n"
                                 "  - device.commanded -> gate.force\n  - device.commanded -> gate.in: ~\n"));
  const GraphSpec spec = load("top.yaml");
  BOOST_TEST(spec.node("gate")->info->type == "test.twist");
  static_cast<void>(folder.write(
      "other.yaml", "extends: base.yaml\nnodes:\n  device: {type: test.values}\n  gate: ~\n  judge: ~\nrecord: []\n"));
  const GraphSpec other = load("other.yaml");
  BOOST_TEST(std::get<double>(param(other, "device", "rate")) == 10.0);
  BOOST_TEST((other.node("device")->cost.kind == CostModel::Kind::none));
}

BOOST_FIXTURE_TEST_CASE(a_null_takes_a_node_out_with_its_edges_and_recordings, Fixture) {
  static_cast<void>(folder.write("base.yaml", base));
  static_cast<void>(folder.write("top.yaml",
                                 "extends: base.yaml\nnodes: {gate: ~}\nedges: [device.commanded -> judge.commanded]\n"
                                 "scene: {bodies: {wall: ~}}\n"));
  const GraphSpec spec = load("top.yaml");
  BOOST_TEST(spec.nodes.size() == 2U);
  BOOST_TEST(edge_names(spec) == std::vector<std::string>{"device.commanded -> judge.commanded"},
             boost::test_tools::per_element());
  BOOST_TEST(spec.record == std::vector<std::string>{"device.commanded"}, boost::test_tools::per_element());
  BOOST_TEST(spec.scene.bodies.size() == 1U);
}

BOOST_FIXTURE_TEST_CASE(an_edge_takes_the_place_of_the_one_into_the_same_input, Fixture) {
  static_cast<void>(folder.write("base.yaml", base));
  static_cast<void>(folder.write("top.yaml",
                                 "extends: base.yaml\nedges:\n  - device.commanded -> judge.commanded\n"
                                 "  - gate.out -> judge.force\nrecord: [gate.out]\n"));
  const GraphSpec spec = load("top.yaml");
  const std::vector<std::string> expected{"device.commanded -> gate.in", "device.commanded -> judge.commanded",
                                          "gate.out -> judge.force"};
  BOOST_TEST(edge_names(spec) == expected, boost::test_tools::per_element());
  BOOST_TEST(spec.edges[1].queue_is_default);
  BOOST_TEST(spec.record == std::vector<std::string>{"gate.out"}, boost::test_tools::per_element());
}

BOOST_FIXTURE_TEST_CASE(a_shape_and_a_cost_of_another_kind_replace_the_old_one, Fixture) {
  static_cast<void>(folder.write("base.yaml", base));
  static_cast<void>(folder.write("duck.off", "OFF"));
  static_cast<void>(folder.write("top.yaml",
                                 "extends: base.yaml\nscene: {bodies: {wall: {mesh: duck.off}}}\n"
                                 "nodes: {device: {cost: {constant: 7 ms}}}\n"));
  const GraphSpec spec = load("top.yaml");
  BOOST_TEST(std::holds_alternative<MeshShape>(spec.scene.bodies.at(1).shape));
  BOOST_TEST(spec.scene.bodies.at(1).mesh()->file == folder.path() / "duck.off");
  BOOST_TEST((spec.node("device")->cost.kind == CostModel::Kind::constant));
  BOOST_TEST(spec.node("device")->cost.base.ns == 7'000'000);
}

BOOST_FIXTURE_TEST_CASE(a_shape_without_a_scale_takes_the_parents_scale_away_with_its_mesh, Fixture) {
  static_cast<void>(folder.write("duck.off", "OFF"));
  static_cast<void>(folder.write(
      "mesh.yaml",
      "duration: 1 s\nscene: {bodies: {wall: {mesh: duck.off, scale: 0.001}}}\nnodes: {v: {type: test.values}}\n"));
  static_cast<void>(
      folder.write("box.yaml", "extends: mesh.yaml\nscene: {bodies: {wall: {box: {size: [1, 2, 3]}}}}\n"));
  static_cast<void>(folder.write("goose.off", "OFF"));
  static_cast<void>(folder.write("goose.yaml", "extends: mesh.yaml\nscene: {bodies: {wall: {mesh: goose.off}}}\n"));
  BOOST_TEST((load("goose.yaml").scene.bodies.at(0).shape == Shape(MeshShape{folder.path() / "goose.off"})));
  static_cast<void>(folder.write("large.yaml", "extends: mesh.yaml\nscene: {bodies: {wall: {scale: 2}}}\n"));
  BOOST_TEST((load("box.yaml").scene.bodies.at(0).shape == Shape(BoxShape{{1, 2, 3}})));
  BOOST_TEST((load("large.yaml").scene.bodies.at(0).shape == Shape(MeshShape{folder.path() / "duck.off", 2.0})));
}

BOOST_FIXTURE_TEST_CASE(every_shape_and_the_tool_are_written_as_they_were_read, Fixture) {
  static_cast<void>(folder.write("all.yaml",
                                 "duration: 1 s\nnodes: {v: {type: test.values}}\nscene:\n  tool: pill\n  bodies:\n"
                                 "    ball: {sphere: {radius: 4 mm}, motion: rigid}\n"
                                 "    pill: {capsule: {radius: 4 mm, length: 2 cm}, motion: rigid}\n"
                                 "    block: {box: {size: [1 cm, 2 cm, 3 cm]}}\n"
                                 "    floor: {plane: {}}\n"));
  const GraphSpec spec = load("all.yaml");
  BOOST_REQUIRE(spec.scene.bodies.size() == 4U);
  BOOST_TEST((spec.scene.bodies[0].shape == Shape(SphereShape{0.004})));
  BOOST_TEST((spec.scene.bodies[1].shape == Shape(CapsuleShape{0.004, 0.02})));
  BOOST_TEST((spec.scene.bodies[2].shape == Shape(BoxShape{{0.01, 0.02, 0.03}})));
  BOOST_TEST((spec.scene.bodies[3].shape == Shape(PlaneShape{})));
  BOOST_TEST(spec.scene.tool()->name == "pill");
  BOOST_TEST(spec.scene.moving() == (std::vector<std::size_t>{1, 0}), boost::test_tools::per_element());
  static_cast<void>(folder.write("again.yaml", to_yaml(spec)));
  const GraphSpec again = load("again.yaml");
  for (std::size_t i = 0; i < 4; ++i) BOOST_TEST((again.scene.bodies[i].shape == spec.scene.bodies[i].shape));
  BOOST_TEST(again.scene.tool_name == "pill");
}

BOOST_FIXTURE_TEST_CASE(files_are_found_beside_the_text_that_names_them_and_in_the_users_folders, Fixture) {
  const fs::path inner = folder.write("inner/shape.off", "OFF");
  static_cast<void>(
      folder.write("inner/base.yaml",
                   "duration: 1 s\nscene: {bodies: {wall: {mesh: shape.off}}}\nnodes: {v: {type: test.values}}\n"));
  static_cast<void>(folder.write("top.yaml", "extends: inner/base.yaml\nscene: {bodies: {floor: {mesh: far.off}}}\n"));
  const fs::path far = folder.write("meshes/far.off", "OFF");
  setenv("TACTOR_MESH_PATH", ("/does/not/exist:" + (folder.path() / "meshes").string()).c_str(), 1);
  const GraphSpec spec = load("top.yaml");
  unsetenv("TACTOR_MESH_PATH");
  BOOST_TEST(spec.scene.bodies.at(0).mesh()->file == inner);
  BOOST_TEST(spec.scene.bodies.at(1).mesh()->file == far);
}

BOOST_FIXTURE_TEST_CASE(the_command_line_comes_last, Fixture) {
  const Overrides overrides{set_patch("device.rate=2 kHz"),
                            set_patch("scene.bodies.tool.mass = 90 g"),
                            set_patch("device.cost.constant=1 ms"),
                            set_patch("clock=real"),
                            set_patch("record=[gate.out]"),
                            option_patch("--seed", "seed", "42"),
                            option_patch("--duration", "duration", "0.25")};
  const GraphSpec spec = load_text(folder, base, overrides);
  BOOST_TEST(std::get<double>(param(spec, "device", "rate")) == 2000.0);
  BOOST_TEST(spec.scene.bodies.at(0).mass == 0.09, boost::test_tools::tolerance(1e-15));
  BOOST_TEST((spec.node("device")->cost.kind == CostModel::Kind::constant));
  BOOST_TEST((spec.clock == Clock::real));
  BOOST_TEST(spec.seed == 42U);
  BOOST_TEST(spec.duration.ns == 250'000'000);
  BOOST_TEST(spec.record.size() == 1U);
}

BOOST_FIXTURE_TEST_CASE(a_title_tells_which_node_a_value_has_replaced, Fixture) {
  const Patch swapped = set_patch("judge.type = test.values"), back = set_patch("judge.type = test.judge");
  BOOST_TEST(load_text(folder, base, {set_patch("device.rate=600")}).title == "the base");
  BOOST_TEST(load_text(folder, base, {swapped, back}).title == "the base, here with judge.type = test.judge");
  BOOST_TEST(load_text(folder, base, {back, set_patch("title=mine")}).title == "mine");
}

BOOST_FIXTURE_TEST_CASE(a_copy_of_a_shipped_graph_is_told_how_to_name_what_lay_beside_it, Fixture) {
  static_cast<void>(folder.write("shipped/first/scene.yaml", base));
  static_cast<void>(folder.write("shipped/second/scene.yaml", base));
  static_cast<void>(folder.write("copy.yaml", "extends: scene.yaml\n"));
  static_cast<void>(folder.write("good.yaml", "extends: second/scene\n"));
  setenv("TACTOR_GRAPH_PATH", (folder.path() / "shipped").c_str(), 1);
  std::string said;
  try {
    static_cast<void>(load("copy.yaml"));
  } catch (const InputError& error) {
    said = error.what();
  }
  const GraphSpec spec = load("good.yaml");
  unsetenv("TACTOR_GRAPH_PATH");
  for (const char* words :
       {"first/scene, ", "second/scene, ", "write the one that lay beside it, such as `extends: "}) {
    BOOST_TEST(said.find(words) != std::string::npos, said);
  }
  BOOST_TEST(spec.title == "the base");
}

BOOST_FIXTURE_TEST_CASE(of_several_overrides_the_later_lies_over_the_earlier, Fixture) {
  const fs::path file = folder.write("slow.yaml", "seed: 5\nduration: 9 s\nnodes:\n  device: {rate: 300}\n");
  const Patch over = over_patch(file), rate = set_patch("device.rate=600"), seed = option_patch("--seed", "seed", "7"),
              set_seed = set_patch("seed=8"), duration = option_patch("--duration", "duration", "2");
  const auto rate_of = [&](const Overrides& overrides) {
    return std::get<double>(param(load_text(folder, base, overrides), "device", "rate"));
  };
  BOOST_TEST(rate_of({over, rate}) == 600.0);
  BOOST_TEST(rate_of({rate, over}) == 300.0);
  BOOST_TEST(load_text(folder, base, {over, seed}).seed == 7U);
  BOOST_TEST(load_text(folder, base, {seed, over}).seed == 5U);
  BOOST_TEST(load_text(folder, base, {seed, set_seed}).seed == 8U);
  BOOST_TEST(load_text(folder, base, {set_seed, seed}).seed == 7U);
  BOOST_TEST(load_text(folder, base, {duration, over}).duration.ns == 9'000'000'000);
  BOOST_TEST(load_text(folder, base, {over, duration}).duration.ns == 2'000'000'000);
}

BOOST_FIXTURE_TEST_CASE(a_patch_of_another_file_is_told_at_its_place_there, Fixture) {
  const SourceLocation place{(folder.path() / "study.yaml").string(), 3, 7};
  const auto error = [&](const std::string& path, const std::string& value) {
    return errors_of(folder, base, {{place, Assignment{path, value}}});
  };
  BOOST_TEST(error("device.rate", "3 kg") == place.text() + ": nodes.device.rate: expected a rate (Hz), found 3 kg");
  BOOST_TEST(error("device.rat", "3").starts_with(place.text() + ": nodes.device.rat: expected a parameter"));
  BOOST_TEST(
      error("device.cots.constant", "3").starts_with(place.text() + ": nodes.device.cots: expected a parameter"));
  BOOST_TEST(error("devise.rate", "3").starts_with(place.text() + ": devise: expected a node"));
  // What the graph itself says wrongly stays where it is.
  const std::string found = errors_of(folder, "duration: 1 s\nnodes: {v: {type: test.values, flag: 3}}\n",
                                      {{place, Assignment{"v.count", "4"}}});
  BOOST_TEST(found == (folder.path() / "graph.yaml").string() + ":2:38: nodes.v.flag: expected true or false, found 3");
  // A file that it names is looked for beside it.
  const fs::path data = folder.write("far/data.csv", "1");
  const Patch patch{{(folder.path() / "far/study.yaml").string(), 3, 7}, Assignment{"v.data", "data.csv"}};
  const GraphSpec spec = load_text(folder, "duration: 1 s\nnodes: {v: {type: test.values}}\n", {patch});
  BOOST_TEST(std::get<std::string>(param(spec, "v", "data")) == data.string());
}

BOOST_FIXTURE_TEST_CASE(errors_of_the_command_line_name_the_option, Fixture) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"device.rat=3",
       "--set device.rat=3: nodes.device.rat: expected a parameter of test.device (type, cost, lane, thread, policy, "
       "priority, cpu, rate, encoder_step), found an unknown one; did you mean \"rate\"?"},
      {"devise.rate=3",
       "--set devise.rate=3: devise: expected a node of the graph (device, gate, judge), found none of "
       "that name; did you mean \"device\"?"},
      {"device.rate=3 kg", "--set device.rate=3 kg: nodes.device.rate: expected a rate (Hz), found 3 kg"},
      {"scene.bodies.tol.mass=3",
       "--set scene.bodies.tol.mass=3: scene.bodies.tol: expected a body of the scene (tool, "
       "wall), found none of that name; did you mean \"tool\"?"},
      {"duration",
       "--set duration: expected node.parameter=value, node={type: ...} or node={python: FILE.py:Class}, "
       "scene.bodies.body.key=value, duration=... or seed=..., found no ="},
      {"device=device.mouse", "or node={python: FILE.py:Class}"},
      {"device.rate=[", "--set device.rate=[: expected a name as the key, found a list (or a [ without its ])"},
      {"device..rate=1", "found an empty name"},
      {"durration=1 s", "did you mean \"duration\"?"},
      {"seed=-3", "--set seed=-3: seed: expected a whole number"},
  };
  for (const auto& [text, expected] : cases) {
    std::string found;
    try {
      found = errors_of(folder, base, {set_patch(text)});
    } catch (const GraphError& error) {
      found = error.what();
    }
    BOOST_TEST(found.find(expected) != std::string::npos, text << " gives " << found);
  }
}

BOOST_FIXTURE_TEST_CASE(a_missing_file_and_a_folder_are_told_apart, Fixture) {
  const auto says = [&](const std::string& text) {
    return [text](const GraphError& e) { return std::string(e.what()).find(text) != std::string::npos; };
  };
  BOOST_CHECK_EXCEPTION(load("none.yaml"), GraphError, says("none.yaml: there is no such file"));
  BOOST_CHECK_EXCEPTION(load("."), GraphError, says("expected a graph file, found a folder"));
}

BOOST_FIXTURE_TEST_CASE(a_library_that_cannot_be_loaded_is_an_error_at_the_type_that_needs_it, Fixture) {
  static_cast<void>(folder.write("nodes/libtactor_junk.so", "no library"));
  Registry with_junk({folder.path() / "nodes"});
  const fs::path file = folder.write("junk.yaml", "duration: 1 s\nnodes:\n  a: {type: junk.node}\n");
  const auto at_the_type = [](const GraphError& e) {
    const std::string text = e.what();
    return text.find("junk.yaml:3:13: nodes.a.type: ") != std::string::npos &&
           text.find("libtactor_junk.so: expected a library built for Tactor") != std::string::npos;
  };
  BOOST_CHECK_EXCEPTION(load_graph(file, with_junk), GraphError, at_the_type);
}

BOOST_FIXTURE_TEST_CASE(files_extend_each_other_over_sixteen_levels_and_no_more, Fixture) {
  static_cast<void>(folder.write("f0.yaml", base));
  for (int i = 1; i <= 17; ++i) {
    std::string text = "extends: f";
    text.append(std::to_string(i - 1)).append(".yaml\n");
    std::string name = "f";
    static_cast<void>(folder.write(name.append(std::to_string(i)).append(".yaml"), text));
  }
  BOOST_TEST(load("f16.yaml").nodes.size() == 3U);
  BOOST_CHECK_THROW(load("f17.yaml"), GraphError);
}

BOOST_AUTO_TEST_SUITE_END()
