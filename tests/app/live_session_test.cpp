// A shipped graph, live, tapped and tuned: nothing in its loop allocates, and its replay is equal to the byte.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <vector>

#include "app/run/record.hpp"
#include "app/run/replay.hpp"
#include "app/run/run.hpp"
#include "framework/core/message_batch.hpp"
#include "framework/core/messages.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/graph/chains.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/plugin.hpp"
#include "framework/node/registry.hpp"
#include "framework/record/recorder.hpp"
#include "framework/session/add_feed.hpp"
#include "framework/session/follower.hpp"
#include "framework/session/session.hpp"
#include "tests/support/shipped_graphs.hpp"

BOOST_AUTO_TEST_SUITE(live_session_test)

using namespace tactor;
using namespace tactor::test;
namespace fs = std::filesystem;

namespace {

constexpr Duration tenth{100'000'000};

struct NeedsLiveAndRecordings {
  boost::test_tools::assertion_result operator()(boost::unit_test::test_unit_id) const {
    boost::test_tools::assertion_result result(has_plugin("libtactor_live.so") && has_plugin("libtactor_record.so"));
    if (!result) result.message() << "this build has no live engine or no recordings";
    return result;
  }
};

/// The measured figures are of TACTOR_TUNED_SECONDS=60.
double seconds() {
  const char* asked = std::getenv("TACTOR_TUNED_SECONDS");
  return asked != nullptr ? std::atof(asked) : 4;
}

std::string seconds_text(double s) {
  return "duration=" + std::to_string(s) + " s";
}

/// Everything that a recording holds, by stream.
std::vector<std::pair<std::string, std::string>> contents(const fs::path& file) {
  std::vector<std::pair<std::string, std::string>> all;
  const std::unique_ptr<RecordingReader> reader = load_record_library().open(file);
  for (std::size_t s = 0; s < reader->streams().size(); ++s) {
    const RecordedStream& stream = reader->streams()[s];
    MessageBatch messages(stream.type);
    reader->read(s, 0, stream.count, messages);
    std::string bytes;
    for (std::size_t i = 0; i < messages.size(); ++i) {
      const Stamp stamp = messages.stamp(i);
      bytes.append(reinterpret_cast<const char*>(&stamp), sizeof stamp);
      bytes.append(static_cast<const char*>(static_cast<const void*>(messages.value(i))), stream.type.size);
    }
    all.emplace_back(stream.name, std::move(bytes));
  }
  return all;
}

struct Figures {
  std::uint64_t ticks = 0, missed = 0, page_faults = 0;
  std::optional<std::uint64_t> heap_calls;
};

/// Runs the plan live; with `tuned` under a tap and ten changes a second.
Figures run_live(const Plan& plan, bool tuned, const fs::path& file) {
  Session session(plan);
  const std::unique_ptr<Recorder> recorder =
      load_record_library().create(file, {to_yaml(plan.graph), plan.graph.seed, "test"});
  record(session, *recorder);
  session.start();
  std::unique_ptr<Session::OutputTap> tap;
  if (tuned) tap = session.tap("device.commanded", {QueuePolicy::drop_newest, 4096});
  std::uint64_t taken = 0, next = 0;
  for (int i = 0; session.is_running(); ++i) {
    session.advance(tenth);
    if (!tuned || !session.is_running()) continue;
    const bool coupling = i % 2 == 0;
    session.set(coupling ? "coupling.k_0" : "device.force_max",
                coupling ? std::to_string(400 + 100 * (i % 5)) + " N/m" : std::to_string(2 + i % 4) + " N");
    while (const MessageView message = tap->take()) {
      if (taken > 0) BOOST_TEST(message.stamp->sequence == next);
      next = message.stamp->sequence + 1;
      ++taken;
    }
  }
  session.finish();
  BOOST_TEST(!session.failure().has_value(), session.failure().value_or(""));
  BOOST_TEST(session.dropped() == 0U);
  recorder->close();
  const DeviceStatus device = session.status().devices.at(0);
  if (tuned) {
    BOOST_TEST(tap->dropped() == 0U);
    BOOST_TEST(taken + 300 > device.ticks);
  }
  return {device.ticks, device.missed, device.page_faults, device.heap_calls};
}

/// Replays a recording of so many streams, and compares all that both hold.
void check_replay(const fs::path& folder, const std::string& name, std::size_t streams) {
  fs::create_directory(folder / "replay");
  replay_recording(folder / name, folder / "replay", registry());
  const auto live = contents(folder / name);
  const auto again = contents(folder / "replay/recording.h5");
  BOOST_REQUIRE(live.size() == streams);
  BOOST_REQUIRE(again.size() == live.size());
  for (std::size_t s = 0; s < live.size(); ++s) {
    BOOST_TEST(live[s].first == again[s].first);
    BOOST_TEST((live[s].second == again[s].second), live[s].first << " differs");
    BOOST_TEST((live[s].first == "sets" || !live[s].second.empty()), live[s].first << " is empty");
  }
}

void tell(const char* what, const Figures& f) {
  BOOST_TEST_MESSAGE(what << ": " << f.ticks << " ticks, " << f.missed << " missed, " << f.page_faults
                          << " page faults, " << (f.heap_calls ? std::to_string(*f.heap_calls) : "uncounted")
                          << " heap calls");
}

double norm_of(const void* value) {
  Wrench w;
  std::memcpy(&w, value, sizeof w);
  return norm(w.force);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_tapped_and_tuned_live_run_is_replayed_to_the_byte,
                     *boost::unit_test::precondition(NeedsLiveAndRecordings{})) {
  const TemporaryFolder folder;
  const Plan plan = make_plan(loaded(
      "duck/live.yaml", {seconds_text(seconds()),
                         "record=[device.commanded, device.state, device.safety, coupling.force, dynamics.state]"}));
  const Figures plain = run_live(plan, false, folder.path() / "plain.h5");
  const Figures tuned = run_live(plan, true, folder.path() / "tuned.h5");
  tell("as it is", plain);
  tell("tapped, ten changes a second", tuned);
  BOOST_TEST(tuned.page_faults == plain.page_faults);
  if (tuned.heap_calls) {
    BOOST_TEST(*tuned.heap_calls == 0U);
  } else {
    BOOST_TEST_MESSAGE("heap calls are not counted in this build");
  }
  check_replay(folder.path(), "tuned.h5", 9);
}

BOOST_AUTO_TEST_CASE(a_stage_in_one_loop_with_the_device_is_replayed_to_the_byte,
                     *boost::unit_test::precondition(NeedsLiveAndRecordings{})) {
  const TemporaryFolder folder;
  const Plan plan = make_plan(
      loaded("wall/closed_loop.yaml", {"methods/hold.yaml", "passivity/energy_bound.yaml", seconds_text(2),
                                       "clock=real", "record=[device.commanded, device.state, passivity.segment]"}));
  BOOST_TEST(shared_loops(plan).size() == 1U);
  const Figures figures = run_live(plan, false, folder.path() / "chain.h5");
  tell("a device and a stage", figures);
  BOOST_TEST(figures.heap_calls.value_or(0) == 0U);
  check_replay(folder.path(), "chain.h5", 7);
}

BOOST_AUTO_TEST_CASE(what_a_program_fed_is_fed_again_by_a_replay,
                     *boost::unit_test::precondition(NeedsLiveAndRecordings{})) {
  const TemporaryFolder folder;
  GraphSpec graph =
      loaded("wall/scene.yaml", {seconds_text(1.5), "clock=real", "record=[device.state, coupling.force]"});
  add_feed(graph, "device.target", registry());
  const Plan plan = make_plan(graph);
  Session session(plan);
  Session::Feed target = session.feed("device.target");
  const std::unique_ptr<Recorder> recorder =
      load_record_library().create(folder.path() / "fed.h5", {to_yaml(plan.graph), plan.graph.seed, "test"});
  record(session, *recorder);
  session.start();
  for (int i = 0; session.is_running(); ++i) {
    Target where;
    where.X_WH.p = {0, 1e-4 * i, 0};
    BOOST_TEST(target.send(where));
    session.advance(Duration{7'000'000});
  }
  session.finish();
  recorder->close();
  check_replay(folder.path(), "fed.h5", 7);
}

BOOST_AUTO_TEST_CASE(a_change_of_the_method_in_contact_steps_no_force) {
  const std::vector<std::string> methods{"second", "third", "fourth", "first"};
  const Plan plan = make_plan(loaded("duck/scene.yaml", {"methods/side_by_side.yaml", seconds_text(6)}));
  Session session(plan);
  std::vector<Wrench> wanted;
  session.on_message("device.interpolated", [&](const Stamp&, const void* value) {
    Wrench w;
    std::memcpy(&w, value, sizeof w);
    wanted.push_back(w);
  });
  session.start();
  std::vector<std::size_t> changes;
  for (std::size_t i = 0; i < 120 && session.is_running(); ++i) {
    session.advance(Duration{43'000'000});
    // In contact, and wherever the methods are in their periods.
    if (wanted.empty() || norm(wanted.back().force) < 0.3) continue;
    changes.push_back(wanted.size());
    session.set("select.use", methods[i % methods.size()]);
  }
  session.finish();
  BOOST_TEST(changes.size() > 40U);
  const double slew = 2000e-3;  // N in a tick, of the gate
  double largest = 0, at_changes = 0;
  for (std::size_t i = 1; i < wanted.size(); ++i) {
    largest = std::max(largest, norm(wanted[i].force - wanted[i - 1].force));
  }
  for (const std::size_t change : changes) {
    for (std::size_t i = change; i < std::min(change + 3, wanted.size()); ++i) {
      at_changes = std::max(at_changes, norm(wanted[i].force - wanted[i - 1].force));
    }
  }
  BOOST_TEST_MESSAGE(changes.size() << " changes: largest step " << at_changes << " N there, " << largest
                                    << " N in the whole run");
  BOOST_TEST(largest < slew);
  BOOST_TEST(at_changes <= 0.3 * slew);
}

BOOST_AUTO_TEST_CASE(a_program_leads_the_hand_of_a_shipped_graph) {
  GraphSpec graph = loaded("wall/scene.yaml", {seconds_text(1)});
  add_feed(graph, "device.target", registry(), Queue{QueuePolicy::latest, 1});
  graph.record = {"coupling.force"};
  Session session(make_plan(graph));
  Session::Feed target = session.feed("device.target");
  BOOST_TEST(target.type().name == "Target");
  double largest = 0, at = 0;
  session.on_message("coupling.force",
                     [&](const Stamp&, const void* value) { largest = std::max(largest, norm_of(value)); });
  session.on_message("device.truth", [&](const Stamp&, const void* value) {
    DeviceState state;
    std::memcpy(static_cast<void*>(&state), value, sizeof state);
    at = state.X_WD.p.x;
  });
  session.start();
  for (int i = 0; i < 100; ++i) {
    Target where;
    where.X_WH.p = {0.1 + 1e-4 * i, 0, 0.2};
    BOOST_TEST(target.send(where));
    session.advance(Duration{10'000'000});
  }
  session.finish();
  BOOST_TEST(std::abs(at - (0.1 + 1e-4 * 99)) < 1e-9);
  BOOST_TEST(!session.is_running());
  BOOST_CHECK_THROW(add_feed(graph, "device.targt", registry()), InputError);
}

BOOST_AUTO_TEST_CASE(a_reference_follows_a_run_and_finds_the_error_that_is_found_afterwards) {
  const Plan plan = make_plan(loaded("duck/refit.yaml", {seconds_text(4)}));
  const auto followed = [&plan] {
    Session session(plan);
    Follower follower(session, registry(), {.most_behind = std::nullopt});
    session.start();
    while (session.is_running()) {
      session.advance(Duration{50'000'000});
      follower.follow();
    }
    session.finish();
    follower.follow();
    return follower.figures();
  };
  const FollowerFigures found = followed();
  BOOST_TEST(found.skips == 0U);
  BOOST_TEST(found.dropped == 0U);
  BOOST_TEST(!found.failure.has_value());
  BOOST_TEST(found.error.compared > 3000U);
  BOOST_TEST(found.behind.seconds() < 0.01);
  const TemporaryFolder references;
  RunOptions options;
  options.cache_folder = references.path();
  options.judge_whole = true;  // as the follower does
  const RunResult judged = execute(plan, options);
  const double error = judged.metric("delivered.force.rms_error_N"),
               largest = judged.metric("delivered.force.max_error_N");
  BOOST_TEST_MESSAGE("error " << found.error.rms_N << " N, afterwards " << error << "; largest " << found.error.max_N
                              << ", afterwards " << largest);
  // The physics of the one steps 1,000 times a second, that of the other 10,000 times.
  BOOST_TEST(found.error.rms_N == error, boost::test_tools::tolerance(0.1));
  BOOST_TEST(found.error.max_N == largest, boost::test_tools::tolerance(0.15));
  BOOST_REQUIRE(found.error.delay.has_value());
  BOOST_TEST(found.error.delay->milliseconds() > 0);
  // Under the virtual clock it is the same every time.
  const FollowerFigures again = followed();
  BOOST_TEST(again.error.rms_N == found.error.rms_N);
  BOOST_TEST(again.error.compared == found.error.compared);
}

BOOST_AUTO_TEST_CASE(a_follower_that_is_too_slow_skips_and_counts_what_it_skipped) {
  const Plan plan = make_plan(loaded("duck/refit.yaml", {seconds_text(6)}));
  Session session(plan);
  Follower follower(session, registry(), {.most_behind = Duration{300'000'000}});
  session.start();
  // A second of the run at once is more than it may be behind.
  for (int i = 0; i < 6; ++i) {
    session.advance(Duration{1'000'000'000});
    follower.follow();
  }
  session.finish();
  const FollowerFigures found = follower.figures();
  BOOST_TEST(found.skips >= 4U);
  BOOST_TEST(found.skipped.seconds() > 3);
  BOOST_TEST(found.skipped.seconds() <= 6 + 0.3 * static_cast<double>(found.skips));
  BOOST_TEST(found.dropped == 0U);
}

BOOST_AUTO_TEST_CASE(what_a_follower_lost_is_skipped_too) {
  const Plan plan = make_plan(loaded("duck/refit.yaml", {seconds_text(8)}));
  Session session(plan);
  Follower follower(session, registry(), {.most_behind = std::nullopt});
  session.start();
  session.advance(Duration{1'000'000'000});
  follower.follow();
  // More than its taps hold.
  session.advance(Duration{5'500'000'000});
  follower.follow();
  session.advance(Duration{1'500'000'000});
  follower.follow();
  session.finish();
  const FollowerFigures found = follower.figures();
  BOOST_TEST(found.dropped > 1000U);
  BOOST_TEST(found.skips == 1U);
  BOOST_TEST(found.skipped.seconds() > 1);
  BOOST_TEST(found.error.rms_N < 0.12);
  BOOST_TEST(found.error.covered.seconds() + found.skipped.seconds() + 0.3 > 7.5);
}

BOOST_AUTO_TEST_CASE(a_run_without_a_truth_to_compare_with_is_not_followed) {
  GraphSpec graph = loaded("wall/scene.yaml", {seconds_text(1), "record=[coupling.force]"});
  std::erase_if(graph.nodes, [](const NodeSpec& node) { return node.info->sink; });
  std::erase_if(graph.edges, [&graph](const EdgeSpec& edge) { return graph.node(edge.to_node) == nullptr; });
  Session session(make_plan(graph));
  BOOST_CHECK_THROW(Follower(session, registry()), InputError);
}

BOOST_AUTO_TEST_CASE(a_reference_beside_a_live_run_costs_its_loop_nothing,
                     *boost::unit_test::precondition(NeedsLiveAndRecordings{})) {
  const Plan plan = make_plan(loaded("duck/live.yaml", {seconds_text(4)}));
  Session session(plan);
  Follower follower(session, registry());
  follower.start();
  session.start();
  while (session.is_running()) session.advance(tenth);
  session.finish();
  follower.finish(Duration{2'000'000'000});
  const FollowerFigures found = follower.figures();
  const DeviceStatus device = session.status().devices.at(0);
  tell("followed", {device.ticks, device.missed, device.page_faults, device.heap_calls});
  BOOST_TEST_MESSAGE("error " << found.error.rms_N << " N RMS, " << found.skips << " skips of "
                              << found.skipped.seconds() << " s");
  BOOST_TEST(!found.failure.has_value(), found.failure.value_or(""));
  BOOST_TEST(device.heap_calls.value_or(0) == 0U);
  BOOST_TEST(found.error.covered.seconds() + found.skipped.seconds() > 3);
  // What the device is told while it ramps down is no error.
  BOOST_TEST(found.error.rms_N < 0.12);
  BOOST_TEST(found.error.until.seconds() <= 4);
}

BOOST_AUTO_TEST_SUITE_END()
