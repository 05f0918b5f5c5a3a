// A scene of MuJoCo in which some trees move: against models of these trees alone, and which trees are chosen.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "framework/realtime/allocation_watch.hpp"
#include "tests/own_physics/mujoco_models.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(mujoco_trees_test, *boost::unit_test::precondition(tactor::test::NeedsMujoco{}))

using namespace tactor;
using namespace tactor::test;

namespace {

constexpr double h = 5e-4;
const std::string head = R"(<option gravity="0 0 -9.81" cone="elliptic"/><size njmax="1500" nconmax="500"/>)";
const std::string tool = ball(slides, "0 0 0.03");

std::string box(const std::string& name, const std::string& place) {
  return "<body name=\"" + name + "\" pos=\"" + place +
         "\"><freejoint/><geom type=\"box\" size=\"0.02 0.02 0.02\" mass=\"0.1\"/></body>";
}

/// Two links on a hinge each, and motors with a state.
std::string arm(const std::string& name, const std::string& place) {
  return "<body name=\"" + name + "\" pos=\"" + place + "\"><joint name=\"" + name +
         R"(_1" type="hinge" axis="0 0 1" damping="0.01"/><geom type="capsule" fromto="0 0 0 0.1 0 0" size="0.01" mass="0.2"/>
      <site name=")" +
         name + R"(_site"/><body pos="0.1 0 0"><joint name=")" + name +
         R"(_2" type="hinge" axis="0 0 1"/><geom type="capsule" fromto="0 0 0 0.1 0 0" size="0.01" mass="0.2"/></body></body>)";
}
std::string motors(const std::string& name) {
  return "<general joint=\"" + name + "_2\" dyntype=\"filter\" dynprm=\"0.05\" gainprm=\"0.01\"/>";
}

std::unique_ptr<CoupledEngine> partial(const std::filesystem::path& file, const std::string& keyframe = "") {
  return load_mujoco_plugin("a test").engine(
      {.file = file, .tool = "tool", .keyframe = keyframe, .bodies = {}, .partial = true});
}

/// Numbers that outlive the next step.
struct Kept {
  explicit Kept(const EngineNumbers& n)
      : position(n.position.begin(), n.position.end()),
        velocity(n.velocity.begin(), n.velocity.end()),
        activation(n.activation.begin(), n.activation.end()),
        acceleration(n.acceleration.begin(), n.acceleration.end()) {}
  [[nodiscard]] EngineNumbers numbers() const { return {position, velocity, activation, acceleration}; }
  std::vector<double> position, velocity, activation, acceleration;
};

/// Presses down and slides along x.
DeviceState pressing(int i) {
  DeviceState handle;
  handle.X_WD.p = {5e-5 * i, 0, 0.03 - 0.012 * std::min(1.0, i / 200.0)};
  handle.V_WD.v = {5e-5 / h, 0, 0};
  return handle;
}

/// The largest difference of the contacts' force between two engines, N, which feel at least `felt` N.
double difference(CoupledEngine& a, CoupledEngine& b, double felt) {
  double worst = 0, most = 0;
  for (int i = 1; i <= 800; ++i) {
    BOOST_REQUIRE_MESSAGE(a.step(stiff, pressing(i), h, nullptr), a.failure());
    BOOST_REQUIRE_MESSAGE(b.step(stiff, pressing(i), h, nullptr), b.failure());
    worst = std::max(worst, norm(a.tool().contact_T_W.force - b.tool().contact_T_W.force));
    most = std::max(most, norm(b.tool().contact_T_W.force));
  }
  BOOST_TEST(most > felt);
  return worst;
}

Trees chosen(CoupledEngine& engine, const TreeSearch& search) {
  const Kept at(engine.numbers());
  return engine.near_trees(at.numbers(), search);
}

}  // namespace

