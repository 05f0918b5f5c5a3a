// The latencies of a live run as CSV, from which runs are put together.
#include "app/run/live.hpp"

#include <boost/test/unit_test.hpp>

BOOST_AUTO_TEST_SUITE(live_test)

using namespace tactor;

BOOST_AUTO_TEST_CASE(latencies_are_written_by_device_and_edge_with_their_counts) {
  Plan plan;
  plan.nodes.resize(2);
  plan.nodes[1].name = "device";
  PlannedEdge edge;
  edge.spec.from_node = "physics";
  edge.spec.from_port = "out";
  edge.spec.to_node = "device";
  edge.spec.to_port = "segment";
  plan.edges = {edge};
  LatencyHistogram wake, age;
  wake.record(Duration{90});
  wake.record(Duration{90});
  wake.record(Duration{12});
  age.record(Duration{101});
  EngineStatus status;
  DeviceStatus device;
  device.node = 1;
  device.wake_latency = metrics_of(wake, true);
  status.devices = {device};
  status.edges = {{{}, metrics_of(age, true)}};
  BOOST_TEST(latencies_csv(plan, status) ==
             "latency,us,count\n"
             "device.wakeup,0.012,1\n"
             "device.wakeup,0.090,2\n"
             "physics.out -> device.segment,0.101,1\n");
}

BOOST_AUTO_TEST_CASE(figures_that_are_not_whole_keep_no_counts) {
  LatencyHistogram h;
  h.record(Duration{90});
  BOOST_TEST(metrics_of(h, false).counts.empty());
  BOOST_TEST(metrics_of(h, false).count == 1U);
  BOOST_TEST(metrics_of(h, true).counts.size() == 1U);
}

BOOST_AUTO_TEST_SUITE_END()
