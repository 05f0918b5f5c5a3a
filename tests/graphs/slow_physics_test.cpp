// Physics that is slower than a device waits: a check says so and what to set, and then the force stays while physics
// lives.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <regex>
#include <string>
#include <tuple>
#include <vector>

#include "framework/core/messages.hpp"
#include "framework/core/temporary_folder.hpp"
#include "tests/support/page_text.hpp"
#include "tests/support/shipped_graphs.hpp"

BOOST_AUTO_TEST_SUITE(slow_physics_test)

using namespace tactor;
using namespace tactor::test;
namespace fs = std::filesystem;

namespace {

const std::string scene = "format: 2\nextends: " + (graphs / "transfer/base.yaml").string() + R"(
duration: 4 s
scene:
  gravity: [0, 0, 0]
  tool: tool
  bodies:
    wall:
      plane: {}
      material: {stiffness: 2 N/mm, damping: 2 N s/m, friction: 0.3}
    tool:
      sphere: {radius: 4 mm}
      motion: translation
      mass: 50 g
      pose: {p: [0, 0, 10 mm]}
      material: {stiffness: 2 N/mm, damping: 2 N s/m, friction: 0.3}
nodes:
  trajectory:
    points:
      - {t: 0 s, z: 10 mm}
      - {t: 0.5 s, z: 2 mm}
      - {t: 4 s, z: 1 mm}
  coupling: {k_t: 0.5 N/mm}
)";

const Over held, local{"methods/local.yaml"};

struct Fixture {
  TemporaryFolder folder;

  fs::path graph(const std::string& collision, const std::string& dynamics = "none", const std::string& more = "",
                 const std::string& extra = "") const {
    return write(folder.path() / "slow.yaml", scene + "  collision: {cost: " + collision +
                                                  "}\n  dynamics: {type: dynamics.translation, cost: " + dynamics +
                                                  "}\n" + more + extra);
  }

  /// A trace of costs, one a line, s.
  std::string trace(const std::string& times) const {
    return "{trace: " + write(folder.path() / "trace.txt", times).string() + "}";
  }
};

bool is_of_physics(const std::string& note) {
  return note.find("physics may take") != std::string::npos;
}

/// What a check says of the physics, or nothing.
std::string note(const fs::path& graph, const Over& over = {}) {
  std::vector<std::string> notes = check_nodes(planned(graph, over));
  std::erase_if(notes, [](const std::string& one) { return !is_of_physics(one); });
  BOOST_TEST(notes.size() <= 1U);
  return notes.empty() ? "" : notes.front();
}

/// `over`, and what the note says to set.
Over remedied(Over over, const std::string& note) {
  const std::string said = note.substr(std::min(note.find("; set "), note.size()));
  const std::regex remedy(R"((\S+) to ([\d.]+) (m?s))");
  for (std::sregex_iterator at(said.begin(), said.end(), remedy); at != std::sregex_iterator(); ++at) {
    over.push_back((*at)[1].str() + "=" + (*at)[2].str() + (*at)[3].str());
  }
  return over;
}

RunResult unjudged_run(const fs::path& graph, const Over& over, const std::vector<Listener>& listeners = {}) {
  return run(planned(graph, over), listeners, {.without_reference = true});
}

}  // namespace

BOOST_FIXTURE_TEST_CASE(check_names_the_device_the_time_and_what_to_set, Fixture) {
  const std::string said = note(graph("{constant: 125 ms}"));
  says_like(said, R"(transfer/base\.yaml:\d+:\d+: node device: )");
  says(said,
       "physics may take 125 ms by the cost of collision, and device.stale_after is 100 ms: the force ramps to zero "
       "between results; set device.stale_after to 260 ms");
  says_like(note(graph("{constant: 125 ms}", "none", "  device: {stale_after: 110 ms}\n")),
            R"(slow\.yaml:\d+:25: node device: .*device\.stale_after is 110 ms)");
}

BOOST_FIXTURE_TEST_CASE(what_the_note_says_to_set_is_enough, Fixture) {
  for (const std::string cost : {"125 ms", "330 ms", "600 ms", "1.4 s"}) {
    for (const Over& over : {held, local}) {
      BOOST_TEST_CONTEXT(cost << (over.empty() ? " held" : " local")) {
        const fs::path slow = graph("{constant: " + cost + "}");
        const std::string said = note(slow, over);
        const bool is_long = cost == "600 ms" || cost == "1.4 s";
        says(said, "device.stale_after");
        // Samples are half a second old at most by default, and a rollout trusts them for two results within its
        // second.
        BOOST_TEST((said.find("device.sample_age_max") != std::string::npos) == is_long);
        BOOST_TEST((said.find("rollout.trust_time_max") != std::string::npos) == (!over.empty() && is_long));
        BOOST_TEST(note(slow, remedied(over, said)) == "");
      }
    }
  }
}

BOOST_FIXTURE_TEST_CASE(what_nothing_can_be_set_for_is_said, Fixture) {
  const std::string said = note(graph("{constant: 20 s}"));
  BOOST_TEST(said.ends_with("between results, whatever they are set to; make physics faster"), said);
}

