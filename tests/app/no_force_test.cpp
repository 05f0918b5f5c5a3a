// Which device got no force in a run, and why: a table of what can stand in the way, under both clocks.
#include "app/run/no_force.hpp"

#include <boost/test/unit_test.hpp>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "app/report/run_report.hpp"
#include "app/run/headline.hpp"
#include "app/run/run.hpp"
#include "app/run/summary.hpp"
#include "framework/core/refusals.hpp"
#include "framework/core/segment.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/engine/plan_nodes.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/plugin.hpp"
#include "framework/node/registry.hpp"
#include "framework/realtime/declare_device.hpp"

BOOST_AUTO_TEST_SUITE(no_force_test)

using namespace tactor;

namespace {

constexpr Duration second{1'000'000'000};

/// A device that is as its parameters say, from the first tick to the last.
class Arm final : public DeviceNode {
 public:
  struct Params : DeviceParams {
    enum class Is : std::uint8_t { well, silent, unread, unwritten, fast, held_at_first };
    Is is = Is::well;
    std::int32_t buttons = 1;
  };
  Arm(const Params& params, const NodeContext& context) : DeviceNode(params, context, params.buttons), is_(params.is) {}
  static NodeInfo declare() {
    Declare<Arm> node("test.arm", "A device with something in its way.");
    DeviceParams defaults;
    defaults.dead_man_button = 0;
    declare_device(node, defaults);
    node.choice("is", &Params::is,
                {{"well", Params::Is::well},
                 {"silent", Params::Is::silent},
                 {"unread", Params::Is::unread},
                 {"unwritten", Params::Is::unwritten},
                 {"fast", Params::Is::fast},
                 {"held_at_first", Params::Is::held_at_first}},
                std::optional(Params::Is::well), "how it is")
        .integer<std::int32_t>("buttons", &Params::buttons,
                               {.doc = "how many there are", .default_value = 1, .min = 0, .max = 31});
    return node.info();
  }

 protected:
  ReadResult read(Time now, DeviceSample& sample) noexcept override {
    if (is_ == Params::Is::silent) return ReadResult::not_yet;
    if (is_ == Params::Is::unread) return ReadResult::failed;
    sample.time = now;
    if (is_ == Params::Is::fast) sample.state.V_WD.v = {100, 0, 0};
    if (is_ == Params::Is::held_at_first && now < Time{} + Duration{second.ns / 10}) sample.state.buttons = 1;
    return ReadResult::sample;
  }
  bool write(Time, const Wrench&) noexcept override { return is_ != Params::Is::unwritten; }
  [[nodiscard]] const char* failure() const noexcept override { return "it was told to"; }

 private:
  Params::Is is_;
};

/// Sends forces at 1 kHz, right or wrong.
class Pusher final : public Node {
 public:
  struct Params {
    enum class Sends : std::uint8_t { push, nothing, zero, not_finite, of_old_samples, of_wrong_times, later };
    Sends sends = Sends::push;
    double rate = 1000;
  };
  Pusher(const Params& params, const NodeContext&) : sends_(params.sends) {}
  static NodeInfo declare() {
    using S = Params::Sends;
    return Declare<Pusher>("test.pusher", "Sends forces.")
        .output("segment", &Pusher::segment, "the force")
        .output("force", &Pusher::force, "the same as a wrench")
        .choice("sends", &Params::sends,
                {{"push", S::push},
                 {"nothing", S::nothing},
                 {"zero", S::zero},
                 {"not_finite", S::not_finite},
                 {"of_old_samples", S::of_old_samples},
                 {"of_wrong_times", S::of_wrong_times},
                 {"later", S::later}},
                std::optional(S::push), "what it sends")
        .rate("rate", &Params::rate, {.doc = "rate", .default_value = 1000})
        .info();
  }
  void step(StepContext& context) override {
    using S = Params::Sends;
    const Time now = context.now();
    Wrench push{{0, 0, 1}, {}};
    if (sends_ == S::nothing) return;
    if (sends_ == S::zero || (sends_ == S::later && now < Time{} + Duration{second.ns / 5})) push = {};
    if (sends_ == S::not_finite) push.force.x = std::numeric_limits<double>::quiet_NaN();
    const Duration ahead = sends_ == S::of_wrong_times ? Duration{100 * second.ns} : Duration{};
    const Duration behind = sends_ == S::of_old_samples ? Duration{5 * second.ns} : Duration{};
    segment.send(Time{} + (now - Time{} - behind), constant_segment(now + ahead, push));
    force.send(now, push);
  }
  Output<ForceSegment> segment;
  Output<Wrench> force;

 private:
  Params::Sends sends_;
};

/// Refuses everything for one reason, and would make segments of the rest.
class Critic final : public Node, public Refusing {
 public:
  struct Params {
    enum class Why : std::uint8_t { none, too_many, not_finite, another_scene, incomplete, late, unsolved };
    Why why = Why::none;
  };
  Critic(const Params& params, const NodeContext&) : why_(params.why) {}
  static NodeInfo declare() {
    using W = Params::Why;
    return Declare<Critic>("test.critic", "Refuses.")
        .input("force", &Critic::force, {.doc = "what comes", .trigger = Trigger::yes})
        .output("segment", &Critic::segment, "what goes")
        .choice("why", &Params::why,
                {{"none", W::none},
                 {"too_many", W::too_many},
                 {"not_finite", W::not_finite},
                 {"another_scene", W::another_scene},
                 {"incomplete", W::incomplete},
                 {"late", W::late},
                 {"unsolved", W::unsolved}},
                std::optional(W::none), "why it refuses")
        .info();
  }
  void step(StepContext& context) override {
    using W = Params::Why;
    switch (why_) {
      case W::none:
        refused_.count(RefusalReason::none);
        return segment.send(force.latest()->stamp.valid, constant_segment(context.now(), force.latest()->value));
      case W::too_many:
        return refused_.count_too_many(60, 48);
      case W::not_finite:
        return refused_.count(RefusalReason::not_finite);
      case W::another_scene:
        return refused_.count(RefusalReason::another_scene);
      case W::incomplete:
        return refused_.count(RefusalReason::incomplete);
      case W::late:
        return refused_.count(RefusalReason::late);
      case W::unsolved:
        return refused_.count(RefusalReason::unsolved);
    }
  }
  [[nodiscard]] const Refusals& refusals() const override { return refused_; }
  Input<Wrench> force;
  Output<ForceSegment> segment;

 private:
  Params::Why why_;
  Refusals refused_{"results", "contacts"};
};

Registry& registry() {
  static Registry all(std::vector<std::filesystem::path>{});
  static const bool added = [] {
    all.add<Arm>();
    all.add<Pusher>();
    all.add<Critic>();
    return true;
  }();
  static_cast<void>(added);
  return all;
}

GraphSpec graph_of(const std::string& clock, const std::string& nodes, const std::string& edges,
                   const std::string& record = "device.commanded") {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "graph.yaml";
  std::ofstream(file)
      << "format: 2\nclock: " << clock
      << "\nlive: {on_missing_privilege: warn, on_stall: recover}\nduration: 0.4 s\nrate: 1 kHz\nrecord: [" << record
      << "]\n"
      << "scene: {bodies: {tool: {sphere: {radius: 1 mm}, motion: translation, mass: 50 g, pose: {p: "
         "[0, 0, 0]}, material: {stiffness: 1 N/mm, damping: 1 N s/m, friction: 0}}}}\n"
      << "nodes:\n"
      << nodes << edges;
  return load_graph(file, registry());
}

std::vector<std::string> clocks() {
  std::vector<std::string> all{"virtual"};
  if (has_plugin("libtactor_live.so")) all.emplace_back("real");
  return all;
}

const std::string pushed = "edges: [pusher.segment -> device.segment]\n";
const std::string critical = "edges: [pusher.force -> critic.force, critic.segment -> device.segment]\n";

/// What stands in the way of a device, and what the verdict says of it; N stands for a count.
struct Member {
  std::string device, pusher, critic;
  std::optional<NoForceReason> reason;
  std::string text;
};

const std::vector<Member>& members() {
  using R = NoForceReason;
  static const std::vector<Member> all{
      {"", "", "", std::nullopt, ""},
      {"", "", "why: none", std::nullopt, ""},
      {"dead_man_button: 1", "", "", R::dead_man, "button 1 was never held"},
      {"dead_man_button: 3, buttons: 4", "sends: zero", "", R::dead_man, "button 3 was never held"},
      {"is: held_at_first, dead_man_button: 1", "sends: later", "", R::dead_man,
       "button 1 was not held at N of N ticks that asked for one"},
      {"is: silent", "", "", R::device_not_ready, "the device showed no position in N ticks"},
      {"is: silent, dead_man_button: 1", "", "", R::device_not_ready, "the device showed no position in N ticks"},
      {"is: unread, failure_timeout: 60 s", "", "", R::read_failed, "the device could not be read at N of N ticks"},
      {"is: unread, failure_timeout: 0.1 s", "", "", R::read_failed, "the device could not be read at N of N ticks"},
      {"is: unwritten, failure_timeout: 60 s", "", "", R::write_failed, "the device took no wrench at N of N ticks"},
      {"is: fast", "", "", R::overspeed,
       "the handle was too fast, or had been just before at N of N ticks that asked for one"},
      {"force_max: 0", "", "", R::no_room, "the largest force is 0 N at N of N ticks that asked for one"},
      {"", "sends: nothing", "", R::no_result, "no result came: node pusher sent nothing in N steps"},
      {"", "sends: zero", "", R::not_asked, "none was asked for in N ticks"},
      {"", "sends: not_finite", "", R::not_finite, "the force was not finite at N of N ticks that asked for one"},
      {"", "sends: of_old_samples", "", R::segments_not_fresh,
       "N of N forces not fresh: made from a sample older than sample_age_max, or sent more than stale_after ago"},
      {"", "sends: of_wrong_times", "", R::segments_refused, "N of N forces refused: their times cannot be"},
      {"", "sends: nothing", "why: none", R::no_result, "no result came: node pusher sent nothing in N steps"},
      {"", "", "why: too_many", R::results_refused,
       "N of N results refused: 60 contacts in an array of 48 (node critic)"},
      {"", "", "why: not_finite", R::results_refused, "N of N results refused: not finite (node critic)"},
      {"", "", "why: another_scene", R::results_refused, "N of N results refused: of another scene (node critic)"},
      {"", "", "why: incomplete", R::results_refused, "N of N results refused: not complete (node critic)"},
      {"", "", "why: late", R::results_refused, "N of N results refused: no newer than one before (node critic)"},
      {"", "", "why: unsolved", R::results_refused, "N of N results refused: its step did not converge (node critic)"},
      {"dead_man_button: 1", "", "why: too_many", R::dead_man, "button 1 was never held"},
  };
  return all;
}

/// The text with N in place of its counts.
std::string without_counts(std::string text, const NoForce& found) {
  for (const std::uint64_t count : {found.of, found.count}) {
    const std::string number = " " + std::to_string(count) + " ";
    text = " " + text;
    for (std::size_t at = text.find(number); at != std::string::npos; at = text.find(number)) {
      text.replace(at, number.size(), " N ");
    }
    text.erase(0, 1);
  }
  return text;
}

RunResult run(const Member& member, const std::string& clock) {
  const auto node = [](const std::string& name, const std::string& type, const std::string& params) {
    return "  " + name + ": {type: test." + type + (params.empty() ? "" : ", " + params) + "}\n";
  };
  const bool has_critic = !member.critic.empty();
  const Plan plan = make_plan(graph_of(clock,
                                       node("device", "arm", member.device) + node("pusher", "pusher", member.pusher) +
                                           (has_critic ? node("critic", "critic", member.critic) : ""),
                                       has_critic ? critical : pushed));
  return execute(plan, {});
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_verdict_tells_what_kept_every_force_from_a_device) {
  for (const std::string& clock : clocks()) {
    for (const Member& member : members()) {
      BOOST_TEST_CONTEXT(clock << ": " << member.device << " / " << member.pusher << " / " << member.critic) {
        const RunResult result = run(member, clock);
        BOOST_REQUIRE(result.devices == 1U);
        BOOST_REQUIRE(result.no_force.size() == (member.reason ? 1U : 0U));
        const auto json = to_json(result);
        const std::string verdict = headline(result).front().text;
        if (!member.reason) {
          BOOST_TEST(verdict.find("no force") == std::string::npos);
          BOOST_TEST(!json.contains("no_force"));
          continue;
        }
        const NoForce& found = result.no_force.front();
        BOOST_TEST(name_of(found.reason) == name_of(*member.reason));
        BOOST_TEST(without_counts(found.text, found) == member.text);
        BOOST_TEST(found.count > 0U);
        BOOST_TEST(found.count <= found.of);
        BOOST_TEST(verdict.find("no force: " + found.text) != std::string::npos);
        BOOST_TEST(json["no_force"][0]["reason"].get<std::string>() == name_of(found.reason));
        BOOST_TEST(json["no_force"][0]["text"].get<std::string>() == found.text);
        BOOST_TEST(run_report(result).find(found.text.substr(0, 20)) != std::string::npos);
        BOOST_TEST(result.force_was_withheld() == (found.reason != NoForceReason::not_asked));
      }
    }
  }
}

// Counted by hand: a tick a millisecond from 0 to 399 ms, and a step of the pusher at each.
BOOST_AUTO_TEST_CASE(the_counts_of_a_verdict_are_those_of_ticks_and_messages) {
  const auto only = [](const Member& member) { return run(member, "virtual").no_force.at(0); };
  const NoForce never = only({"dead_man_button: 1", "", "", {}, {}});
  BOOST_TEST(never.count == 400U);
  const NoForce refused = only({"", "", "why: too_many", {}, {}});
  BOOST_TEST(refused.count == 400U);
  BOOST_TEST(refused.of == 400U);
  // Asked for from 200 ms on; the button was let go at 100 ms.
  const NoForce released = only({"is: held_at_first, dead_man_button: 1", "sends: later", "", {}, {}});
  BOOST_TEST(released.of == 200U);
  BOOST_TEST(released.count == 200U);
}

BOOST_AUTO_TEST_CASE(of_several_devices_each_is_named_and_one_that_got_a_force_keeps_the_verdict) {
  const Plan plan = make_plan(graph_of("virtual",
                                       "  device: {type: test.arm}\n  left: {type: test.arm, dead_man_button: 1}\n"
                                       "  pusher: {type: test.pusher}\n",
                                       "edges: [pusher.segment -> device.segment, pusher.segment -> left.segment]\n",
                                       "device.commanded, left.commanded"));
  RunResult result = execute(plan, {});
  BOOST_TEST(result.devices == 2U);
  BOOST_REQUIRE(result.no_force.size() == 1U);
  BOOST_TEST(!result.force_was_withheld());
  BOOST_TEST(no_force_text(result) == "no force on left: button 1 was never held");
  result.no_force.push_back(result.no_force.front());
  BOOST_TEST(result.force_was_withheld());
}

BOOST_AUTO_TEST_CASE(a_blind_run_tells_what_stood_in_the_way_and_not_that_nothing_was_asked_for) {
  RunResult result = run({"", "sends: zero", "", {}, {}}, "virtual");
  result.blind = true;
  BOOST_TEST(no_force_text(result).empty());
  result = run({"dead_man_button: 1", "", "", {}, {}}, "virtual");
  result.blind = true;
  BOOST_TEST(no_force_text(result) == "no force: button 1 was never held");
}

BOOST_AUTO_TEST_CASE(a_dead_man_button_that_the_device_lacks_is_refused_at_its_place) {
  for (const auto& [buttons, button, expected] :
       {std::tuple{0, 1, "expected 0, because the device has no buttons, found 1"},
        {1, 2, "expected a button of the device, 1 to 1, or 0 for none, found 2"},
        {4, 31, "expected a button of the device, 1 to 4, or 0 for none, found 31"},
        {4, 4, ""},
        {0, 0, ""},
        {31, 31, ""}}) {
    const Plan plan =
        make_plan(graph_of("virtual",
                           "  device: {type: test.arm, buttons: " + std::to_string(buttons) +
                               ", dead_man_button: " + std::to_string(button) + "}\n  pusher: {type: test.pusher}\n",
                           pushed));
    std::string said;
    try {
      check_nodes(plan);
    } catch (const InputError& error) {
      said = error.what();
    }
    BOOST_TEST(said.empty() == std::string(expected).empty());
    BOOST_TEST(said.find(expected) != std::string::npos);
    if (!said.empty()) BOOST_TEST(said.find("graph.yaml:9:") != std::string::npos);
  }
}

BOOST_AUTO_TEST_SUITE_END()
