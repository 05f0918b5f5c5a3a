// The greedy search for the cheapest state that keeps a budget of error: one move at a time, the best saving first.
#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "app/statistics.hpp"

namespace tactor {

/// What a state costs, and how far it is from the reference.
struct LeanMetrics {
  double cost = 0;          ///< us of CPU time a simulated second, the median of the repeats
  double error = 0;         ///< N, RMS
  double max_error = 0;     ///< N
  double torque_error = 0;  ///< N m, RMS; zero where the original knows no torque
  std::string refused;      ///< why the state cannot be run, or empty
  /// The cost of each repeat, in their order; none where a single look was enough.
  std::vector<double> repeats = {};
};

/// A state and the one before it, measured side by side: repeat i of the one next to repeat i of the other.
struct LeanPair {
  LeanMetrics before, after;

  /// The share of the cost before that is saved, by repeat; of the costs where nothing was repeated.
  [[nodiscard]] std::vector<double> savings() const {
    std::vector<double> found;
    for (std::size_t i = 0; i < std::min(before.repeats.size(), after.repeats.size()); ++i) {
      found.push_back(1 - after.repeats[i] / before.repeats[i]);
    }
    if (found.empty()) found.push_back(1 - after.cost / before.cost);
    return found;
  }
};

struct LeanLimits {
  double error = 0;          ///< N
  double torque_error = 0;   ///< N m
  double min_saving = 0.02;  ///< share of the cost; less is within what times of runs differ by

  [[nodiscard]] bool keep(const LeanMetrics& f) const { return f.error <= error && f.torque_error <= torque_error; }
};

/// Something to leave out or to coarsen.
template <class State>
struct LeanMove {
  std::string group;        ///< of values that go from fine to coarse: `collision.spacing`
  std::string what;         ///< `collision.spacing: 0 -> 0.001`
  bool leaves_out = false;  ///< it makes the graph smaller, so that it is taken even where it saves nothing
  State state;              ///< after the move
};

enum class LeanOutcome {
  taken,
  possible,     ///< it keeps the budget and saves less than the one that was taken
  over_budget,  ///< beyond the budget: neither it nor what lies beyond it is tried again
  no_saving,    ///< the budget is kept, and nothing is saved
  refused,      ///< the graph cannot be run so
};

/// A move that was measured.
struct LeanTrial {
  int round = 0;
  std::string group, what;
  LeanPair metrics;
  double saving = 0;  ///< share of the cost before, the median of the repeats
  LeanOutcome outcome = LeanOutcome::refused;
};

/// A move that was taken.
template <class State>
struct LeanStep {
  std::string what;
  State state;
  LeanPair metrics;
  double saving = 0;
};

template <class State>
struct LeanPath {
  LeanMetrics start;
  std::vector<LeanStep<State>> steps;
  std::vector<LeanTrial> trials;  ///< all that was measured, in order
};

/// Takes, as long as there is one, the move with the largest saving of those that keep the limits and save: at least
/// `min_saving` in the median of the repeats, and something in each, in two looks. One that leaves something out is
/// taken in any case, after those that save more. `moves(state)` gives the moves of a state, those of a group one after
/// the other from fine to coarse. `compare(before, move)` measures the state after the move beside the one before it;
/// where the one after it is over the limits only its errors count. A group ends at the first of its moves that is over
/// the budget, for good. A move that saved nothing is measured again when nothing else is left to take, because its
/// share has grown by then. The start must keep the limits.
template <class State>
class LeanSearch {
 public:
  using Moves = std::function<std::vector<LeanMove<State>>(const State&)>;
  using Compare = std::function<LeanPair(const State& before, const LeanMove<State>& move)>;

  LeanSearch(const LeanLimits& limits, Moves moves, Compare compare)
      : limits_(limits), moves_(std::move(moves)), compare_(std::move(compare)) {}

  /// `start`: the metrics of the state.
  LeanPath<State> run(State state, LeanMetrics start) {
    path_.start = std::move(start);
    for (;;) {
      std::optional<Candidate> best = look(state);
      if (!best && !saved_nothing_.empty()) {
        saved_nothing_.clear();
        best = look(state);
      }
      if (!best) return std::move(path_);
      LeanTrial& taken = path_.trials[best->trial];
      taken.outcome = LeanOutcome::taken;
      path_.steps.push_back({best->move.what, best->move.state, taken.metrics, taken.saving});
      state = std::move(best->move.state);
    }
  }

 private:
  /// A move that may be taken, and the index of its trial.
  struct Candidate {
    LeanMove<State> move;
    std::size_t trial;
  };

  /// Measures the moves of a state and gives the best of those that may be taken, after another look at it: of many
  /// looks the best one flatters.
  std::optional<Candidate> look(const State& state) {
    ++round_;
    std::vector<Candidate> candidates;
    std::string ended;  // the group that is over the budget from here on
    for (LeanMove<State>& move : moves_(state)) {
      if (over_.contains(move.what)) ended = move.group;
      if (move.group == ended || saved_nothing_.contains(move.what)) continue;
      const LeanTrial& trial = try_out(move, state);
      if (trial.outcome == LeanOutcome::over_budget) ended = move.group;
      if (trial.outcome == LeanOutcome::possible) candidates.push_back({std::move(move), path_.trials.size() - 1});
    }
    while (!candidates.empty()) {
      const auto best = best_of(candidates);
      if (try_out(best->move, state).outcome == LeanOutcome::possible) {
        return Candidate{std::move(best->move), path_.trials.size() - 1};
      }
      candidates.erase(best);
    }
    return std::nullopt;
  }

  auto best_of(std::vector<Candidate>& candidates) const {
    auto best = candidates.begin();
    for (auto c = candidates.begin() + 1; c != candidates.end(); ++c) {
      // Of values of one parameter the finer one, unless the coarser saves more than times differ by.
      const double margin = best->move.group == c->move.group ? limits_.min_saving : 0;
      if (path_.trials[c->trial].saving > path_.trials[best->trial].saving + margin) best = c;
    }
    return best;
  }

  const LeanTrial& try_out(const LeanMove<State>& move, const State& before) {
    LeanTrial trial{.round = round_, .group = move.group, .what = move.what, .metrics = compare_(before, move)};
    if (trial.metrics.after.refused.empty()) judge(trial, move.leaves_out);
    path_.trials.push_back(std::move(trial));
    return path_.trials.back();
  }

  void judge(LeanTrial& trial, bool leaves_out) {
    if (!limits_.keep(trial.metrics.after)) {
      trial.outcome = LeanOutcome::over_budget;
      over_.insert(trial.what);
      return;
    }
    const std::vector<double> savings = trial.metrics.savings();
    trial.saving = median(savings);
    const bool saves = trial.saving >= limits_.min_saving && *std::min_element(savings.begin(), savings.end()) > 0;
    trial.outcome = saves || leaves_out ? LeanOutcome::possible : LeanOutcome::no_saving;
    if (trial.outcome == LeanOutcome::no_saving) saved_nothing_.insert(trial.what);
  }

  LeanLimits limits_;
  Moves moves_;
  Compare compare_;
  LeanPath<State> path_;
  std::set<std::string> over_, saved_nothing_;  // by what
  int round_ = 0;
};

}  // namespace tactor
