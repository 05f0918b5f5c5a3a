// Staircases against answers by hand and observers of known threshold; the order of trials and conditions.
#include <algorithm>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <map>
#include <set>

#include "nodes/experiment/observer.hpp"
#include "nodes/experiment/procedure.hpp"

BOOST_AUTO_TEST_SUITE(procedure_test)

using namespace tactor;

namespace {

constexpr double right_at_threshold(const Psychometric& observer) {
  return observer.shape == PsychometricShape::weibull ? 1 - 0.36787944117144233 : 0.5;
}

StaircaseDesign design(int down, double down_to_up, double last_step) {
  StaircaseDesign design;
  design.start = 0.5;
  design.steps = {std::max(1.6, last_step), std::max(1.3, last_step), last_step};
  design.scale = StepScale::factor;
  design.down = down;
  design.down_to_up = down_to_up;
  design.least = 0.005;
  design.most = 2;
  design.reversals = 44;
  design.averaged = 40;
  return design;
}

Psychometric observer(PsychometricShape shape) {
  return {shape, 0.2, 0.05, 3, 0};
}

struct Spread {
  double mean = 0, deviation = 0;
};

/// The thresholds of many staircases, each with a seed of its own.
Spread thresholds(const StaircaseDesign& design, const Psychometric& observer) {
  constexpr int runs = 600;
  double sum = 0, squares = 0;
  for (int run = 0; run < runs; ++run) {
    boost::random::mt19937_64 random(static_cast<std::uint64_t>(run) + 1);
    boost::random::uniform_real_distribution<double> chance(0, 1);
    Staircase staircase(design);
    while (!staircase.is_over()) staircase.answer(chance(random) < share_right(observer, staircase.level()));
    const double threshold = staircase.threshold().value();
    sum += threshold;
    squares += threshold * threshold;
  }
  const double mean = sum / runs;
  return {mean, std::sqrt(squares / runs - mean * mean)};
}

Design constant_design(std::size_t conditions) {
  Design design;
  design.procedure = Procedure::constant;
  design.conditions = conditions;
  design.levels = {0.1, 0.2, 0.4};
  design.repeats = 6;
  return design;
}

/// All trials, each answered by `interval`.
std::vector<Trial> trials_of(Schedule schedule, int interval = 0) {
  std::vector<Trial> trials;
  while (const Trial* trial = schedule.trial()) {
    trials.push_back(*trial);
    schedule.answer(interval);
  }
  return trials;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_staircase_falls_after_two_right_answers_and_rises_after_a_wrong_one) {
  StaircaseDesign d;
  d.start = 10;
  d.steps = {4, 2};
  d.down = 2;
  d.least = 1;
  d.most = 20;
  d.reversals = 4;
  d.averaged = 2;
  Staircase staircase(d);
  std::vector<double> levels;
  // Right, right: 6. Right, wrong: up at 6, the first reversal: 8. Right, right: down at 8: 6. Wrong: up at 6: 8.
  for (const bool right : {true, true, true, false, true, true, false, true, true}) {
    levels.push_back(staircase.level());
    BOOST_TEST(!staircase.is_over());
    staircase.answer(right);
  }
  BOOST_TEST(levels == (std::vector<double>{10, 10, 6, 6, 8, 8, 6, 8, 8}), boost::test_tools::per_element());
  BOOST_TEST(staircase.reversals() == (std::vector<double>{6, 8, 6, 8}), boost::test_tools::per_element());
  BOOST_TEST(staircase.is_over());
  BOOST_TEST(staircase.threshold().value() == 7);
}

BOOST_AUTO_TEST_CASE(a_factor_steps_by_its_power_and_stays_within_bounds) {
  StaircaseDesign d;
  d.start = 1;
  d.steps = {2};
  d.scale = StepScale::factor;
  d.down = 1;
  d.down_to_up = 0.5;
  d.least = 0.4;
  d.most = 3;
  d.reversals = 100;
  Staircase staircase(d);
  staircase.answer(true);
  BOOST_TEST(staircase.level() == std::sqrt(0.5), boost::test_tools::tolerance(1e-12));
  for (int i = 0; i < 4; ++i) staircase.answer(true);
  BOOST_TEST(staircase.level() == 0.4);
  for (int i = 0; i < 4; ++i) staircase.answer(false);
  BOOST_TEST(staircase.level() == 3);
}

BOOST_AUTO_TEST_CASE(the_observer_is_right_as_often_as_its_function_says) {
  for (const PsychometricShape shape : {PsychometricShape::weibull, PsychometricShape::logistic}) {
    Psychometric o = observer(shape);
    o.lapse = 0.04;
    BOOST_TEST(share_right(o, o.threshold) == 0.5 + 0.48 * right_at_threshold(o), boost::test_tools::tolerance(1e-12));
    for (const double p : {0.6, 0.75, 0.9}) {
      BOOST_TEST(share_right(o, level_at(o, p)) == p, boost::test_tools::tolerance(1e-12));
    }
    BOOST_TEST(share_right(o, 100) == 0.98, boost::test_tools::tolerance(1e-9));
  }
}

// Garcia-Perez (1998): with these ratios of a step down to a step up a staircase converges on these shares of right
// answers, whatever the size of the steps.
BOOST_AUTO_TEST_CASE(staircases_with_unequal_steps_find_the_threshold_at_any_step_size) {
  struct Rule {
    int down;
    double ratio, target;
  };
  for (const Rule& rule : {Rule{2, 0.5488, 0.8035}, Rule{3, 0.7393, 0.8315}, Rule{4, 0.8415, 0.8584}}) {
    for (const PsychometricShape shape : {PsychometricShape::weibull, PsychometricShape::logistic}) {
      for (const double step : {1.1, 1.25, 1.6}) {
        const double truth = level_at(observer(shape), rule.target);
        const Spread found = thresholds(design(rule.down, rule.ratio, step), observer(shape));
        BOOST_TEST(found.mean == truth, boost::test_tools::tolerance(0.03));
        BOOST_TEST(found.deviation > 0.04 * truth);
        BOOST_TEST(found.deviation < 0.1 * truth);
        BOOST_TEST_MESSAGE("1 up, " << rule.down << " down, steps of " << step << ": " << 100 * (found.mean / truth - 1)
                                    << " % off, single runs " << 100 * found.deviation / truth << " %");
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_short_staircase_is_right_in_the_mean_and_spreads_widely) {
  for (const int down : {2, 3, 4}) {
    const double ratio = down == 2 ? 0.5488 : down == 3 ? 0.7393 : 0.8415;
    const double target = down == 2 ? 0.8035 : down == 3 ? 0.8315 : 0.8584;
    StaircaseDesign d = design(down, ratio, 1.25);
    d.reversals = 12;
    d.averaged = 8;
    const double truth = level_at(observer(PsychometricShape::weibull), target);
    const Spread found = thresholds(d, observer(PsychometricShape::weibull));
    BOOST_TEST(found.mean == truth, boost::test_tools::tolerance(0.05));
    BOOST_TEST(found.deviation > 0.09 * truth);
    BOOST_TEST(found.deviation < 0.2 * truth);
    BOOST_TEST_MESSAGE("8 reversals, " << down << " down: " << 100 * (found.mean / truth - 1) << " % off, single runs "
                                       << 100 * found.deviation / truth << " %");
  }
}

// Levitt (1971): p^down = 1/2. It holds for small steps; coarse equal steps rest lower, by up to a fifth with two down.
BOOST_AUTO_TEST_CASE(staircases_with_equal_steps_find_the_threshold_where_steps_are_small) {
  BOOST_TEST(staircase_target(2) == 0.70710678, boost::test_tools::tolerance(1e-7));
  BOOST_TEST(staircase_target(3) == 0.79370053, boost::test_tools::tolerance(1e-7));
  for (const PsychometricShape shape : {PsychometricShape::weibull, PsychometricShape::logistic}) {
    for (const int down : {3, 4}) {
      for (const double step : {1.1, 1.2}) {
        const double truth = level_at(observer(shape), staircase_target(down));
        const Spread found = thresholds(design(down, 1, step), observer(shape));
        BOOST_TEST(found.mean == truth, boost::test_tools::tolerance(0.05));
        BOOST_TEST_MESSAGE("1 up, " << down << " down, equal steps of " << step << ": "
                                    << 100 * (found.mean / truth - 1) << " % off, single runs "
                                    << 100 * found.deviation / truth << " %");
      }
    }
    const double truth = level_at(observer(shape), staircase_target(2));
    const Spread coarse = thresholds(design(2, 1, 1.6), observer(shape));
    BOOST_TEST(coarse.mean < 0.92 * truth);
    BOOST_TEST(coarse.mean > 0.75 * truth);
  }
}

BOOST_AUTO_TEST_CASE(rows_of_the_square_balance_place_and_succession) {
  for (std::size_t n = 1; n <= 7; ++n) {
    const std::size_t rows = n % 2 == 0 ? n : 2 * n;
    for (const std::size_t first : {std::size_t{0}, std::size_t{3}}) {
      std::map<std::pair<std::size_t, std::size_t>, std::size_t> at, after;
      for (std::size_t row = first; row < first + rows; ++row) {
        const std::vector<std::size_t> order = balanced_row(n, row);
        BOOST_TEST(std::set<std::size_t>(order.begin(), order.end()).size() == n);
        for (std::size_t i = 0; i < n; ++i) {
          ++at[{i, order[i]}];
          if (i > 0) ++after[{order[i - 1], order[i]}];
        }
      }
      BOOST_TEST(at.size() == n * n);
      BOOST_TEST(after.size() == n * (n - 1));
      for (const auto& [where, count] : at) BOOST_TEST(count == rows / n);
      for (const auto& [pair, count] : after) BOOST_TEST(count == rows / n);
    }
  }
}

BOOST_AUTO_TEST_CASE(the_order_of_conditions_follows_from_the_seed_and_is_balanced_over_participants) {
  const Design design = constant_design(4);
  std::map<std::pair<std::size_t, std::size_t>, int> at;
  std::set<std::vector<std::size_t>> dealt;
  for (std::uint64_t study = 1; study <= 20; ++study) {
    for (std::uint64_t participant = 1; participant <= 4; ++participant) {
      const Schedule schedule(design, study, participant, 7 * participant);
      BOOST_TEST(schedule.order() == Schedule(design, study, participant, 99).order(),
                 boost::test_tools::per_element());
      if (study == 1) {
        for (std::size_t i = 0; i < 4; ++i) ++at[{i, schedule.order()[i]}];
      }
      if (participant == 1) dealt.insert(schedule.order());
    }
  }
  BOOST_TEST(at.size() == 16U);
  for (const auto& [where, count] : at) BOOST_TEST(count == 1);
  // Of 24 orders, 20 seeds deal most.
  BOOST_TEST(dealt.size() > 8U);
}

BOOST_AUTO_TEST_CASE(constant_stimuli_come_up_as_often_in_either_order_and_are_shuffled) {
  const Design design = constant_design(2);
  const std::vector<Trial> trials = trials_of(Schedule(design, 1, 1, 5));
  BOOST_TEST(trials.size() == 2U * 3U * 6U);
  std::map<std::tuple<std::size_t, double, int>, int> counts;
  for (const Trial& trial : trials) {
    ++counts[{trial.condition, trial.level, trial.comparison}];
    BOOST_TEST(trial.condition == trial.other);
  }
  BOOST_TEST(counts.size() == 12U);
  for (const auto& [what, count] : counts) BOOST_TEST(count == 3);
  BOOST_TEST((trials == trials_of(Schedule(design, 1, 1, 5))));
  BOOST_TEST((trials != trials_of(Schedule(design, 1, 1, 6))));
}

BOOST_AUTO_TEST_CASE(pairs_compare_all_conditions_as_often_in_either_order) {
  Design design;
  design.procedure = Procedure::pairs;
  design.conditions = 4;
  design.repeats = 4;
  std::map<std::tuple<std::size_t, std::size_t, int>, int> counts;
  for (const Trial& trial : trials_of(Schedule(design, 1, 1, 5))) {
    BOOST_TEST(trial.condition < trial.other);
    ++counts[{trial.condition, trial.other, trial.comparison}];
  }
  BOOST_TEST(counts.size() == 12U);
  for (const auto& [what, count] : counts) BOOST_TEST(count == 2);
}

BOOST_AUTO_TEST_CASE(a_staircase_runs_once_for_each_condition_and_progress_grows_to_one) {
  Design d;
  d.procedure = Procedure::staircase;
  d.conditions = 3;
  d.staircase = design(2, 1, 1.2);
  d.staircase.reversals = 6;
  d.staircase.averaged = 4;
  Schedule schedule(d, 1, 2, 3);
  boost::random::mt19937_64 random(4);
  boost::random::uniform_real_distribution<double> chance(0, 1);
  double before = 0;
  std::vector<std::size_t> seen;
  std::map<int, int> intervals;
  while (const Trial* trial = schedule.trial()) {
    if (seen.empty() || seen.back() != trial->condition) seen.push_back(trial->condition);
    ++intervals[trial->comparison];
    BOOST_TEST(schedule.progress() >= before);
    before = schedule.progress();
    const bool right = chance(random) < share_right(observer(PsychometricShape::weibull), trial->level);
    schedule.answer(right ? trial->comparison : 1 - trial->comparison);
  }
  BOOST_TEST(seen == schedule.order(), boost::test_tools::per_element());
  BOOST_TEST(schedule.progress() == 1);
  BOOST_TEST(std::min(intervals[0], intervals[1]) * 3 > std::max(intervals[0], intervals[1]));
}

BOOST_AUTO_TEST_SUITE_END()
