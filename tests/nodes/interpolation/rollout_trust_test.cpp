// A result of any time is compared with what the rollout did then, be it between two samples of the handle.
#include <boost/test/unit_test.hpp>

#include <cmath>

#include "nodes/interpolation/rollout_trust.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(rollout_trust_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

constexpr TrustOptions options{.trust_time = Duration{250'000'000},
                               .trust_time_max = Duration{1'000'000'000},
                               .trust_distance = 0.02,
                               .disagreement = 5e-4,
                               .patience = Duration{1'000'000'000},
                               .estimate_time = Duration{1'000'000'000},
                               .worse = 1.2};

Vec3 tool_at(double ms) {
  return {1e-3 * ms, 0.1, 0};
}
RolloutTrust::Forces forces_at(double ms) {
  return {Vec3{0.1 * ms, 0, 0}, Vec3{0, 0.2 * ms, 0}, Vec3{0, 0, 1}};
}

/// Has been through the samples of 10 to 20 ms; its tool and its forces go along straight lines.
RolloutTrust rolled() {
  RolloutTrust trust(options);
  for (int ms = 10; ms <= 20; ++ms) trust.note(at_ms(ms), tool_at(ms), forces_at(ms));
  return trust;
}

Stamped<LocalModel> result(double ms, const Vec3& p_WT, const Vec3& force) {
  Stamped<LocalModel> model{stamp_ms(ms), {}};
  model.value.p_WT_result = p_WT;
  model.value.wrench_result.force = force;
  return model;
}

/// The rollout's error after that one result.
double error_after(const Stamped<LocalModel>& model) {
  RolloutTrust trust = rolled();
  trust.learn(model, Duration{10'000'000});
  return trust.error(RolloutTrust::rolled);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_result_of_a_sample_is_compared_with_that_sample_alone) {
  BOOST_TEST(error_after(result(13, tool_at(13), forces_at(13)[0])) == 0.0);
  BOOST_TEST(error_after(result(13, tool_at(13), forces_at(13)[0] + Vec3{0, 0, 0.3})) == 0.3);
}

BOOST_AUTO_TEST_CASE(a_result_between_two_samples_is_compared_with_what_lies_between_them) {
  const Vec3 there = forces_at(13.25)[0];
  BOOST_TEST(error_after(result(13.25, tool_at(13.25), there)) < 1e-12);
  BOOST_TEST(error_after(result(13.25, tool_at(13.25), there + Vec3{0, 0.3, 0})) == 0.3, tt::tolerance(1e-9));
  RolloutTrust trust = rolled();
  trust.learn(result(13.25, tool_at(13.25), there), Duration{10'000'000});
  // The hold of that time was as far away as this.
  BOOST_TEST(trust.error(RolloutTrust::held_result) == std::hypot(1.325, 2.65), tt::tolerance(1e-9));
}

BOOST_AUTO_TEST_CASE(a_tool_between_two_samples_is_compared_too) {
  RolloutTrust trust = rolled();
  BOOST_TEST(!trust.disagrees(result(13.25, tool_at(13.25), {})));
  BOOST_TEST(trust.disagrees(result(13.5, tool_at(13.5) + Vec3{0, 0.03, 0}, {})));
  BOOST_TEST(trust.disagreements() == 1);
}

BOOST_AUTO_TEST_CASE(nothing_is_known_before_the_first_sample_and_after_the_last) {
  for (const double ms : {9.75, 20.25}) {
    BOOST_TEST(error_after(result(ms, {}, {5, 0, 0})) == 0.0);
    RolloutTrust trust = rolled();
    BOOST_TEST(!trust.disagrees(result(ms, {1, 0, 0}, {})));
  }
}

BOOST_AUTO_TEST_SUITE_END()
