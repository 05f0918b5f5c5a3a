// The judge of stability on signals whose energy, amplitude and frequency are known in closed form.
#include "framework/core/stability.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>

BOOST_AUTO_TEST_SUITE(stability_test)

using namespace tactor;

namespace {

constexpr double pi = std::numbers::pi;
constexpr double end = 4;         // s
constexpr double rest_begin = 2;  // s

/// The finding of a run at 1 kHz whose samples `at(t, dt)` gives, at rest from 2 s to 4 s.
StabilityFinding judged(const std::function<StabilitySample(double t, double dt)>& at, StabilityLimits limits = {}) {
  StabilityJudge judge(limits, {{.begin = rest_begin, .end = end, .p_WT = {}}});
  for (int i = 0; i <= 4000; ++i) judge.see(at(1e-3 * i, i == 0 ? 0 : 1e-3));
  return judge.finish();
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_decaying_oscillation_that_was_given_its_energy_at_the_start_is_stable) {
  // x = 10 mm exp(-10 t) cos(2 pi 5 t); the envelope of the energy of a spring of 100 N/m is given at the first step.
  const auto at = [](double t, double dt) {
    const double x = 0.01 * std::exp(-10 * t) * std::cos(2 * pi * 5 * t);
    const double energy = t > 0 ? 0.5 * 100 * 1e-4 * std::exp(-20 * t) : 0;
    return StabilitySample{.t = t, .p_WT = {x, 0, 0}, .stored = energy, .given = t > 0 && t < 1.5 * dt ? 0.005 : 0};
  };
  const StabilityFinding f = judged(at);
  BOOST_TEST(name_of(f.verdict) == "stable");
  BOOST_TEST(f.reason.empty());
  BOOST_TEST(std::abs(f.peak_energy_J - 0.005 * std::exp(-20 * 1e-3)) < 1e-12);
  BOOST_TEST(f.generated_J == 0.0);
  // Within the rest it starts with an amplitude of 10 mm exp(-20).
  BOOST_TEST(f.peak_to_peak_m < 2 * 0.01 * std::exp(-20.0));
  BOOST_TEST(!f.off_m.has_value());
}

BOOST_AUTO_TEST_CASE(a_sustained_sine_is_a_limit_cycle_with_its_amplitude_and_frequency) {
  for (const double hz : {3.0, 17.3, 90.0}) {
    const auto at = [hz](double t, double) {
      // The hand gives and takes as the energy goes, and the tool creeps by 1 um/s, which is no oscillation.
      return StabilitySample{.t = t, .p_WT = {1e-6 * t, 0.002 * std::sin(2 * pi * hz * t + 0.4), 0}};
    };
    const StabilityFinding f = judged(at);
    BOOST_TEST(name_of(f.verdict) == "limit_cycle");
    // A peak falls at most half a sample off.
    BOOST_TEST(f.amplitude_m <= 0.002 * (1 + 1e-12));
    BOOST_TEST(f.amplitude_m >= 0.002 * std::cos(pi * hz * 1e-3));
    BOOST_TEST(f.peak_to_peak_m == 2 * f.amplitude_m);
    BOOST_TEST(std::abs(f.frequency_Hz - hz) < 2e-3 * hz);
    BOOST_TEST(f.reason.find("Hz") != std::string::npos);
    BOOST_TEST(name_of(judged(at, {.peak_to_peak_max = 0.0041}).verdict) == "stable");
  }
}

BOOST_AUTO_TEST_CASE(a_swing_outside_of_the_rest_and_a_creep_within_are_none) {
  const auto at = [](double t, double) {
    return StabilitySample{.t = t, .p_WT = {t < rest_begin ? std::sin(20 * t) : 0.1 * (t - rest_begin), 0, 0}};
  };
  const StabilityFinding f = judged(at);
  BOOST_TEST(name_of(f.verdict) == "stable");
  BOOST_TEST(f.peak_to_peak_m == 0.0);
  BOOST_TEST(f.frequency_Hz == 0.0);
}

BOOST_AUTO_TEST_CASE(energy_that_grows_exponentially_without_being_given_is_from_nowhere) {
  const auto at = [](double t, double) { return StabilitySample{.t = t, .stored = 1e-3 * std::exp(2 * t)}; };
  const StabilityFinding f = judged(at);
  BOOST_TEST(name_of(f.verdict) == "energy");
  BOOST_TEST(std::abs(f.peak_energy_J - 1e-3 * std::exp(8.0)) < 1e-9);
  BOOST_TEST(std::abs(f.generated_J - 1e-3 * (std::exp(8.0) - 1)) < 1e-9);
  BOOST_TEST(f.reason.find("came from nowhere by 4 s") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(energy_that_was_given_is_not_from_nowhere) {
  // The same growth, of which the given share is put in: 95 % is within a tenth of what came in, 80 % is not.
  const auto with_share = [](double share) {
    return judged([share](double t, double dt) {
      const double grown = std::exp(2 * t) - std::exp(2 * (t - dt));
      return StabilitySample{.t = t, .stored = std::exp(2 * t), .given = share * grown};
    });
  };
  const StabilityFinding whole = with_share(1);
  BOOST_TEST(name_of(whole.verdict) == "stable");
  BOOST_TEST(whole.generated_J < 1e-9);
  const StabilityFinding most = with_share(0.95);
  BOOST_TEST(name_of(most.verdict) == "stable");
  BOOST_TEST(std::abs(most.generated_share - 0.05 / 0.95) < 1e-9);
  BOOST_TEST(std::abs(most.generated_J - 0.05 * (std::exp(8.0) - 1)) < 1e-6);
  BOOST_TEST(name_of(with_share(0.8).verdict) == "energy");
}

BOOST_AUTO_TEST_CASE(what_is_taken_out_beyond_what_was_stored_is_from_nowhere) {
  // A wall that gives back 1.5 times the 0.1 J that it got, and keeps nothing.
  const auto at = [](double t, double dt) {
    return StabilitySample{.t = t, .given = dt > 0 ? (t <= 2 ? 0.1 : -0.15) / 2000 : 0};
  };
  const StabilityFinding f = judged(at);
  BOOST_TEST(name_of(f.verdict) == "energy");
  BOOST_TEST(std::abs(f.generated_J - 0.05) < 1e-9);
  BOOST_TEST(std::abs(f.generated_share - 0.5) < 1e-9);
}

BOOST_AUTO_TEST_CASE(what_lay_in_the_contacts_may_come_out) {
  StabilityJudge judge({});
  judge.add_stored(2);
  judge.see({.t = 0, .stored = 1});
  judge.see({.t = 1, .stored = 3});
  const StabilityFinding f = judge.finish();
  BOOST_TEST(name_of(f.verdict) == "stable");
  BOOST_TEST(f.generated_J == 0.0);
}

BOOST_AUTO_TEST_CASE(a_tool_that_rests_elsewhere_was_pushed_through) {
  const StabilityRest rest{.begin = 0, .end = 1, .p_WT = Vec3{0, 0, 0.01}, .known = {0, 0, 1}, .tolerance = 1e-3};
  for (const double z : {0.0105, 0.02}) {
    StabilityJudge judge({}, {rest});
    for (int i = 0; i <= 100; ++i) judge.see({.t = 0.01 * i, .p_WT = {5, 5, z}});
    const StabilityFinding f = judge.finish();
    BOOST_TEST(name_of(f.verdict) == (z < 0.015 ? "stable" : "pushed_through"));
    BOOST_TEST(std::abs(f.off_m.value() - (z - 0.01)) < 1e-12);
  }
}

BOOST_AUTO_TEST_CASE(a_signal_that_is_not_finite_is_told_with_its_time) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const StabilitySample& bad :
       {StabilitySample{.t = 2, .p_WT = {0, nan, 0}}, StabilitySample{.t = 2, .stored = infinity},
        StabilitySample{.t = 2, .given = nan}, StabilitySample{.t = 2, .finite = false}}) {
    StabilityJudge judge({});
    BOOST_TEST(judge.see({.t = 1, .stored = 1}));
    BOOST_TEST(!judge.see(bad));
    BOOST_TEST(!judge.see({.t = 3}));
    const StabilityFinding f = judge.finish();
    BOOST_TEST(name_of(f.verdict) == "not_finite");
    BOOST_TEST(f.reason.find("at 2 s") != std::string::npos);
    BOOST_TEST(std::isfinite(f.peak_energy_J));
    BOOST_TEST(std::isfinite(f.generated_J));
  }
}

BOOST_AUTO_TEST_CASE(a_run_that_ended_early_is_refused_with_its_reason) {
  StabilityJudge judge({});
  judge.see({.t = 0});
  judge.refuse("the step of node dynamics could not be solved");
  const StabilityFinding f = judge.finish();
  BOOST_TEST(name_of(f.verdict) == "refused");
  BOOST_TEST(f.reason == "the step of node dynamics could not be solved");
}

BOOST_AUTO_TEST_CASE(a_sequence_without_a_whole_period_has_no_frequency) {
  std::vector<double> t, x;
  for (int i = 0; i < 100; ++i) t.push_back(0.01 * i), x.push_back(t.back() * t.back());
  BOOST_TEST(oscillation_frequency(t, x) == 0.0);
  BOOST_TEST(oscillation_frequency({}, {}) == 0.0);
}

BOOST_AUTO_TEST_SUITE_END()
