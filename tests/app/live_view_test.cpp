// What the terminal shows of a live run, from states that are made up.
#include "app/run/live_view.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <sstream>

#include "framework/node/declare.hpp"

BOOST_AUTO_TEST_SUITE(live_view_test)

using namespace tactor;

namespace {

class Idle final : public Node {
 public:
  struct Params {};
  Idle(const Params&, const NodeContext&) {}
  void step(StepContext&) override {}
};

struct Fixture {
  NodeInfo info = Declare<Idle>("test.idle", "Does nothing.").info();
  Plan plan;
  EngineStatus before, now;
  std::optional<SafetyState> safety = SafetyState{Engagement::ramping, SafetyCause::stale, 0.37, {}};
  std::uint64_t record_dropped = 0;
  std::optional<FollowerFigures> follower;

  Fixture() {
    plan.graph.name = "duck";
    plan.graph.duration = Duration{10'000'000'000};
    plan.nodes.push_back({"handle", &info, {}, {}, {Lane::realtime, "", {}, {}, {}}, {}});
    plan.nodes.push_back({"collision", &info, {}, {}, {Lane::thread, "physics", {}, {}, {}}, {}});
    PlannedEdge edge;
    edge.spec.from_node = "handle";
    edge.spec.from_port = "state";
    edge.spec.to_node = "collision";
    edge.spec.to_port = "device";
    plan.edges.push_back(edge);

    before.now = Time{1'000'000'000};
    before.nodes = {{1000, 0, false}, {100, 0, false}};
    now.now = Time{1'500'000'000};
    now.phase = Phase::running;
    now.nodes = {{1499, 7, false}, {162, 3, true}};
    now.edges.push_back({{400, 29, 3}, {400, us(211), us(853), us(905), us(960), Duration{2'345'000'000}}});
    DeviceStatus device;
    device.node = 0;
    device.ticks = 1499;
    device.missed = 7;
    device.wake_latency = {1499, us(31), us(67), us(243), us(300), us(412)};
    device.body_time = {1499, us(3), us(5), us(6), us(7), us(8)};
    device.end_to_end = {1400, us(8600), us(19400), us(20000), us(20000), us(20000)};
    device.heap_calls = 17;
    device.page_faults = 23;
    now.devices.push_back(device);
  }
  static Duration us(std::int64_t n) { return Duration{n * 1000}; }
  [[nodiscard]] std::string block() const {
    return live_block(plan, before, {now, std::vector(now.devices.size(), safety), record_dropped, follower});
  }
  /// The row that has `word`.
  [[nodiscard]] std::string row(const std::string& word) const {
    std::istringstream in(block());
    for (std::string line; std::getline(in, line);) {
      if (line.find(word) != std::string::npos) return line;
    }
    return {};
  }
  void has(const std::string& word, std::initializer_list<const char*> texts) const {
    for (const char* text : texts)
      BOOST_TEST(row(word).find(text) != std::string::npos, row(word) << " lacks " << text);
  }
};

std::size_t widest(const std::string& block) {
  std::size_t most = 0;
  std::istringstream in(block);
  for (std::string line; std::getline(in, line);) most = std::max(most, line.size());
  return most;
}

}  // namespace

BOOST_FIXTURE_TEST_CASE(the_block_tells_time_rates_ages_drops_latencies_and_safety, Fixture) {
  has("duck", {"1.5 of 10 s", "running"});
  has("handle  ", {"ramping (stale) 37 %"});
  has("ticks", {"1499", "missed 7", "allocations 17", "page faults 23"});
  has("wake-up", {"p50 31 ", "p99 67 ", "p99.9 243 ", "max 412 us", "body p99 5.0 us"});
  has("sample to force", {"p50 8.6", "p99 19.4 ms"});
  has("realtime", {"handle", " 998 ", " 7"});
  has("thread physics", {"collision", " 124 ", " 3  stalled"});
  has("handle.state -> collision.device", {" 211 ", " 853 ", " 2.3 s ", " 29"});
}

BOOST_FIXTURE_TEST_CASE(a_run_that_starts_says_what_it_waits_for, Fixture) {
  now.phase = Phase::starting;
  now.waiting_for = {"collision", "dynamics"};
  has("duck", {"starting, waits for collision, dynamics"});
}

BOOST_FIXTURE_TEST_CASE(without_a_state_before_there_are_no_rates_and_nothing_breaks, Fixture) {
  before = {};
  now.now = Time{};
  safety.reset();
  now.devices[0].heap_calls.reset();
  has("thread physics", {" - "});
  has("ticks", {"allocations -"});
}

BOOST_FIXTURE_TEST_CASE(a_recording_that_lost_messages_is_told, Fixture) {
  BOOST_TEST(row("recording lost").empty());
  record_dropped = 31;
  has("recording lost", {"31"});
}

BOOST_FIXTURE_TEST_CASE(no_row_is_wider_than_a_hundred_columns_whatever_the_names_and_numbers, Fixture) {
  BOOST_TEST(widest(block()) <= 80U);
  const std::string longest(64, 'n');
  plan.graph.name = longest;
  plan.nodes[1].name = longest;
  plan.nodes[1].scheduling.thread = longest;
  plan.edges[0].spec.from_node = longest;
  plan.edges[0].spec.to_node = longest;
  now.phase = Phase::starting;
  now.waiting_for = std::vector<std::string>(5, longest);
  now.nodes[1] = {4'000'000'000, 4'000'000'000, true};
  now.edges[0].metrics.dropped = 4'000'000'000;
  DeviceStatus& d = now.devices[0];
  d.ticks = d.missed = d.page_faults = 4'000'000'000;
  d.wake_latency.max = d.body_time.p99 = d.end_to_end.p99 = Duration{86'400'000'000'000};
  BOOST_TEST(widest(block()) <= 100U);
}

BOOST_AUTO_TEST_CASE(a_block_is_cut_to_the_terminal_and_says_so) {
  const std::string block = "one\ntwo two\nthree\nfour\n";
  const std::vector<std::string> whole{"one", "two two", "three", "four"};
  const std::vector<std::string> narrow{"one", "two", "thr", "fou"};
  BOOST_TEST(fitted(block, 4, 80) == whole, boost::test_tools::per_element());
  BOOST_TEST(fitted(block, 9, 3) == narrow, boost::test_tools::per_element());
  const auto low = fitted(block, 3, 80);
  BOOST_REQUIRE(low.size() == 3U);
  BOOST_TEST(low[1] == "two two");
  BOOST_TEST(low[2].find("2 rows") != std::string::npos);
  BOOST_TEST(fitted(block, 1, 80).size() == 1U);
}

BOOST_FIXTURE_TEST_CASE(what_follows_it_is_told_with_what_it_skipped, Fixture) {
  BOOST_TEST(block().find("reference") == std::string::npos);
  follower.emplace();
  BOOST_TEST(block().find("nothing compared yet") != std::string::npos);
  follower->error = {4321, Time{4'000'000'000}, Duration{4'000'000'000}, 0.123, 0.456, 0.789, Duration{25'600'000}};
  follower->behind = Duration{70'000'000};
  const std::string told = block();
  for (const char* part :
       {"error 0.789 N RMS in the last second, 0.123 in all, 0.456 at most", "delay 25.6 ms", "0.07 s behind"}) {
    BOOST_TEST(told.find(part) != std::string::npos, told);
  }
  BOOST_TEST(told.find("skipped") == std::string::npos);
  follower->skips = 3;
  follower->skipped = Duration{2'500'000'000};
  follower->dropped = 17;
  follower->failure = "it broke";
  for (const char* part : {"skipped 2.5 s, 3 times", "lost 17 messages", "ended: it broke"}) {
    BOOST_TEST(block().find(part) != std::string::npos, block());
  }
}

BOOST_AUTO_TEST_CASE(a_blind_run_shows_nothing_that_a_method_makes) {
  Fixture f;
  f.follower.emplace();
  NodeInfo leads = f.info;
  leads.sets = [](const std::vector<ParamValue>&) { return std::vector<Setting>{}; };
  BOOST_TEST(f.block().find("sample to force") != std::string::npos);
  f.plan.nodes.push_back({"protocol", &leads, {}, {}, {Lane::thread, "experiment", {}, {}, {}}, {}});
  f.now.nodes.emplace_back();
  const std::string block = f.block();
  for (const char* told : {"sample to force", "body", "steps/s", "age p50", "collision", "reference"}) {
    BOOST_TEST(block.find(told) == std::string::npos, told << " in " << block);
  }
  // Whether the device is safe and in time is shown.
  f.has("handle", {"ramping", "37 %"});
  f.has("wake-up", {"31", "412"});
  f.has("ticks", {"1499", "missed 7"});
}

BOOST_AUTO_TEST_SUITE_END()
