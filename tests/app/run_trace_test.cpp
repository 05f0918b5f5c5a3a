// What a run's page shows of its devices, against every message of the run.
#include "app/run/run_trace.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "app/run/run.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/graph/plan.hpp"
#include "framework/graph/spec.hpp"
#include "framework/node/plugin.hpp"
#include "framework/node/registry.hpp"

BOOST_AUTO_TEST_SUITE(run_trace_test)

using namespace tactor;

namespace {

/// All messages of an output.
template <class T>
struct Heard {
  std::vector<Stamped<T>> messages;
  Session::Take take() {
    return [this](const Stamp& stamp, const void* value) {
      Stamped<T>& message = messages.emplace_back();
      message.stamp = stamp;
      std::memcpy(static_cast<void*>(&message.value), value, sizeof(T));
    };
  }
};

struct Told {
  RunResult result;
  Heard<Wrench> commanded;
  Heard<PhysicsState> state;
  Heard<SafetyState> safety;
};

void run(const std::string& more, Told& told) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "graph.yaml";
  std::ofstream(file) << "extends: " << TACTOR_SOURCE_DIR << "/graphs/wall/off.yaml\nduration: 1 s\n" << more;
  Registry registry(default_node_folders());
  RunOptions options;
  options.traces = true;
  options.without_reference = true;
  options.before_start = [&told](Session& session) {
    session.on_message("device.commanded", told.commanded.take());
    session.on_message("dynamics.state", told.state.take());
    session.on_message("device.safety", told.safety.take());
  };
  told.result = execute(make_plan(load_graph(file, registry)), options);
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_largest_force_is_that_of_all_messages_and_the_tool_is_where_it_was_then) {
  Told told;
  run("", told);
  BOOST_REQUIRE(told.result.trace.devices.size() == 1U);
  const DeviceTrace& device = told.result.trace.devices.front();
  BOOST_TEST(device.device == "device");
  const auto& commanded = told.commanded.messages;
  const auto largest = std::max_element(commanded.begin(), commanded.end(), [](const auto& a, const auto& b) {
    return norm(a.value.force) < norm(b.value.force);
  });
  BOOST_REQUIRE((largest != commanded.end()));
  BOOST_REQUIRE(told.result.trace.largest.has_value());
  const LargestForce& found = *told.result.trace.largest;
  BOOST_TEST(norm(found.force_W) == norm(largest->value.force));
  BOOST_TEST(found.time_s == largest->stamp.valid.seconds());
  BOOST_TEST(norm(found.force_W) > 0.5);
  Vec3 p_WT;
  for (const auto& state : told.state.messages) {
    if (state.stamp.produced.seconds() <= found.time_s) p_WT = state.value.X_WT.p;
  }
  BOOST_REQUIRE(found.X_WB.size() == 1U);
  BOOST_TEST(norm(found.X_WB.front().p - p_WT) == 0);
  BOOST_TEST(*std::max_element(device.force.value.begin(), device.force.value.end()) == norm(found.force_W));
  BOOST_TEST(device.displacement.value.front() == 0);
  BOOST_TEST(device.gate.value.back() == 1);
  BOOST_TEST(device.events.empty());
}

BOOST_AUTO_TEST_CASE(a_fault_is_told_when_it_begins_and_the_gate_is_shut_from_then) {
  Told told;
  run("nodes: {device: {speed_max: 20 mm/s}}\n", told);
  const auto& safety = told.safety.messages;
  std::vector<double> began;
  for (std::size_t i = 1; i < safety.size(); ++i) {
    if (safety[i].value.cause == SafetyCause::overspeed && safety[i - 1].value.cause != SafetyCause::overspeed)
      began.push_back(safety[i].stamp.valid.seconds());
  }
  BOOST_REQUIRE(!began.empty());
  const DeviceTrace& device = told.result.trace.devices.front();
  std::vector<double> told_at;
  for (const GateEvent& event : device.events) {
    BOOST_TEST((event.cause == SafetyCause::overspeed));
    told_at.push_back(event.time_s);
  }
  BOOST_TEST(told_at == began, boost::test_tools::per_element());
  BOOST_TEST(*std::min_element(device.gate.value.begin() + 300, device.gate.value.end()) == 0);
}

BOOST_AUTO_TEST_CASE(a_run_that_is_not_asked_to_trace_has_no_trace) {
  Registry registry(default_node_folders());
  RunOptions options;
  options.without_reference = true;
  GraphSpec graph = load_graph(std::filesystem::path(TACTOR_SOURCE_DIR) / "graphs/wall/off.yaml", registry);
  graph.duration = Duration{50'000'000};
  const RunResult result = execute(make_plan(graph), options);
  BOOST_TEST(result.trace.devices.empty());
  BOOST_TEST(!result.trace.largest.has_value());
}

BOOST_AUTO_TEST_SUITE_END()
