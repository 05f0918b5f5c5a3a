// What a device tells its gate: that it let go of a command, and that its handle is outside the workspace.
#include <boost/test/unit_test.hpp>
#include <cmath>

#include "tests/framework/realtime/gate_drive.hpp"

BOOST_AUTO_TEST_SUITE(gate_device_test)

using namespace tactor;
using tactor::test::Drive;
using tactor::test::ramp;

namespace {

bool is_zero(const Wrench& w) {
  return w.force == Vec3{} && w.torque == Vec3{};
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_command_that_has_expired_starts_from_zero_by_the_slew_limit_and_ends_nothing) {
  Drive drive(SafetyLimits{});
  drive.engage({{8, 0, 0}, {}});
  drive.input.expired = true;
  drive.tick();
  BOOST_TEST(std::abs(drive.output.commanded_D_W.force.x - 2) < 1e-12);  // 2000 N/s for 1 ms, from zero
  BOOST_TEST(drive.output.safety.engagement == Engagement::engaged);
  drive.input.expired = false;
  for (const double force : {4.0, 6.0, 8.0, 8.0}) {
    drive.tick();
    BOOST_TEST(std::abs(drive.output.commanded_D_W.force.x - force) < 1e-12);
  }
  BOOST_TEST(drive.gate.count(SafetyCause::expired) == 1U);
  // A release that had begun does not bring back what it released.
  drive.input.dead_man_held = false;
  drive.ticks(10);
  BOOST_TEST(drive.output.commanded_D_W.force.x > 5);
  drive.input.expired = true;
  for (int i = 0; i < 5; ++i) {
    drive.tick();
    drive.input.expired = false;
    BOOST_TEST(is_zero(drive.output.commanded_D_W));
  }
}

BOOST_AUTO_TEST_CASE(outside_the_workspace_the_force_goes_and_inside_it_comes_back_by_its_ramp) {
  Drive drive(SafetyLimits{});
  drive.engage({{8, 0, 0}, {}});
  drive.input.in_workspace = false;
  drive.ticks(50);
  BOOST_TEST(std::abs(drive.output.commanded_D_W.force.x - 8 * (1 - ramp(0.49))) < 0.2);
  BOOST_TEST(drive.output.safety.cause == SafetyCause::outside_workspace);
  drive.ticks(55);
  BOOST_TEST(is_zero(drive.output.commanded_D_W));
  drive.input.in_workspace = true;
  drive.ticks(50);
  BOOST_TEST(drive.output.safety.engagement == Engagement::ramping);
  drive.ticks(60);
  BOOST_TEST(drive.output.commanded_D_W.force.x == 8.0);
}

BOOST_AUTO_TEST_SUITE_END()