BOOST_AUTO_TEST_CASE(one_tree_that_moves_among_many_is_as_in_a_model_of_it_alone) {
  const std::string near = box("near", "0.03 0 0.02");
  const auto many = partial(
      model_file(plane + box("far", "0.5 0.5 0.3") + arm("a", "0.3 0 0.1") + tool + near + box("other", "-0.4 0.5 0.3"),
                 head, "<actuator>" + motors("a") + "</actuator>"));
  const auto alone = engine_of(model_file(plane + tool + near, head));
  BOOST_TEST(many->moving_bodies() == 5);
  // Trees are numbered from the tool's, in the order of the model.
  many->let_move(0b1001);
  const Kept begin(many->numbers());
  BOOST_REQUIRE(many->restore(begin.numbers()));
  BOOST_TEST(many->moving_bodies() == 2);
  BOOST_TEST(difference(*many, *alone, 0.5) < 1e-9);
  const Kept end(many->numbers());
  BOOST_REQUIRE(end.position.size() == begin.position.size());
  // The far box, the arm, then the tool, the near box and the other one.
  for (std::size_t i = 0; i < begin.position.size(); ++i) {
    const bool moves = i >= 9 && i < 19;
    if (!moves) BOOST_TEST(end.position[i] == begin.position[i]);
  }
  BOOST_TEST(end.position[12] - begin.position[12] > 0.005);
}

BOOST_AUTO_TEST_CASE(a_tree_that_stands_pushes_as_a_body_without_a_joint) {
  const std::string place = "<body pos=\"0.01 0 0.01\" euler=\"0 0 30\">",
                    geom =
                        R"(<geom type="box" size="0.04 0.02 0.01" pos="0.01 0 0" euler="0 5 20" mass="0.1"/></body>)";
  const auto stands = partial(model_file(plane + place + "<freejoint/>" + geom + tool, head));
  const auto fixed = engine_of(model_file(plane + place + geom + tool, head));
  stands->let_move(1);
  const Kept begin(stands->numbers());
  BOOST_REQUIRE(stands->restore(begin.numbers()));
  BOOST_TEST(difference(*stands, *fixed, 1.0) < 1e-9);
}

BOOST_AUTO_TEST_CASE(motors_and_joints_of_the_trees_that_move_are_theirs) {
  const std::string keys = R"(<keyframe><key name="on" ctrl=")";
  const auto two =
      partial(model_file(arm("a", "0 0.3 0.1") + tool + arm("b", "0 -0.05 0.02"), weightless,
                         "<actuator>" + motors("a") + motors("b") + "</actuator>" + keys + R"(1 3"/></keyframe>)"),
              "on");
  const auto one = engine_of(model_file(tool + arm("b", "0 -0.05 0.02"), weightless,
                                        "<actuator>" + motors("b") + "</actuator>" + keys + R"(3"/></keyframe>)"),
                             "on");
  two->let_move(0b101);
  const Kept begin(two->numbers());
  BOOST_REQUIRE(two->restore(begin.numbers()));
  for (int i = 0; i < 300; ++i) {
    BOOST_REQUIRE(two->step({}, {}, h, nullptr));
    BOOST_REQUIRE(one->step({}, {}, h, nullptr));
  }
  const EngineNumbers a = two->numbers(), b = one->numbers();
  BOOST_REQUIRE(a.position.size() == 7U);
  for (std::size_t i = 0; i < 5; ++i) BOOST_TEST(std::abs(a.position[i + 2] - b.position[i]) < 1e-12);
  BOOST_TEST(std::abs(b.position[4]) > 1e-3);
  BOOST_TEST(a.activation[0] == 0.0);
  BOOST_TEST(std::abs(a.activation[1] - b.activation[0]) < 1e-12);
}

