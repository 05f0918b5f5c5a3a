// A simulated device that a test drives tick by tick.
#pragma once

#include <boost/test/unit_test.hpp>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "devices/simulated/simulated.hpp"
#include "framework/core/segment.hpp"
#include "tests/support/nodes.hpp"

namespace tactor::test {

/// A device made from its declared defaults, driven tick by tick.
class Bench {
 public:
  explicit Bench(const std::map<std::string, ParamValue>& given, bool torque = true, std::uint64_t seed = 0) {
    const NodeInfo info = SimulatedDevice::declare();
    const std::vector<ParamValue> values = param_values(info, given);
    period_ = Duration::from_rate(std::get<double>(values.at(info.param("rate").value())));
    NodeContext context;
    context.name = "device";
    context.scene = &scene_;
    context.torque = torque;
    context.seed = seed;
    context.duration = Duration{2'000'000'000};
    node_ = info.create(values, context);
    device().target.configure({QueuePolicy::latest, 1});
    device().segment.configure({QueuePolicy::latest, 1});
  }

  [[nodiscard]] SimulatedDevice& device() { return dynamic_cast<SimulatedDevice&>(*node_); }
  [[nodiscard]] Time now() const { return now_; }
  void target(const MotionState& motion) {
    const Target message{motion.X, motion.V};
    device().target.push({now_, now_, 0}, &message);
  }
  /// A message that is newer than every one before.
  void segment(const ForceSegment& s) { device().segment.push({now_, now_, sequence_++}, &s); }
  /// Steps at `now` and moves on by a period.
  void tick() {
    StepContext context(now_);
    device().step(context);
    shown.reset();
    if (device().truth.pending() > 0) truth = *static_cast<const DeviceState*>(device().truth.pending_value(0));
    if (device().motors.pending() > 0) motors = *static_cast<const Wrench*>(device().motors.pending_value(0));
    if (device().state.pending() > 0) {
      shown = *static_cast<const DeviceState*>(device().state.pending_value(0));
      BOOST_REQUIRE(device().state.pending_valid(0) == now_);
    }
    BOOST_REQUIRE(device().commanded.pending() == 1U);
    commanded = *static_cast<const Wrench*>(device().commanded.pending_value(0));
    device().state.clear_pending();
    device().truth.clear_pending();
    device().motors.clear_pending();
    device().commanded.clear_pending();
    device().interpolated.clear_pending();
    device().safety.clear_pending();
    now_ = now_ + period_;
  }
  /// Lets ticks pass that the device misses.
  void miss(int ticks) { now_ = now_ + period_ * ticks; }
  [[nodiscard]] std::map<std::string, double> metrics() { return metrics_of(device()); }

  std::optional<DeviceState> shown;
  DeviceState truth;
  Wrench commanded;
  Wrench motors;

 private:
  Scene scene_;
  std::unique_ptr<Node> node_;
  Time now_;
  Duration period_;
  std::uint64_t sequence_ = 0;
};

/// A safety gate that is fully open from the second tick with a segment on, for tests of what is behind it.
inline const std::map<std::string, ParamValue> open_gate{
    {"engage_time", 0.001}, {"stale_after", 10.0}, {"force_slew", 1e9}, {"torque_slew", 1e9}};

inline std::map<std::string, ParamValue> with(std::map<std::string, ParamValue> first,
                                              const std::map<std::string, ParamValue>& second) {
  first.insert(second.begin(), second.end());
  return first;
}

}  // namespace tactor::test
