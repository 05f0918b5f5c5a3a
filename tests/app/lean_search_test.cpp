// The greedy search on made-up costs and errors, whose best result is known in closed form.
#include "app/lean/lean_search.hpp"

#include <array>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

BOOST_AUTO_TEST_SUITE(lean_search_test)

using namespace tactor;

namespace {

/// How far each of three knobs is turned.
using State = std::array<int, 3>;

std::string name(std::size_t knob, int value) {
  return std::string(1, static_cast<char>('a' + knob)) + std::to_string(value);
}

/// Every knob to every value beyond its own, up to `most`.
std::vector<LeanMove<State>> knobs(const State& state, int most, bool leaves_out = false) {
  std::vector<LeanMove<State>> moves;
  for (std::size_t k = 0; k < state.size(); ++k) {
    for (int value = state[k] + 1; value <= most; ++value) {
      LeanMove<State> move{.group = std::string(1, static_cast<char>('a' + k)),
                           .what = name(k, value),
                           .leaves_out = leaves_out,
                           .state = state};
      move.state[k] = value;
      moves.push_back(move);
    }
  }
  return moves;
}

LeanPath<State> search(const LeanLimits& limits, LeanSearch<State>::Moves moves,
                       const std::function<LeanMetrics(const State&)>& metrics, int* compared = nullptr) {
  const auto compare = [&](const State& before, const LeanMove<State>& move) {
    if (compared != nullptr) ++*compared;
    return LeanPair{metrics(before), metrics(move.state)};
  };
  return LeanSearch<State>(limits, std::move(moves), compare).run({0, 0, 0}, metrics({0, 0, 0}));
}

std::vector<std::string> taken(const LeanPath<State>& path) {
  std::vector<std::string> steps;
  for (const auto& step : path.steps) steps.push_back(step.what);
  return steps;
}

/// Every turn of a knob takes its cost off and adds its error: what is best follows from the sums.
LeanMetrics separable(const State& s) {
  const std::array<double, 3> saves{10, 20, 5}, errs{1, 4, 0.1};
  LeanMetrics f{.cost = 200};
  for (std::size_t k = 0; k < 3; ++k) {
    f.cost -= saves[k] * s[k];
    f.error += errs[k] * s[k];
  }
  f.max_error = 2 * f.error;
  return f;
}

using Names = std::vector<std::string>;

}  // namespace

BOOST_AUTO_TEST_CASE(the_largest_saving_that_keeps_the_budget_comes_first) {
  // b3 would save most and errs by 12, b2 by 8: of what a budget of 10 leaves b2 saves 40, then a (2 left) 20 by a2,
  // and c would err by 10.1, so that nothing else fits.
  const auto path = search(
      {.error = 10}, [](const State& s) { return knobs(s, 3); }, separable);
  BOOST_TEST(taken(path) == (Names{"b2", "a2"}), boost::test_tools::per_element());
  BOOST_TEST(path.steps.back().metrics.after.cost == 200.0 - 40 - 20);
  BOOST_TEST(path.steps.back().metrics.after.error == 10.0);
  BOOST_TEST(path.start.cost == 200.0);
}

BOOST_AUTO_TEST_CASE(all_is_taken_where_the_budget_allows_it_and_nothing_where_it_allows_none) {
  const auto all = search(
      {.error = 100}, [](const State& s) { return knobs(s, 3); }, separable);
  BOOST_TEST((all.steps.back().state == State{3, 3, 3}));
  const auto none = search(
      {.error = 0}, [](const State& s) { return knobs(s, 3); }, separable);
  BOOST_TEST(none.steps.empty());
  for (const LeanTrial& trial : none.trials) BOOST_TEST((trial.outcome == LeanOutcome::over_budget));
  // A group ends at its first value over the budget.
  BOOST_TEST(none.trials.size() == 3U);
}