BOOST_AUTO_TEST_CASE(trees_that_are_joined_move_together_and_those_of_tendons_always) {
  const auto with = [](const std::string& tail) {
    const auto engine = partial(model_file(arm("a", "0 0.3 0.1") + tool + arm("b", "0 -0.3 0.1"), weightless, tail));
    engine->let_move(1);
    const Kept begin(engine->numbers());
    BOOST_REQUIRE(engine->restore(begin.numbers()));
    BOOST_REQUIRE(engine->step({}, {}, h, nullptr));
    const int with_tool = engine->moving_bodies();
    engine->let_move(0b11);
    BOOST_REQUIRE(engine->restore(begin.numbers()));
    BOOST_REQUIRE(engine->step({}, {}, h, nullptr));
    return std::pair(with_tool, engine->moving_bodies());
  };
  BOOST_TEST((with("") == std::pair(1, 2)));
  BOOST_TEST((with(R"(<equality><joint joint1="a_1" joint2="b_1"/></equality>)") == std::pair(1, 3)));
  BOOST_TEST((with(R"(<contact><exclude body1="a" body2="b"/></contact>)") == std::pair(1, 3)));
  BOOST_TEST((with(R"(<contact><exclude body1="tool" body2="b"/></contact>)") == std::pair(2, 3)));
  BOOST_TEST(
      (with(R"(<tendon><spatial><site site="a_site"/><site site="b_site"/></spatial></tendon>)") == std::pair(3, 3)));
}

BOOST_AUTO_TEST_CASE(the_trees_that_move_are_those_in_reach_the_nearest_first_within_the_budget) {
  // Each in touch with the one before, but for the last.
  const auto engine = partial(model_file(plane + tool + box("a", "0.035 0 0.02") + box("c", "0.115 0 0.02") +
                                             box("b", "0.075 0 0.02") + box("d", "0.5 0 0.02"),
                                         head));
  TreeSearch search{.horizon = 0.02, .handle_speed = 0.1, .stretch = 0.001, .step_budget = 1};
  BOOST_TEST((chosen(*engine, search) == 0b01111U));
  search.step_budget = 0;
  BOOST_TEST((chosen(*engine, search) == 1U));
  // One body less at a time, from the far end.
  for (const Trees trees : {Trees{0b00011}, Trees{0b01011}, Trees{0b01111}}) {
    search.step_budget = engine->step_cost(trees);
    BOOST_TEST((chosen(*engine, search) == trees), search.step_budget);
  }
  BOOST_TEST(engine->step_cost(0b00011) < engine->step_cost(0b01011));
  search = {.horizon = 0.02, .handle_speed = 30, .stretch = 0, .step_budget = 1};
  BOOST_TEST((chosen(*engine, search) == 0b11111U));
}

BOOST_AUTO_TEST_CASE(a_heap_of_sixty_moves_in_parts_and_allocates_nothing,
                     *boost::unit_test::precondition(heap_is_counted)) {
  std::string world = plane + tool;
  for (int i = 0; i < 60; ++i) {
    world += "<body pos=\"" + std::to_string(0.025 * (i % 4 - 1.5)) + ' ' + std::to_string(0.025 * (i / 4 % 4 - 1.5)) +
             ' ' + std::to_string(0.0125 + 0.024 * (i / 16)) +
             R"("><freejoint/><geom type="sphere" size="0.012"/></body>)";
  }
  const auto file = model_file(world, head);
  BOOST_TEST(engine_of(file)->allocates(all_trees) != "");
  const auto engine = partial(file);
  BOOST_TEST(engine->allocates(1) == "");
  BOOST_TEST(engine->may_allocate(all_trees));
  const Kept begin(engine->numbers());
  const Trees many = chosen(*engine, {.horizon = 1, .handle_speed = 1, .stretch = 0, .step_budget = 1});
  BOOST_TEST(!engine->may_allocate(many));
  const auto round = [&] {
    bool good = true;
    for (const Trees trees : {many, Trees{1}, Trees{0b110101}}) {
      engine->let_move(trees);
      good = good && engine->restore(begin.numbers());
      for (int i = 0; i < 20; ++i) good = good && engine->step(stiff, pressing(i), h, nullptr);
    }
    return good;
  };
  BOOST_REQUIRE_MESSAGE(round(), engine->failure());
  const std::int64_t before = thread_heap_calls();
  const bool good = round();
  BOOST_TEST(thread_heap_calls() == before);
  BOOST_TEST(good, engine->failure());
}

BOOST_AUTO_TEST_SUITE_END()
