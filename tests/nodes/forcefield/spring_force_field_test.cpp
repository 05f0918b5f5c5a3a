// forcefield.spring: the force of a spring and a damper at the newest sample, on one side or both, and what it keeps
// out.
#include <boost/test/unit_test.hpp>
#include <limits>

#include "framework/core/segment.hpp"
#include "framework/realtime/allocation_watch.hpp"
#include "nodes/forcefield/spring.hpp"
#include "tests/nodes/forcefield/field_scenes.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(spring_force_field_test)

using namespace tactor;
using namespace tactor::test;

namespace {

SpringForceField::Params spring_params(SpringForceField::Sides sides, double damping) {
  auto p = default_params<SpringForceField>();
  p.stiffness = 2000;
  p.damping = damping;
  p.sides = sides;
  p.position = 1e-3;
  return p;
}

struct SpringRig : FieldRig<SpringForceField> {
  using FieldRig::FieldRig;
  /// The force at `axis` that is shown of a handle at `x` m with the velocity `v` as the device estimates it.
  double force(double ms, double x, double v = 0, int axis = 2) {
    DeviceState state;
    state.X_WD.p[axis] = x;
    state.V_WD.v[axis] = v;
    node.device.push(stamp_ms(ms), &state);
    BOOST_REQUIRE(step(ms));
    node.force.clear_pending();
    BOOST_TEST((last.stamp.valid == stamp_ms(ms).valid));
    Vec3 aside = shown();
    const double along = std::exchange(aside[axis], 0);
    BOOST_TEST((aside == Vec3{}));
    return along;
  }
  [[nodiscard]] bool takes(double ms, const DeviceState& state) {
    node.device.push(stamp_ms(ms), &state);
    return step(ms);
  }
};

constexpr double tiny = 1e-12;

}  // namespace

BOOST_AUTO_TEST_CASE(two_sided_it_pulls_towards_its_place_from_both_sides) {
  SpringRig rig(spring_params(SpringForceField::Sides::two, 0));
  BOOST_TEST(std::abs(rig.force(0, 3e-3) + 4) < tiny);
  BOOST_TEST(std::abs(rig.force(1, -1e-3) - 4) < tiny);
  BOOST_TEST(rig.force(2, 1e-3) == 0.0);
}

BOOST_AUTO_TEST_CASE(one_sided_it_pushes_out_of_the_wall_and_never_pulls) {
  SpringRig rig(spring_params(SpringForceField::Sides::one, 5));
  BOOST_TEST(rig.force(0, 3e-3) == 0.0);
  // 2 mm deep, and 4 mm in a millisecond on the way in.
  BOOST_TEST(std::abs(rig.force(1, -1e-3) - (4 + 5 * 4)) < tiny);
  BOOST_TEST(std::abs(rig.force(2, -1e-3) - 4) < tiny);
  // On the way out by 1 mm in a millisecond, the damper would pull with 3 N.
  BOOST_TEST(rig.force(3, 0) == 0.0);
  BOOST_TEST(rig.force(4, 1e-3) == 0.0);
}

BOOST_AUTO_TEST_CASE(the_damper_takes_the_difference_of_positions_by_the_time_between_or_the_velocity_of_the_device) {
  auto params = spring_params(SpringForceField::Sides::two, 3);
  SpringRig difference(params);
  BOOST_TEST(difference.force(0, 1e-3, 0.7) == 0.0);
  BOOST_TEST(std::abs(difference.force(2, 2e-3, 0.7) - (-2 - 3 * 0.5)) < tiny);
  params.velocity = SpringForceField::Velocity::device;
  SpringRig shown(params);
  BOOST_TEST(std::abs(shown.force(0, 1e-3, 0.7) + 3 * 0.7) < tiny);
}

BOOST_AUTO_TEST_CASE(it_acts_along_its_axis_alone) {
  auto params = spring_params(SpringForceField::Sides::two, 0);
  params.axis = SpringForceField::AxisName::x;
  SpringRig rig(params);
  BOOST_TEST(std::abs(rig.force(0, 2e-3, 0, 0) + 2) < tiny);
}

BOOST_AUTO_TEST_CASE(samples_that_are_not_finite_or_not_later_show_nothing_new_and_are_counted) {
  SpringRig rig(spring_params(SpringForceField::Sides::two, 1));
  rig.force(1, 2e-3);
  DeviceState bad;
  bad.X_WD.p.z = std::numeric_limits<double>::quiet_NaN();
  BOOST_TEST(!rig.takes(2, bad));
  bad = {};
  bad.V_WD.v.z = std::numeric_limits<double>::infinity();
  BOOST_TEST(!rig.takes(3, bad));
  BOOST_TEST(!rig.takes(0.5, {}));
  const Report report = report_of(rig.node);
  BOOST_TEST(report.metrics().front().second == 3.0);
  // The next good one has its difference from the last good one.
  BOOST_TEST(std::abs(rig.force(5, 2e-3) + 2) < tiny);
}

BOOST_AUTO_TEST_CASE(without_a_new_sample_it_shows_nothing_new) {
  SpringRig rig(spring_params(SpringForceField::Sides::two, 1));
  rig.force(1, 2e-3);
  BOOST_TEST(!rig.step(2));
  BOOST_TEST(report_of(rig.node).metrics().front().second == 0.0);
}

BOOST_AUTO_TEST_CASE(no_step_calls_the_heap, *boost::unit_test::precondition(tactor::test::heap_is_counted)) {
  SpringRig rig(spring_params(SpringForceField::Sides::one, 1));
  rig.force(0, 2e-3);
  DeviceState state;
  std::int64_t calls = 0;
  for (int i = 1; i < 100; ++i) {
    state.X_WD.p.z = 1e-5 * i;
    const Stamp stamp = stamp_ms(i);
    rig.node.device.push(stamp, &state);
    StepContext context(stamp.valid);
    const std::int64_t before = thread_heap_calls();
    rig.node.step(context);
    calls += thread_heap_calls() - before;
    rig.node.segment.clear_pending();
    rig.node.force.clear_pending();
  }
  BOOST_TEST(calls == 0);
}

BOOST_AUTO_TEST_SUITE_END()
