// The events of a run, as a log for programs has them, from states that are made up.
#include "app/run/event_log.hpp"

#include <boost/test/unit_test.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "framework/core/temporary_folder.hpp"
#include "framework/node/declare.hpp"

BOOST_AUTO_TEST_SUITE(event_log_test)

using namespace tactor;
using Lines = std::vector<nlohmann::json>;

namespace {

class Actor final : public Node {
 public:
  struct Params {};
  Actor(const Params&, const NodeContext&) {}
  void step(StepContext&) override {}
};

struct Fixture {
  TemporaryFolder folder;
  NodeInfo info = Declare<Actor>("test.actor", "Does nothing.").actuator().sink().info();
  Plan plan;
  LiveLook look;

  Fixture() {
    plan.graph.name = "duck";
    plan.graph.clock = Clock::real;
    plan.graph.duration = until_stopped;
    plan.nodes.push_back({"handle", &info, {}, {}, {}, {}});
    plan.nodes.push_back({"physics", &info, {}, {}, {}, {}});
    PlannedEdge edge;
    edge.spec.from_node = "handle";
    edge.spec.from_port = "state";
    edge.spec.to_node = "physics";
    edge.spec.to_port = "device";
    plan.edges.push_back(edge);
    look.status.nodes.resize(2);
    look.status.edges.resize(1);
    look.status.devices.resize(1);
    look.safety.resize(1);
  }
  [[nodiscard]] std::filesystem::path file() const { return folder.path() / "log.json"; }
  [[nodiscard]] Lines lines() const {
    Lines found;
    std::ifstream in(file());
    for (std::string line; std::getline(in, line);) found.push_back(nlohmann::json::parse(line));
    return found;
  }
};

std::string of(const Lines& lines, std::size_t i) {
  const nlohmann::json& line = lines.at(i);
  return line["level"].get<std::string>() + " " + line["kind"].get<std::string>() + " " + line["node"].dump();
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_line_is_json_with_the_time_of_day_and_of_the_run) {
  const RunEvent event{LogLevel::warning, EventKind::gate, "handle", Time{1'250'000'000}, "a \"text\"\nof \xff bytes"};
  const nlohmann::json line = nlohmann::json::parse(to_json_line(event, 1'700'000'000'042));
  BOOST_TEST(line["time"] == "2023-11-14T22:13:20.042Z");
  BOOST_TEST(line["run_s"] == 1.25);
  BOOST_TEST(line["level"] == "warning");
  BOOST_TEST(line["kind"] == "gate");
  BOOST_TEST(line["node"] == "handle");
  BOOST_TEST(line["message"] == "a \"text\"\nof \xef\xbf\xbd bytes");
  BOOST_TEST(nlohmann::json::parse(to_json_line({}, 0))["run_s"].is_null());
}

BOOST_FIXTURE_TEST_CASE(only_what_changes_is_told_with_its_node, Fixture) {
  {
    EventLog log(file());
    LiveEvents events(plan, log);
    look.status.missing = {"SCHED_FIFO is refused"};
    events.look(look);
    events.look(look);
    look.status.phase = Phase::running;
    look.safety[0] = SafetyState{Engagement::ramping, SafetyCause::none, 0.3, {}};
    events.look(look);
    look.safety[0] = SafetyState{Engagement::engaged, SafetyCause::none, 1, {}};
    events.look(look);
    look.safety[0] = SafetyState{Engagement::fault, SafetyCause::read_failed, 0, {}};
    events.look(look);
    look.status.nodes[1].stalled = true;
    events.look(look);
    events.look(look);
  }
  const Lines found = lines();
  BOOST_TEST_REQUIRE(found.size() == 6U);
  BOOST_TEST(of(found, 0) == "info started null");
  BOOST_TEST(found[0]["message"] == "duck has started, duration until stopped");
  BOOST_TEST(of(found, 1) == "warning privilege null");
  BOOST_TEST(of(found, 2) == "info running null");
  BOOST_TEST(of(found, 3) == "info gate \"handle\"");
  BOOST_TEST(of(found, 4) == "error gate \"handle\"");
  BOOST_TEST(found[4]["message"] == "the gate of handle is fault: read_failed");
  BOOST_TEST(of(found, 5) == "warning stalled \"physics\"");
}

BOOST_FIXTURE_TEST_CASE(counts_are_told_once_a_minute, Fixture) {
  {
    EventLog log(file());
    LiveEvents events(plan, log);
    for (int s = 0; s < 150; ++s) {
      look.status.now = Time::from_seconds(s);
      look.status.devices[0].missed = static_cast<std::uint64_t>(s);
      look.status.edges[0].metrics.dropped = static_cast<std::uint64_t>(2 * s);
      events.look(look);
    }
  }
  const Lines found = lines();
  // The start, and both counts at 1 s, 61 s and 121 s.
  BOOST_TEST_REQUIRE(found.size() == 7U);
  BOOST_TEST(of(found, 1) == "warning missed_ticks \"handle\"");
  BOOST_TEST(of(found, 2) == "warning dropped \"physics\"");
  BOOST_TEST(found[3]["message"] == "node handle has missed 60 ticks more, 61 in all");
  BOOST_TEST(found[6]["message"] ==
             "the edge handle.state -> physics.device has dropped 120 messages more, 242 in all");
}

BOOST_FIXTURE_TEST_CASE(a_failure_is_told_with_the_node_that_failed, Fixture) {
  RunResult result;
  result.failure = "node physics failed";
  result.live = look.status;
  BOOST_TEST(last_event(plan, result).node.empty());
  result.live->nodes[1].failed = true;
  const RunEvent failed = last_event(plan, result);
  BOOST_TEST((failed.kind == EventKind::failed));
  BOOST_TEST((failed.level == LogLevel::error));
  BOOST_TEST(failed.node == "physics");
  BOOST_TEST(failed.message == "node physics failed");
  result.failure.reset();
  BOOST_TEST((last_event(plan, result).kind == EventKind::ended));
}

BOOST_AUTO_TEST_CASE(a_log_that_cannot_be_opened_is_refused) {
  BOOST_CHECK_THROW(EventLog(std::filesystem::path("/nowhere/at/all/log.json")), InputError);
}

BOOST_AUTO_TEST_SUITE_END()
