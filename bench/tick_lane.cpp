#include "bench/tick_lane.hpp"

#include <map>
#include <string>
#include <thread>
#include <vector>

#include "devices/simulated/simulated.hpp"
#include "framework/engine/live/realtime_lane.hpp"
#include "framework/realtime/thread_policy.hpp"

namespace tactor::bench {

namespace {

constexpr Duration feed_period{1'000'000};
constexpr int feeds_a_segment = 10;

/// One device; where its messages come from and go to is left to the bench.
struct DevicePlan {
  NodeInfo info = SimulatedDevice::declare();
  Plan plan;
  std::map<std::string, std::size_t> edge_of;  // by input

  explicit DevicePlan(double rate) {
    std::vector<ParamValue> values;
    for (const ParamInfo& param : info.params) values.push_back(param.default_value.value());
    values[info.rate_parameter.value()] = rate;
    plan.nodes.push_back({"device", &info, std::move(values), {}, {Lane::realtime, "", {}, {}, {}}, {}});
    for (std::size_t i = 0; i < info.inputs.size(); ++i) {
      PlannedEdge edge;
      edge.input = i;
      edge_of[info.inputs[i].name] = plan.edges.size();
      plan.edges.push_back(edge);
    }
  }
};

void feed(RealtimeLane& lane, const DevicePlan& device, Instant origin, Duration duration) {
  // Between two ticks of 1 kHz, as the engine comes after a tick.
  Instant due = origin + Duration{300'000};
  for (std::uint64_t n = 0; due - origin < duration; ++n, due = due + feed_period) {
    MonotonicClock::sleep_until(due);
    const Time now = Time{} + (MonotonicClock::now() - origin);
    const Stamp stamp{now, now, n};
    const double x = 1e-6 * static_cast<double>(n % 1000);
    const Target target{{{x, 0, 0}, {}}, {{1e-3, 0, 0}, {}}};
    lane[0].put(device.edge_of.at("target"), stamp, &target);
    if (n % feeds_a_segment == 0) {
      const ForceSegment segment{
          now, now + Duration{10'000'000}, {Wrench{{1, 2, 0}, {}}, Wrench{{0.1, 0, 0}, {}}, Wrench{}, Wrench{}}};
      lane[0].put(device.edge_of.at("segment"), stamp, &segment);
    }
    while (lane.take_tick()) {
    }
  }
}

}  // namespace

void run_lane(double rate, Duration duration, const ThreadSettings& settings, LaneTimes& times, FlightRing* flight) {
  const DevicePlan device(rate);
  PlanNodes nodes(device.plan);
  for (const InputInfo& input : device.info.inputs) input.access(nodes[0]).configure(Queue{});
  for (const OutputInfo& output : device.info.outputs) {
    output.access(nodes[0]).set_wanted(output.name == "state" || output.name == "commanded" || output.name == "safety");
  }
  RealtimeLane lane(nodes, find_chains(device.plan), 0, settings, flight);
  lane.set_phase(Phase::running);

  const Instant origin = MonotonicClock::now() + Duration{10'000'000};
  if (flight != nullptr) flight->set_origin(origin);
  lane.start(origin);
  // As the timer thread of the engine.
  std::thread timer([&] {
    apply_thread_settings({SchedulingPolicy::fifo, 70, std::nullopt}, "timer");
    feed(lane, device, origin, duration);
  });
  timer.join();
  TACTOR_DEMAND(lane.stop(Duration{1'000'000'000}));
  const LoopStatistics& metrics = lane.loop().metrics();
  times.body.merge(metrics.body_time);
  times.ticks += static_cast<std::uint64_t>(metrics.ended.value());
  times.missed += static_cast<std::uint64_t>(metrics.missed.value());
  times.dropped += lane.dropped_out();
  times.heap_calls += metrics.heap_calls.value();
  times.page_faults += metrics.page_faults.value();
  Report report;
  report.ask(nodes[0], "device", device.info.metrics);
  for (const auto& [name, value] : report.metrics()) {
    if (name == "device.engaged_share") times.engaged_share = value;
  }
}

}  // namespace tactor::bench