BOOST_AUTO_TEST_CASE(no_step_is_ever_over_a_budget_whatever_the_errors_do) {
  // Errors that depend on each other: a and b together err far more than alone.
  const auto metrics = [](const State& s) {
    return LeanMetrics{.cost = 100.0 - 10 * s[0] - 9 * s[1] - 8 * s[2],
                       .error = 0.1 * s[0] + 0.1 * s[1] + 0.3 * s[2] + 3.0 * s[0] * s[1],
                       .torque_error = 0.01 * s[2]};
  };
  const LeanLimits limits{.error = 1, .torque_error = 0.02};
  const auto path = search(
      limits, [](const State& s) { return knobs(s, 3); }, metrics);
  for (const auto& step : path.steps) BOOST_TEST(limits.keep(step.metrics.after));
  // The first is a3 (30 of 100; b3 27, c2 16); then b is over, and c2 keeps both budgets.
  BOOST_TEST(taken(path) == (Names{"a3", "c2"}), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(what_saves_less_than_times_differ_by_is_not_coarsened_but_it_is_left_out) {
  const auto metrics = [](const State& s) { return LeanMetrics{.cost = 100.0 - 0.5 * s[0] + 1.5 * s[1] + 5.0 * s[2]}; };
  BOOST_TEST(search(
                 {.error = 1}, [](const State& s) { return knobs(s, 1); }, metrics)
                 .steps.empty());
  // What is left out seems to save 0.5 %, or to cost 1.5 % or 5 % more.
  const auto path = search(
      {.error = 1}, [](const State& s) { return knobs(s, 1, true); }, metrics);
  BOOST_TEST(taken(path) == (Names{"a1", "b1", "c1"}), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(the_finer_of_two_values_that_save_the_same_is_taken) {
  const auto metrics = [](const State& s) { return LeanMetrics{.cost = s[0] == 0 ? 100.0 : 50 - 0.1 * s[0]}; };
  const auto path = search(
      {.error = 1}, [](const State& s) { return knobs(s, 3); }, metrics);
  BOOST_TEST(taken(path) == (Names{"a1"}), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(what_cannot_be_run_is_tried_again_after_another_step) {
  const auto metrics = [](const State& s) {
    LeanMetrics f{.cost = 100.0 - 50 * s[0] - 40 * s[1]};
    if (s[1] > 0 && s[0] == 0) f.refused = "b needs a";
    return f;
  };
  const auto path = search(
      {.error = 1}, [](const State& s) { return knobs(s, 1); }, metrics);
  BOOST_TEST(taken(path) == (Names{"a1", "b1"}), boost::test_tools::per_element());
  BOOST_TEST(path.trials[1].metrics.after.refused == "b needs a");
  BOOST_TEST((path.trials[1].outcome == LeanOutcome::refused));
}

BOOST_AUTO_TEST_CASE(what_saved_nothing_is_measured_again_when_it_may_save_a_larger_share) {
  // c saves 1 of 100, which is too little, and 1 of 10 after a.
  const auto metrics = [](const State& s) { return LeanMetrics{.cost = 100.0 - 90 * s[0] - s[2]}; };
  int compared = 0;
  const auto path = search(
      {.error = 1}, [](const State& s) { return knobs(s, 1); }, metrics, &compared);
  BOOST_TEST(taken(path) == (Names{"a1", "c1"}), boost::test_tools::per_element());
  BOOST_TEST(compared < 20);
}

BOOST_AUTO_TEST_CASE(a_saving_counts_where_every_repeat_has_it_by_the_median_of_the_repeats) {
  // a saves 0.1, 0.2 and 0.5 of what the state before it cost at the same time, on a machine that gets slower: 0.2.
  // b saves 0.5 twice and nothing once, c 0.01 every time.
  const std::map<std::string, std::array<double, 3>> after{
      {"a", {90, 160, 150}}, {"b", {50, 100, 301}}, {"c", {99, 198, 297}}};
  const auto compare = [&](const State& before, const LeanMove<State>& move) {
    const State& state = move.state;
    LeanPair pair{{.cost = 200, .repeats = {100, 200, 300}}, {.cost = 1}};
    for (std::size_t k = 0; k < state.size(); ++k) {
      if (state[k] == before[k]) continue;
      const auto& costs = after.at(std::string(1, static_cast<char>('a' + k)));
      pair.after.repeats.assign(costs.begin(), costs.end());
    }
    return pair;
  };
  const auto path = LeanSearch<State>(
                        {.error = 1}, [](const State& s) { return knobs(s, 1); }, compare)
                        .run({0, 0, 0}, {.cost = 200});
  BOOST_TEST(taken(path) == (Names{"a1"}), boost::test_tools::per_element());
  BOOST_TEST(std::abs(path.steps.front().saving - 0.2) < 1e-12);
  BOOST_TEST((path.trials[1].outcome == LeanOutcome::no_saving));
  BOOST_TEST((path.trials[2].outcome == LeanOutcome::no_saving));
}

BOOST_AUTO_TEST_CASE(a_saving_that_another_look_does_not_find_is_none) {
  // a seems to save half the first time it is looked at, b saves a tenth whenever it is.
  int looks_at_a = 0;
  const auto compare = [&](const State& before, const LeanMove<State>& move) {
    const State& state = move.state;
    LeanPair pair{{.cost = 100}, {.cost = state[1] > before[1] ? 90.0 : 100.0}};
    if (state[0] > before[0] && looks_at_a++ == 0) pair.after.cost = 50;
    return pair;
  };
  const auto two = [](const State& s) {
    auto moves = knobs(s, 1);
    std::erase_if(moves, [](const LeanMove<State>& move) { return move.group == "c"; });
    return moves;
  };
  const auto path = LeanSearch<State>({.error = 1}, two, compare).run({0, 0, 0}, {.cost = 100});
  BOOST_TEST(taken(path) == (Names{"b1"}), boost::test_tools::per_element());
  BOOST_TEST(looks_at_a >= 2);
}

BOOST_AUTO_TEST_SUITE_END()
