// What comes at a port's two inputs, told in the order of its times.
#include "nodes/passivity/port_samples.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <string>

#include "tests/support/force_stream.hpp"

BOOST_AUTO_TEST_SUITE(port_samples_test)

using namespace tactor;
using namespace tactor::test;

namespace {

/// Tells in letters what was told: `s` and the place of a sample in m, `w` and the force of a wrench in N.
struct Port {
  Port() {
    device.configure({QueuePolicy::drop_oldest, 64});
    commanded.configure({QueuePolicy::drop_oldest, 64});
  }
  void sample(double ms, double x) {
    DeviceState state;
    state.X_WD.p.x = x;
    device.push(stamp_ms(ms, n++), &state);
  }
  void wrench(double ms, double force) {
    const Wrench value{{force, 0, 0}, {}};
    commanded.push(stamp_ms(ms, n++), &value);
  }
  std::string take() {
    std::string told;
    const auto add = [&told](char what, double value) { told += what + std::to_string(std::lround(value)) + " "; };
    samples.take(
        device, commanded, [&](const Wrench& w) { add('w', w.force.x); },
        [&](const Stamped<DeviceState>& s) { add('s', s.value.X_WD.p.x); });
    return told;
  }
  Input<DeviceState> device;
  Input<Wrench> commanded;
  PortSamples samples;
  std::uint64_t n = 0;
};

}  // namespace

BOOST_AUTO_TEST_CASE(a_wrench_of_the_time_of_a_sample_comes_behind_it) {
  Port port;
  for (int ms = 0; ms < 3; ++ms) {
    port.wrench(ms, 10 + ms);
    port.sample(ms, ms);
  }
  BOOST_TEST(port.take() == "s0 w10 s1 w11 s2 w12 ");
  BOOST_TEST(port.samples.newest().value.X_WD.p.x == 2);
  BOOST_TEST(port.take().empty());
}

BOOST_AUTO_TEST_CASE(a_wrench_that_is_known_before_the_sample_of_its_time_is_told_at_once) {
  Port port;
  port.wrench(0, 10);
  BOOST_TEST(port.take() == "w10 ");
  BOOST_TEST(!port.samples.started());
  port.sample(0, 0);
  port.sample(1, 1);
  port.wrench(0.5, 11);
  BOOST_TEST(port.take() == "s0 w11 s1 ");
}

BOOST_AUTO_TEST_CASE(what_is_not_finite_or_not_later_is_left_out) {
  Port port;
  const double nan = std::nan("");
  port.sample(1, 1);
  port.wrench(1, nan);
  port.sample(2, nan);
  port.sample(1, 3);
  port.sample(0.5, 4);
  port.wrench(2.5, 12);
  port.sample(3, 5);
  BOOST_TEST(port.take() == "s1 w12 s5 ");
  BOOST_TEST(port.samples.newest().value.X_WD.p.x == 5);
}

BOOST_AUTO_TEST_SUITE_END()
