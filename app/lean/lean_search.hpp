// The greedy search for the cheapest state that keeps a budget of error: one move at a time, the best saving first.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace tactor {

/// What a state costs and how far it is from the reference.
struct LeanFigures {
  double cost = 0;          ///< us of CPU time a simulated second
  double error = 0;         ///< N, RMS
  double max_error = 0;     ///< N
  double torque_error = 0;  ///< N m, RMS; zero where the original knows no torque
  std::string refused;      ///< why the state cannot be run, or empty
};

struct LeanLimits {
  double error = 0;          ///< N
  double torque_error = 0;   ///< N m
  double min_saving = 0.02;  ///< share of the cost; less is within what times of runs differ by

  [[nodiscard]] bool keep(const LeanFigures& f) const { return f.error <= error && f.torque_error <= torque_error; }
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
  LeanFigures figures;
  double saving = 0;  ///< share of the cost before
  LeanOutcome outcome = LeanOutcome::refused;
};

/// A move that was taken.
template <class State>
struct LeanStep {
  std::string what;
  State state;
  LeanFigures before, after;
};

template <class State>
struct LeanPath {
  LeanFigures start;
  std::vector<LeanStep<State>> steps;
  std::vector<LeanTrial> trials;  ///< all that was measured, in order
};

/// Takes, as long as there is one, the move with the largest saving of those that keep the limits and save at least
/// `min_saving`; one that leaves something out is taken in any case, after those that save more. `moves(state)` gives
/// the moves of a state, those of a group one after the other from fine to coarse. `measure(state, worth)` gives its
/// figures; of a state whose cost seems to be above `worth` the cost need not be exact. A group ends at the first of
/// its moves that is over the budget, for good. A move that saved nothing is measured again when nothing else is left
/// to take, because its share has grown by then. The start must keep the limits.
template <class State>
class LeanSearch {
 public:
  using Moves = std::function<std::vector<LeanMove<State>>(const State&)>;
  using Measure = std::function<LeanFigures(const State&, std::optional<double> worth)>;

  LeanSearch(const LeanLimits& limits, Moves moves, Measure measure)
      : limits_(limits), moves_(std::move(moves)), measure_(std::move(measure)) {}

  LeanPath<State> run(State state) {
    path_.start = measure_(state, std::nullopt);
    LeanFigures before = path_.start;
    for (;;) {
      std::optional<LeanMove<State>> best = look(state, before);
      if (!best && !saved_nothing_.empty()) {
        saved_nothing_.clear();
        best = look(state, before);
      }
      if (!best) return std::move(path_);
      LeanTrial& taken = path_.trials[*best_];
      taken.outcome = LeanOutcome::taken;
      path_.steps.push_back({best->what, best->state, before, taken.figures});
      state = std::move(best->state);
      before = measure_(state, std::nullopt);
    }
  }

 private:
  /// Measures the moves of a state and gives the best of those that may be taken.
  std::optional<LeanMove<State>> look(const State& state, const LeanFigures& before) {
    ++round_;
    best_.reset();
    std::optional<LeanMove<State>> best;
    std::string ended;  // the group that is over the budget from here on
    for (LeanMove<State>& move : moves_(state)) {
      if (over_.contains(move.what)) ended = move.group;
      if (move.group == ended || saved_nothing_.contains(move.what)) continue;
      const LeanTrial& trial = try_out(move, before);
      if (trial.outcome == LeanOutcome::over_budget) ended = move.group;
      if (trial.outcome != LeanOutcome::possible) continue;
      // Of values of one parameter the finer one, unless the coarser saves more than times differ by.
      const double margin = best && best->group == move.group ? limits_.min_saving : 0;
      if (best && trial.saving <= path_.trials[*best_].saving + margin) continue;
      best_ = path_.trials.size() - 1;
      best = std::move(move);
    }
    return best;
  }

  const LeanTrial& try_out(const LeanMove<State>& move, const LeanFigures& before) {
    const double least = move.leaves_out ? -std::numeric_limits<double>::infinity() : limits_.min_saving;
    // A first look at a busy machine errs upwards, by far.
    const double worth = before.cost * (1.25 - least);
    LeanTrial trial{.round = round_, .group = move.group, .what = move.what, .figures = measure_(move.state, worth)};
    if (trial.figures.refused.empty()) {
      trial.saving = (before.cost - trial.figures.cost) / before.cost;
      if (!limits_.keep(trial.figures)) {
        trial.outcome = LeanOutcome::over_budget;
        over_.insert(move.what);
      } else if (trial.saving < least) {
        trial.outcome = LeanOutcome::no_saving;
        saved_nothing_.insert(move.what);
      } else {
        trial.outcome = LeanOutcome::possible;
      }
    }
    path_.trials.push_back(std::move(trial));
    return path_.trials.back();
  }

  LeanLimits limits_;
  Moves moves_;
  Measure measure_;
  LeanPath<State> path_;
  std::set<std::string> over_, saved_nothing_;  // by what
  std::optional<std::size_t> best_;             // index of a trial
  int round_ = 0;
};

}  // namespace tactor
