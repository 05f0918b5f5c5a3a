// What encoders can show: jumps, encoders that stand still, and the geometry of sliding axes.
#include <boost/test/unit_test.hpp>

#include "devices/hardware/kinematics.hpp"
#include "devices/hardware/plausibility.hpp"
#include "devices/hardware/workspace.hpp"
#include "framework/core/check.hpp"

BOOST_AUTO_TEST_SUITE(plausibility_test)

using namespace tactor;
using Verdict = Plausibility::Verdict;

namespace {

constexpr std::int64_t ms = 1'000'000;

struct Judge {
  Plausibility plausibility;
  std::int64_t t = 0;
  explicit Judge(AxisLimits limits) : plausibility(limits) {}
  Verdict at(double q, double effort = 0, std::int64_t after_ms = 1) {
    t += after_ms * ms;
    LinkSample sample;
    sample.q = {q};
    return plausibility.judge(sample, {t}, {effort});
  }
};

AxisLimits one_axis() {
  AxisLimits limits;
  limits.axes = 1;
  limits.effort_max = {10};
  limits.speed_max = {2};
  limits.jump_tolerance = {1e-3};
  limits.stuck_after = Duration{100 * ms};
  return limits;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_position_that_has_jumped_is_not_believed_however_often_it_repeats) {
  Judge judge(one_axis());
  BOOST_CHECK(judge.at(0.05) == Verdict::good);
  BOOST_CHECK(judge.at(0.0529) == Verdict::good);  // 2 m/s in 1 ms and the tolerance of 1 mm: 3 mm
  BOOST_CHECK(judge.at(0.0560) == Verdict::jumped);
  BOOST_TEST(judge.plausibility.jumps() == 1U);
  BOOST_TEST(judge.plausibility.finding().from == 0.0529);
  BOOST_TEST(judge.plausibility.finding().to == 0.0560);
  Judge far(one_axis());
  far.at(0.0);
  for (int i = 0; i < 10'000; ++i) BOOST_CHECK(far.at(0.1) == Verdict::jumped);
  BOOST_TEST(far.plausibility.jumps() == 1U);
  Judge near(one_axis());
  near.at(0.0);
  for (int i = 0; i < 10'000; ++i) BOOST_CHECK(near.at(0.0031) == Verdict::jumped);
}

BOOST_AUTO_TEST_CASE(a_wild_value_passes_when_the_encoder_is_back_where_it_was) {
  Judge judge(one_axis());
  judge.at(0.05);
  BOOST_CHECK(judge.at(5) == Verdict::jumped);
  BOOST_CHECK(judge.at(0.0495) == Verdict::good);
  BOOST_CHECK(judge.at(0.0497) == Verdict::good);
}

BOOST_AUTO_TEST_CASE(not_a_number_is_a_jump) {
  Judge judge(one_axis());
  judge.at(0.05);
  BOOST_CHECK(judge.at(std::numeric_limits<double>::quiet_NaN()) == Verdict::jumped);
  BOOST_CHECK(judge.at(0.05) == Verdict::good);
}

BOOST_AUTO_TEST_CASE(after_a_gap_an_axis_may_be_as_far_as_its_speed_takes_it) {
  Judge judge(one_axis());
  judge.at(0.0);
  BOOST_CHECK(judge.at(0.2, 0, 100) == Verdict::good);
  BOOST_CHECK(judge.at(0.5, 0, 100) == Verdict::jumped);
}

BOOST_AUTO_TEST_CASE(an_encoder_that_stands_still_under_a_force_is_stuck_until_it_moves) {
  Judge judge(one_axis());
  for (int i = 0; i < 500; ++i) BOOST_CHECK(judge.at(0.05, 1.9) == Verdict::good);  // below a fifth of 10 N
  int good = 0;
  while (judge.at(0.05, 2) == Verdict::good) ++good;
  BOOST_TEST(good == 100);
  // Without a force it stays so, because nothing has shown that it moves.
  for (int i = 0; i < 500; ++i) BOOST_CHECK(judge.at(0.05, 0) == Verdict::stuck);
  BOOST_CHECK(judge.at(0.050001, 0) == Verdict::good);
  for (int i = 0; i < 500; ++i) BOOST_CHECK(judge.at(0.05 + 1e-6 * (i % 2), 5) == Verdict::good);
  BOOST_TEST(judge.plausibility.times_stuck() == 1U);
}

BOOST_AUTO_TEST_CASE(sliding_axes_take_the_part_of_a_force_along_them) {
  LinearKinematics one({{0, 0, -2}});
  Pose X_BD;
  BOOST_TEST(one.forward({0.03}, X_BD));
  BOOST_TEST(X_BD.p.z == -0.03);
  AxisValues effort;
  one.efforts({0.03}, {{1, 2, 3}, {}}, effort);
  BOOST_TEST(effort[0] == -3.0);
  BOOST_TEST(effort[1] == 0.0);
  BOOST_CHECK_THROW(LinearKinematics({}), InputError);
  BOOST_CHECK_THROW(LinearKinematics({{0, 0, 0}}), InputError);
  BOOST_CHECK_THROW(LinearKinematics({{1, 0, 0}, {1, 1, 0}}), InputError);
  BOOST_CHECK_THROW(LinearKinematics({{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}}), InputError);
}

BOOST_AUTO_TEST_CASE(a_workspace_keeps_the_power_where_both_scales_agree) {
  Workspace workspace{3, 3, from_rotation_vector({0.3, -0.8, 0.5}), {0.1, 0.2, 0.3}};
  const Pose a{{0.01, 0.02, -0.03}, {}}, b{{0.012, 0.019, -0.028}, {}};
  const Wrench F_W{{1, -2, 4}, {}};
  const double work_W = dot(F_W.force, workspace.to_scene(b).p - workspace.to_scene(a).p);
  const double work_B = dot(workspace.to_device(F_W).force, b.p - a.p);
  BOOST_TEST(std::abs(work_W - work_B) < 1e-15);
  BOOST_TEST(std::abs(work_W) > 1e-3);
}

BOOST_AUTO_TEST_SUITE_END()
