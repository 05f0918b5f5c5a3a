// For how long a fresh segment keeps the force, where its pipeline stands for it for less than the gate waits.
#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <limits>

#include "tests/framework/realtime/gate_drive.hpp"

BOOST_AUTO_TEST_SUITE(gate_freshness_test)

using namespace tactor;
using tactor::test::Drive;
using tactor::test::ramp;

namespace {

const Wrench push{{3, -4, 0}, {0, 0.12, 0.16}};  // 5 N, 0.2 N m

bool is_zero(const Wrench& w) {
  return w.force == Vec3{} && w.torque == Vec3{};
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_segment_may_stay_fresh_for_less_than_stale_after_and_never_for_more) {
  constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();
  constexpr std::int64_t least = std::numeric_limits<std::int64_t>::min();
  for (const std::int64_t fresh_for :
       {least, std::int64_t{-1}, std::int64_t{0}, std::int64_t{1}, std::int64_t{30'500'000}, std::int64_t{99'999'999},
        std::int64_t{100'000'001}, most - 1, most}) {
    Drive drive(SafetyLimits{});
    drive.engage(push);
    drive.input.fresh_for = {fresh_for};
    drive.tick();
    drive.input.fresh_segment = false;
    const double stale_at_ms = std::clamp(1e-6 * static_cast<double>(fresh_for), 0.0, 100.0);
    // Age zero was the tick of the segment itself.
    for (int age = 1; age <= 220; ++age) {
      drive.tick();
      const double left = 1 - ramp((age - stale_at_ms) / 100);
      BOOST_TEST(norm(drive.output.commanded_D_W.force - left * push.force) < 1e-12);
      BOOST_TEST(is_zero(drive.output.commanded_D_W) == (age >= stale_at_ms + 100));
    }
    BOOST_TEST(drive.gate.count(SafetyCause::stale) == 1U);
    // The next one stands for itself.
    drive.input.fresh_segment = true;
    drive.input.fresh_for = SafetyInput::longest;
    drive.ticks(102);
    drive.input.fresh_segment = false;
    drive.ticks(99);
    BOOST_TEST(norm(drive.output.commanded_D_W.force - push.force) < 1e-12);
  }
}

BOOST_AUTO_TEST_SUITE_END()