BOOST_FIXTURE_TEST_CASE(the_largest_time_is_the_one_that_the_cost_allows, Fixture) {
  const std::vector<std::tuple<std::string, std::string, std::string>> costs{
      {"{constant: 90 ms}", "none", ""},
      {"{constant: 97 ms}", "none", ""},
      {"{constant: 98.5 ms}", "none", "98.5 ms by the cost of collision"},  // a result is shown a tick or two later
      {"{constant: 90 ms, jitter: 10 %}", "none", "117 ms by the cost of collision"},  // three standard deviations
      {"{constant: 90 ms, jitter: 10 %, max: 95 ms}", "none", ""},
      {"{constant: 10 ms, min: 150 ms}", "none", "150 ms by the cost of collision"},
      {"{base: 6 ms, per_contact: 1 ms, max: 150 ms}", "none", "150 ms by the cost of collision"},
      {"{base: 6 ms, per_contact: 10 ms}", "none", ""},  // nobody knows how many contacts
      {"{base: 120 ms, per_contact: 10 ms}", "none", "120 ms by the cost of collision"},
      {trace("0.01\n0.12\n0.02\n"), "none", "120 ms by the cost of collision"},
      {"none", "{constant: 120 ms}", "120 ms by the cost of dynamics"},
      {"{constant: 60 ms}", "{constant: 60 ms}", "120 ms by the cost of "}};
  for (const auto& [collision, dynamics, expected] : costs) {
    BOOST_TEST_CONTEXT(collision << ", " << dynamics) {
      const std::string said = note(graph(collision, dynamics));
      BOOST_TEST(said.empty() == expected.empty(), said);
      says(said, expected);
    }
  }
}

BOOST_FIXTURE_TEST_CASE(a_force_that_needs_no_physics_gets_no_note, Fixture) {
  BOOST_TEST(note(graph("{constant: 125 ms}"), {"methods/rbf.yaml"}) == "");
}

BOOST_FIXTURE_TEST_CASE(the_force_stays_while_slow_physics_lives, Fixture) {
  const fs::path slow = graph("{constant: 125 ms, jitter: 5 %}");
  for (const Over& over : {held, local}) {
    BOOST_TEST_CONTEXT((over.empty() ? "held" : "local")) {
      BOOST_TEST(unjudged_run(slow, over).metric("device.stale") > 10);
      const RunResult kept_on = unjudged_run(slow, remedied(over, note(slow, over)));
      BOOST_TEST(kept_on.metric("device.stale") == 0);
      BOOST_TEST(kept_on.metric("device.engaged_share") > 0.9);
    }
  }
}

BOOST_FIXTURE_TEST_CASE(the_force_of_a_rollout_ends_when_its_trust_has_passed_and_a_held_one_at_the_bound, Fixture) {
  // Sixteen results, 125 ms each, and then none.
  std::string dies;
  for (int i = 0; i < 16; ++i) dies += "0.125\n";
  const fs::path slow = graph(trace(dies + "60\n"), "none", "  device: {stale_after: 1 s, sample_age_max: 1 s}\n",
                              "record: [coupling.force, device.commanded]\n");
  for (const Over& over : {held, local}) {
    BOOST_TEST_CONTEXT((over.empty() ? "held" : "rollout")) {
      std::vector<Stamped<Wrench>> results, commanded;
      unjudged_run(slow, over, {kept("coupling.force", results), kept("device.commanded", commanded)});
      BOOST_TEST_REQUIRE(!results.empty());
      const auto pushes = [](const Stamped<Wrench>& message) { return norm(message.value.force) > 0; };
      const auto last = std::find_if(commanded.rbegin(), commanded.rend(), pushes);
      BOOST_TEST_REQUIRE((last != commanded.rend()));
      // Each result is about an interval old when it comes; three of them are trusted. A ramp of 100 ms follows.
      const Stamp& result = results.back().stamp;
      const Time end = over.empty() ? result.produced + Duration{1'000'000'000} : result.valid + Duration{375'000'000};
      near((last->stamp.valid - end).milliseconds(), 100, 5);
      BOOST_TEST((last - commanded.rbegin() >= 300));
    }
  }
}

BOOST_FIXTURE_TEST_CASE(a_run_says_it_too, Fixture) {
  std::string told;
  RunOptions options{.without_reference = true};
  options.note = [&told](const std::string& one) { told += one; };
  run(planned(graph("{constant: 125 ms}")), {}, options);
  BOOST_TEST(is_of_physics(told), told);
}

BOOST_FIXTURE_TEST_CASE(a_live_graph_is_told_where_it_imposes_its_costs, Fixture) {
  const fs::path slow = graph("{constant: 125 ms}");
  BOOST_TEST(note(slow, {"clock=real"}) == "");
  BOOST_TEST(note(slow, {"clock=real", "live.impose_cost=true"}) != "");
}

BOOST_AUTO_TEST_SUITE_END()
