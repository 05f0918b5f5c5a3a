// Physics of a program in wall time: a slow one is late, and a replay makes its run again to the byte.
#include <boost/test/unit_test.hpp>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>

#include "app/run/record.hpp"
#include "app/run/replay.hpp"
#include "framework/node/plugin.hpp"
#include "framework/record/recorder.hpp"
#include "tests/own_physics/own_copy.hpp"
#include "tests/support/needs_live.hpp"

BOOST_AUTO_TEST_SUITE(physics_live_test)

using namespace tactor;
using namespace tactor::test;

namespace {

/// The bytes of each stream of a recording, by name.
std::map<std::string, std::string> streams_of(const std::filesystem::path& file) {
  std::map<std::string, std::string> streams;
  const std::unique_ptr<RecordingReader> reader = load_record_library().open(file);
  for (std::size_t s = 0; s < reader->streams().size(); ++s) {
    const RecordedStream& stream = reader->streams()[s];
    MessageBatch messages(stream.type);
    reader->read(s, 0, stream.count, messages);
    std::string& bytes = streams[stream.name];
    for (std::size_t i = 0; i < messages.size(); ++i) {
      const Stamp stamp = messages.stamp(i);
      bytes.append(reinterpret_cast<const char*>(&stamp), sizeof stamp);
      bytes.append(reinterpret_cast<const char*>(messages.value(i)), stream.type.size);
    }
  }
  return streams;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_live_run_with_several_fed_outputs_is_replayed_to_the_byte,
                     *boost::unit_test::precondition(NeedsLive{})) {
  if (!has_plugin("libtactor_record.so")) {
    BOOST_TEST_MESSAGE("this build has no recordings");
    return;
  }
  const TemporaryFolder folder;
  const Plan plan = planned_text(graph_text("clock: real\nduration: 1.2 s", pressing_hand, 100, rolled_out,
                                            "device.commanded, device.state, physics.state, local.model"));
  Session session(plan);
  const std::unique_ptr<Recorder> recorder =
      load_record_library().create(folder.path() / "live.h5", {to_yaml(plan.graph), plan.graph.seed, "test"});
  record(session, *recorder);
  run_ball(session);
  session.finish();
  BOOST_TEST(!session.failure().has_value(), session.failure().value_or(""));
  recorder->close();
  std::filesystem::create_directory(folder.path() / "replay");
  replay_recording(folder.path() / "live.h5", folder.path() / "replay", registry());
  const auto live = streams_of(folder.path() / "live.h5");
  const auto again = streams_of(folder.path() / "replay/recording.h5");
  // Those that the graph records, those of every live run, and what else was fed and read.
  for (const char* name : {"device.commanded", "device.state", "physics.state", "local.model", "steps", "ticks", "stop",
                           "physics.bodies", "physics.contacts"}) {
    BOOST_TEST_CONTEXT(name) {
      BOOST_REQUIRE(live.contains(name));
      BOOST_REQUIRE(again.contains(name));
      BOOST_TEST(!live.at(name).empty());
      BOOST_TEST((live.at(name) == again.at(name)));
    }
  }
  BOOST_TEST(!live.contains("physics.force"));  // nobody reads it
}

BOOST_AUTO_TEST_CASE(a_program_that_stalls_is_late_physics, *boost::unit_test::precondition(NeedsLive{})) {
  Session session(planned_text(graph_text("clock: real\nduration: 1 s", pressing_hand, 100, held, "physics.state")));
  std::vector<Stamped<PhysicsState>> state;
  keep(session, "physics.state", state);
  std::optional<Time> last;
  int steps = 0;
  run_ball(session, [&](const PhysicsStep& step) {
    // No sample is gone through twice or left out.
    if (last) BOOST_TEST((step.begin == *last));
    BOOST_TEST((step.end > step.begin));
    last = step.end;
    if (++steps == 20) std::this_thread::sleep_for(std::chrono::milliseconds(200));
    if (steps == 21) BOOST_TEST(step.h() > 0.15);
  });
  session.finish();
  BOOST_TEST(!session.failure().has_value(), session.failure().value_or(""));
  BOOST_TEST(steps > 21);
  BOOST_REQUIRE(state.size() > 21U);
  for (const auto& [stamp, value] : state) BOOST_TEST((stamp.produced > stamp.valid));
}

BOOST_AUTO_TEST_CASE(a_copy_that_fails_in_the_loop_of_the_device_ends_in_zero_force,
                     *boost::unit_test::precondition(NeedsLive{})) {
  for (const bool throws : {true, false}) {
    Session session(
        planned_with_copy(graph_text("clock: real\nduration: 3 s", pressing_hand, 100, held, "device.commanded")));
    std::vector<Stamped<Wrench>> commanded;
    keep(session, "device.commanded", commanded);
    PhysicsLoop loop(session);
    loop.rollout(MassAndWall::numbers, [throws](std::span<double> state, const CopyStep& step) {
      CopyTool tool = MassAndWall::step(state, step);
      if (state[2] > MassAndWall::radius - 1e-3) return tool;
      if (throws) throw std::runtime_error("too deep");
      tool.X_WT.p.x = std::nan("");
      return tool;
    });
    run_mass(loop);
    session.finish();
    const std::string failure = session.failure().value_or("none");
    BOOST_TEST(failure.find("the program's light copy failed in its step from ") != std::string::npos, failure);
    BOOST_TEST((failure.starts_with("node rollout failed at ") || failure.starts_with("node resimulation failed at ")),
               failure);
    BOOST_REQUIRE(!commanded.empty());
    BOOST_TEST(norm(commanded.back().value.force) == 0.0);
  }
}

BOOST_AUTO_TEST_SUITE_END()
