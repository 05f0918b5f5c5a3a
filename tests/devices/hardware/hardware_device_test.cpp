// A device of hardware over a scripted line: states, efforts, and everything that must keep a force out.
#include <boost/test/unit_test.hpp>
#include <cmath>

#include "devices/hardware/declare_hardware.hpp"
#include "framework/core/check.hpp"
#include "framework/core/segment.hpp"
#include "tests/devices/hardware/scripted_link.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(hardware_device_test)

using namespace tactor;
using tactor::test::eventually;
using tactor::test::LinkScript;

namespace {

LinkScript* script = nullptr;

/// One axis along z, 10 N and 2 m/s.
class TestDevice final : public HardwareDevice {
 public:
  struct Params : HardwareParams {};
  TestDevice(const Params& params, const NodeContext& context) : HardwareDevice(params, context, parts()) {}
  static NodeInfo declare() {
    Declare<TestDevice> declaration("test.hardware", "A scripted line.");
    HardwareParams defaults;
    defaults.link_timeout = Duration{500'000'000};  // a machine with much else to do is late
    defaults.recovery_time = Duration{50'000'000};
    declare_hardware(declaration, defaults);
    return declaration.info();
  }

 private:
  static HardwareParts parts() {
    HardwareParts parts;
    parts.link = std::make_unique<test::ScriptedLink>(*script);
    parts.kinematics = std::make_unique<LinearKinematics>(std::vector<Vec3>{{0, 0, 1}});
    parts.limits.effort_max = {6};
    parts.limits.speed_max = {2};
    parts.limits.jump_tolerance = {1e-3};
    return parts;
  }
};

/// The device under test, in a scene that outlives it, for a run of this length.
std::unique_ptr<Node> make_arm(const Scene& scene, std::map<std::string, ParamValue> given = {},
                               Duration duration = {}) {
  given.try_emplace("force_max", 8.0);  // N, more than the tests want
  const NodeInfo info = TestDevice::declare();
  NodeContext context;
  context.name = "arm";
  context.scene = &scene;
  context.torque = false;
  context.duration = duration;
  return info.create(test::param_values(info, given), context);
}

class Bench {
 public:
  explicit Bench(const std::map<std::string, ParamValue>& given = {}) {
    script = &line;
    line.q = base;
    BOOST_TEST(TestDevice::declare().hardware.has_value());
    node = make_arm(scene_, given, Duration{10'000'000'000});
    device().segment.configure({QueuePolicy::latest, 1});
    origin_ = MonotonicClock::now();
    StepContext start(Time{}, Phase::starting);
    device().start(start);
  }
  TestDevice& device() { return dynamic_cast<TestDevice&>(*node); }
  /// One tick of a loop at 1 kHz in wall time, wanting `force` along z.
  void tick(double force) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const Time now{(MonotonicClock::now() - origin_).ns};
    const ForceSegment segment = constant_segment(now, {{0, 0, force}, {}});
    device().segment.push({now, now, ++sequence_}, &segment);
    StepContext context(now, Phase::running);
    try {
      device().step(context);
    } catch (const RunError& error) {
      ended = error.what();
    }
    if (device().state.pending() > 0) state = *static_cast<const DeviceState*>(device().state.pending_value(0));
    commanded = static_cast<const Wrench*>(device().commanded.pending_value(0))->force.z;
    safety = *static_cast<const SafetyState*>(device().safety.pending_value(0));
    for (OutputBase* output : std::initializer_list<OutputBase*>{&device().state, &device().interpolated,
                                                                 &device().commanded, &device().safety})
      output->clear_pending();
    // Each sample differs by a micrometre, as a real encoder's does.
    if (moves) line.q = base + 1e-6 * static_cast<double>(sequence_ % 2);
  }
  bool ticking(double force, const std::function<bool()>& condition) {
    for (int i = 0; i < 30'000; ++i) {
      tick(force);
      if (condition()) return true;
    }
    return false;
  }
  bool engaged(double force) {
    return ticking(force, [this] { return safety.engagement == Engagement::engaged; });
  }
  double metric(const std::string& name) {
    Report report;
    report.ask(device(), "arm", TestDevice::declare().metrics);
    remarks = report.remarks();
    return test::metrics_of(report).at(name);
  }

  LinkScript line;
  std::unique_ptr<Node> node;
  DeviceState state;
  double commanded = 0;
  SafetyState safety;
  std::string ended;
  bool moves = true;
  double base = 0.02;
  std::vector<std::string> remarks;

 private:
  Scene scene_;
  Instant origin_;
  std::uint64_t sequence_ = 0;
};

}  // namespace

BOOST_AUTO_TEST_CASE(hardware_is_given_little_force_and_a_dead_man_button_by_default) {
  const NodeInfo info = TestDevice::declare();
  const auto by_default = [&info](const char* name) { return info.params.at(info.param(name).value()).default_value; };
  BOOST_TEST((by_default("force_max") == ParamValue(3.0)));
  BOOST_TEST((by_default("torque_max") == ParamValue(0.1)));
  BOOST_TEST((by_default("dead_man_button") == ParamValue(std::monostate{})));
  LinkScript line;
  script = &line;
  const Scene scene;
  // Nobody knows whether it has a button.
  BOOST_TEST(dynamic_cast<TestDevice&>(*make_arm(scene)).lacks_dead_man());
  for (const std::int64_t button : {0, 2}) {
    const std::unique_ptr<Node> node = make_arm(scene, {{"dead_man_button", button}});
    BOOST_TEST(!dynamic_cast<TestDevice&>(*node).lacks_dead_man());
  }
}

BOOST_AUTO_TEST_CASE(the_handle_is_where_the_workspace_puts_it_and_its_force_goes_back) {
  Bench bench({{"workspace_scale", 2.0},
               {"force_scale", 0.5},
               {"origin", std::vector<double>{0.1, 0, 0}},
               {"rotation", std::vector<double>{0, M_PI, 0}}});
  BOOST_TEST(bench.engaged(4));
  BOOST_TEST(std::abs(bench.state.X_WD.p.x - 0.1) < 1e-6);
  BOOST_TEST(std::abs(bench.state.X_WD.p.z + 0.04) < 1e-5);
  BOOST_TEST(bench.ticking(4, [&] { return std::abs(bench.line.effort + 2) < 1e-12; }));
}

BOOST_AUTO_TEST_CASE(efforts_stay_within_the_limits_of_the_device_itself) {
  Bench bench({{"force_scale", 10.0}});
  BOOST_TEST(bench.engaged(4));
  BOOST_TEST(bench.ticking(4, [&] { return bench.line.effort == 6.0; }));
  for (const double effort : bench.line.given()) BOOST_TEST((effort <= 6 || effort == test::opening_mark));
  BOOST_TEST(bench.metric("device.limited_ticks") > 0);
}

BOOST_AUTO_TEST_CASE(a_line_opened_anew_brings_the_force_down_and_back_by_the_ramp) {
  Bench bench;
  BOOST_TEST(bench.engaged(4));
  BOOST_TEST(bench.ticking(4, [&] { return bench.line.effort == 4.0; }));
  bench.line.reopen = true;
  bench.line.error = LinkError::reset;
  bench.line.fails = 1;
  BOOST_TEST(bench.ticking(4, [&] { return bench.safety.engagement == Engagement::fault; }));
  BOOST_TEST(bench.engaged(4));
  BOOST_TEST(bench.ticking(4, [&] { return bench.line.effort == 4.0; }));
  const std::vector<double> given = bench.line.given();
  std::size_t opened = given.size();
  while (given[--opened] != test::opening_mark) {
  }
  // It comes back through values in between, not at once.
  BOOST_TEST(given.at(opened + 1) == 0.0);
  int between = 0;
  for (std::size_t i = opened + 1; i < given.size(); ++i) between += given[i] > 0 && given[i] < 3 ? 1 : 0;
  BOOST_TEST(between > 0);
  BOOST_TEST(bench.metric("device.link.reconnects") == 1);
  BOOST_TEST(bench.metric("device.link.errors.reset") == 1);
  BOOST_TEST(bench.remarks.at(0) ==
             "test rig at port 7: 1 reset, opened anew 1 times; the last: no answer within 5 ms");
}

BOOST_AUTO_TEST_CASE(a_position_that_has_jumped_gets_no_force_and_ends_the_run_with_the_devices_name) {
  Bench bench({{"failure_timeout", 0.3}});
  BOOST_TEST(bench.engaged(4));
  bench.base = 0.2;
  BOOST_TEST(bench.ticking(4, [&] { return bench.safety.cause == SafetyCause::read_failed; }));
  BOOST_TEST(bench.ticking(4, [&] { return !bench.ended.empty(); }));
  BOOST_TEST(bench.ended.find("test rig at port 7: the encoder of axis 1 jumped from 0.02") != std::string::npos,
             bench.ended);
  BOOST_TEST(bench.commanded == 0.0);
  BOOST_TEST(bench.metric("device.jumps") == 1);
}

BOOST_AUTO_TEST_CASE(an_encoder_that_stands_still_under_force_faults) {
  Bench bench({{"stuck_after", 0.2}, {"failure_timeout", 0.3}});
  bench.moves = false;
  bench.line.q = 0.02;
  BOOST_TEST(bench.ticking(4, [&] { return !bench.ended.empty(); }));
  BOOST_TEST(bench.ended.find("it is stuck") != std::string::npos, bench.ended);
  BOOST_TEST(bench.metric("device.stuck") == 1);
}

BOOST_AUTO_TEST_CASE(a_fault_of_the_device_is_told_in_its_words) {
  Bench bench({{"failure_timeout", 0.2}});
  BOOST_TEST(bench.engaged(4));
  bench.line.faults = 4;
  BOOST_TEST(bench.ticking(4, [&] { return !bench.ended.empty(); }));
  BOOST_TEST(bench.ended.find("test rig at port 7: it is too hot") != std::string::npos, bench.ended);
  BOOST_TEST(bench.metric("device.link.errors.device_fault") > 0);
  BOOST_TEST(!bench.remarks.empty());
}

BOOST_AUTO_TEST_CASE(a_device_that_never_answers_ends_the_run) {
  script = nullptr;
  Bench bench({{"connect_timeout", 0.1}, {"failure_timeout", 0.1}});
  bench.line.opens = false;
  // The first opening may have come before the script said no.
  bench.line.reopen = true;
  bench.line.fails = 1 << 30;
  BOOST_TEST(bench.ticking(4, [&] { return !bench.ended.empty(); }));
  BOOST_TEST(bench.ended.find("test rig at port 7") != std::string::npos, bench.ended);
}

BOOST_AUTO_TEST_CASE(a_device_whose_line_never_opens_ends_the_run_before_it_begins) {
  LinkScript line;
  line.opens = false;
  script = &line;
  const Scene scene;
  const std::unique_ptr<Node> node = make_arm(scene, {{"connect_timeout", 0.3}});
  auto& device = dynamic_cast<TestDevice&>(*node);
  StepContext start(Time{}, Phase::starting);
  BOOST_CHECK_EXCEPTION(device.start(start), RunError, [](const RunError& error) {
    return std::string(error.what()) == "cannot be reached: test rig at port 7: nobody answers";
  });
  // Once is not enough: the first answer of a line may be lost.
  BOOST_TEST(line.attempts >= 2);
}

BOOST_AUTO_TEST_CASE(a_reference_run_follows_the_states_and_drives_nothing) {
  Bench judged;
  BOOST_TEST(judged.engaged(1));
  LinkScript unused;
  script = &unused;
  const Scene scene;
  const std::unique_ptr<Node> reference = make_arm(scene);
  auto& device = dynamic_cast<TestDevice&>(*reference);
  device.segment.configure({QueuePolicy::latest, 1});
  device.follow(judged.device());
  StepContext start(Time{}, Phase::starting);
  device.start(start);
  StepContext step(Time{1'000'000'000}, Phase::running);
  device.step(step);
  BOOST_TEST(device.state.pending() == 1U);
  BOOST_TEST(std::abs(static_cast<const DeviceState*>(device.state.pending_value(0))->X_WD.p.z - 0.02) < 2e-6);
  BOOST_TEST(unused.attempts == 0);
}

BOOST_AUTO_TEST_SUITE_END()
