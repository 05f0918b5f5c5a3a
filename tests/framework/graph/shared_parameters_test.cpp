// A parameter that is as in another node takes its value from there, unless the graph gives it.
#include <boost/test/unit_test.hpp>

#include "framework/core/messages.hpp"
#include "framework/node/declare.hpp"
#include "test_nodes.hpp"

BOOST_AUTO_TEST_SUITE(shared_parameters_test)

using namespace tactor;
using namespace tactor::testing;

namespace {

double margin(const std::string& surface, const std::string& collision, const Overrides& overrides = {}) {
  const Folder folder;
  const std::string nodes = "duration: 1 s\nnodes:\n  surface: {type: test.surface" + surface + "}\n" + collision;
  return std::get<double>(load_text(folder, nodes, overrides).node("surface")->params.at(0));
}

/// Has parameters of the names that the next one has, with other kinds, units, bounds and choices.
struct Giver final : Node {
  enum class Mode { slow, fast, best };
  struct Params {
    double reach = 0, span = 0;
    std::int32_t step = 0, count = 0;
    Mode mode = Mode::slow;
  };
  Giver(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    return Declare<Giver>("test.giver", "Gives values.")
        .role(Role::collision)
        .real("reach", &Params::reach, {.doc = "reach", .unit = "m", .default_value = 0.05, .min = 0, .max = 1})
        .real("span", &Params::span, {.doc = "a time", .unit = "s", .default_value = 0.7})
        .integer("step", &Params::step, {.doc = "a number of steps", .default_value = 7})
        .integer("count", &Params::count, {.doc = "a count", .default_value = 3, .max = 100})
        .choice("mode", &Params::mode, {{"slow", Mode::slow}, {"fast", Mode::fast}, {"best", Mode::best}},
                std::optional(Mode::fast), "how")
        .info();
  }
  void step(StepContext&) override {}
};

struct Taker final : Node {
  enum class Mode { slow, fast };
  struct Params {
    double reach = 0, span = 0, step = 0;
    std::int32_t count = 0;
    Mode mode = Mode::slow;
  };
  Taker(const Params&, const NodeContext&) {}
  static NodeInfo declare() {
    constexpr Role there = Role::collision;
    return Declare<Taker>("test.taker", "Takes values.")
        .real("reach", &Params::reach,
              {.doc = "reach",
               .unit = "m",
               .default_value = 0.01,
               .min = 0,
               .max = 0.1,
               .above_min = true,
               .as_in = there})
        .real("span", &Params::span, {.doc = "a length", .unit = "m", .default_value = 0.1, .as_in = there})
        .real("step", &Params::step, {.doc = "a number", .default_value = 0.2, .as_in = there})
        .integer("count", &Params::count, {.doc = "a count", .default_value = 1, .max = 10, .as_in = there})
        .choice<Mode>("mode", &Params::mode, {{"slow", Mode::slow}, {"fast", Mode::fast}}, Mode::slow, "how",
                      std::nullopt, there)
        .info();
  }
  void step(StepContext&) override {}
};

/// The parameters of a taker beside a giver.
std::vector<ParamValue> taken(const std::string& taker, const std::string& giver) {
  const Folder folder;
  Registry registry{{}};
  registry.add<Giver>();
  registry.add<Taker>();
  const auto file = folder.write("graph.yaml", "duration: 1 s\nnodes:\n  taker: {type: test.taker" + taker +
                                                   "}\n  giver:\n    type: test.giver\n" + giver);
  return load_graph(file, registry).node("taker")->params;
}

std::string refusal(const std::string& taker, const std::string& giver) {
  try {
    taken(taker, giver);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
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

BOOST_AUTO_TEST_CASE(a_parameter_of_the_name_but_of_another_kind_or_unit_is_not_shared) {
  const std::vector<ParamValue> params = taken("", "    span: 2 s\n    step: 9\n    reach: 20 mm\n    count: 4\n");
  BOOST_TEST((params == std::vector<ParamValue>{0.02, 0.1, 0.2, std::int64_t{4}, std::string("fast")}));
}

BOOST_AUTO_TEST_CASE(a_shared_value_that_is_not_allowed_here_is_refused_with_both_places) {
  const auto says = [](const std::string& text, const std::vector<std::string>& parts) {
    for (const std::string& part : parts) BOOST_TEST(text.find(part) != std::string::npos, text << " lacks " << part);
  };
  says(
      refusal("", "    reach: 500 mm\n"),
      {"graph.yaml:6:12: nodes.taker.reach, as in nodes.giver.reach where it is not given: expected a length (m) above "
       "0 and at most 0.1, found 0.5"});
  // The bound itself does not belong to it.
  says(refusal("", "    reach: 0 m\n"), {"nodes.taker.reach", "nodes.giver.reach", "found 0"});
  says(refusal("", "    count: 50\n"), {"graph.yaml:6:12: nodes.taker.count", "nodes.giver.count", "found 50"});
  says(refusal("", "    mode: best\n"),
       {"graph.yaml:6:11: nodes.taker.mode", "nodes.giver.mode", "slow, fast", "best"});
  // Its own value is allowed beside that.
  BOOST_TEST(refusal(", reach: 20 mm", "    reach: 500 mm\n") == "");
  // What cannot be read at all has one error.
  const std::string broken = refusal("", "    reach: 5 s\n");
  says(broken, {"nodes.giver.reach"});
  BOOST_TEST(broken.find("nodes.taker") == std::string::npos, broken);
}

BOOST_AUTO_TEST_SUITE_END()
