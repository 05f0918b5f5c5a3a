// Hardware without a button that stops its force runs only where somebody agrees, and says at once what the system
// refuses.
#include "framework/engine/live/dead_man.hpp"

#include <boost/test/unit_test.hpp>

#include "framework/engine/live/lane_plan.hpp"
#include "framework/engine/live/live_engine.hpp"
#include "framework/realtime/declare_device.hpp"
#include "tests/framework/engine/live/live_nodes.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(dead_man_test)

using namespace tactor;
using namespace tactor::sample;

namespace {

/// A device that a person may wear, with so many buttons; below zero: nobody knows.
class Worn final : public DeviceNode {
 public:
  struct Params : DeviceParams {
    std::int32_t buttons = 0;
  };
  Worn(const Params& params, const NodeContext& context)
      : DeviceNode(params, context, params.buttons < 0 ? std::nullopt : std::optional<int>(params.buttons)) {}
  static NodeInfo declare() {
    Declare<Worn> node("sample.worn", "A device of hardware.");
    declare_device(node);
    return node.hardware()
        .integer<std::int32_t>("buttons", &Params::buttons, {.doc = "how many", .default_value = 0, .min = -1})
        .info();
  }

 protected:
  ReadResult read(Time, DeviceSample&) noexcept override { return ReadResult::not_yet; }
  bool write(Time, const Wrench&) noexcept override { return true; }
  [[nodiscard]] const char* failure() const noexcept override { return ""; }
};

struct Fixture {
  NodeInfo worn = Worn::declare();
  NodeInfo simulated = [this] {
    NodeInfo info = worn;
    info.hardware.reset();
    return info;
  }();
  PlanBuilder b{1.0};
  int asked = 0;
  std::string question;

  void device(const NodeInfo& info, std::int64_t buttons, std::map<std::string, ParamValue> given = {}) {
    given["buttons"] = buttons;
    const std::string name = "device_" + std::to_string(b.plan.nodes.size());
    b.node(name, info, test::param_values(info, given), {Lane::realtime, "", {}, {}, {}});
    b.plan.nodes.back().place = {"graph.yaml", 9 + static_cast<int>(b.plan.nodes.size()), 3};
  }
  /// What refuses the plan, empty where nothing does.
  std::string refused(const std::optional<bool>& answer) {
    EngineOptions options;
    if (answer) {
      options.without_dead_man = [&](const std::string& text) {
        ++asked;
        question = text;
        return *answer;
      };
    }
    try {
      LiveEngine engine(b.plan, options);
    } catch (const InputError& error) {
      return error.what();
    }
    return {};
  }
};

const std::map<std::string, ParamValue> does_without{{"dead_man_button", std::int64_t{0}}};

}  // namespace

BOOST_FIXTURE_TEST_CASE(the_first_button_of_hardware_has_to_be_held_by_default, Fixture) {
  device(worn, 1);
  BOOST_TEST(refused(std::nullopt) == "");
  PlanNodes nodes(b.plan);
  BOOST_TEST(dynamic_cast<const DeviceNode&>(nodes[0]).account().dead_man_button == 1);
  check_dead_man(nodes, {});
  BOOST_TEST_REQUIRE(nodes.notes().size() == 1U);
  BOOST_TEST(nodes.notes()[0] == "hold button 1 of device_0 (sample.worn) to get a force");
}

BOOST_FIXTURE_TEST_CASE(hardware_without_a_button_is_refused_at_its_place, Fixture) {
  for (const std::int64_t buttons : {0, -1}) {
    b.plan.nodes.clear();
    device(worn, buttons);
    const std::string text = refused(std::nullopt);
    BOOST_TEST(text.starts_with("graph.yaml:10:3: nodes.device_0: expected a dead-man button"), text);
    BOOST_TEST(text.find("--no-dead-man") != std::string::npos, text);
    BOOST_TEST(text.find("dead_man_button: 0") != std::string::npos, text);
  }
}

BOOST_FIXTURE_TEST_CASE(one_question_names_all_devices_and_a_no_refuses, Fixture) {
  device(worn, 0);
  device(worn, 1);
  device(worn, -1);
  const std::string text = refused(false);
  BOOST_TEST(text.find("graph.yaml:10:3: nodes.device_0") != std::string::npos, text);
  BOOST_TEST(text.find("nodes.device_1") == std::string::npos, text);
  BOOST_TEST(text.find("graph.yaml:12:3: nodes.device_2") != std::string::npos, text);
  BOOST_TEST(asked == 1);
  BOOST_TEST(refused(true) == "");
  BOOST_TEST(asked == 2);
  BOOST_TEST(question ==
             "No button stops the force of device_0 (sample.worn) and device_2 (sample.worn) when you let go. Run all "
             "the same?");
}

BOOST_FIXTURE_TEST_CASE(a_graph_that_does_without_a_button_and_a_device_that_is_no_hardware_ask_nothing, Fixture) {
  device(worn, 0, does_without);
  device(worn, 4, does_without);
  device(simulated, 0);
  BOOST_TEST(refused(false) == "");
  BOOST_TEST(asked == 0);
  PlanNodes nodes(b.plan);
  check_dead_man(nodes, {});
  BOOST_TEST_REQUIRE(nodes.notes().size() == 2U);
  BOOST_TEST(nodes.notes()[0] == "no button stops the force of device_0 (sample.worn), as its dead_man_button: 0 says");
}

BOOST_FIXTURE_TEST_CASE(what_the_system_refuses_is_one_line_where_hardware_is_driven, Fixture) {
  const ThreadSettings nowhere{SchedulingPolicy::other, 0, 1'000'000};
  device(simulated, 0);
  BOOST_TEST(check_privileges(b.plan, plan_lanes(b.plan), nowhere) == "");
  device(worn, 1);
  const std::string text = check_privileges(b.plan, plan_lanes(b.plan), nowhere);
  BOOST_TEST(text.starts_with("the system refuses real-time privileges ("), text);
  BOOST_TEST(text.find("core 1000000") != std::string::npos, text);
  BOOST_TEST(text.find("docs/howto/real_time.md") != std::string::npos, text);
  BOOST_TEST(text.find('\n') == std::string::npos, text);
}

BOOST_AUTO_TEST_SUITE_END()
