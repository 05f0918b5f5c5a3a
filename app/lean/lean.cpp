#include "app/lean/lean.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "app/lean/lean_moves.hpp"
#include "app/run/summary.hpp"
#include "app/statistics.hpp"
#include "framework/core/check.hpp"
#include "framework/graph/text_table.hpp"

namespace tactor {

namespace {

using Row = std::vector<std::string>;

/// Less is within what times of runs differ by, as LeanLimits::min_saving is.
constexpr double no_cheaper = 1.02;

const char* word(LeanOutcome outcome) {
  switch (outcome) {
    case LeanOutcome::taken:
      return "taken";
    case LeanOutcome::possible:
      return "possible";
    case LeanOutcome::over_budget:
      return "over the budget";
    case LeanOutcome::no_saving:
      return "saves nothing";
    case LeanOutcome::refused:
      return "cannot be run";
  }
  return "";
}

void demand_within(const Lean& lean, const LeanLimits& limits, const LeanMetrics& metrics, const char* on) {
  if (!metrics.refused.empty()) throw InputError(metrics.refused);
  if (limits.keep(metrics)) return;
  throw InputError(fmt::format(
      "{}: expected a graph within the budget of {} N and {} N m, found one that is itself {} N and {} N m from its "
      "reference run{}; give a larger --budget or --torque-budget, judge by --metric physics, which has no delay in "
      "it, "
      "or start from a graph of reference quality, such as graphs/bunny/fine.yaml",
      lean.original.file.string(), pretty(limits.error), pretty(limits.torque_error), pretty(metrics.error),
      pretty(metrics.torque_error), on));
}

/// Runs original and result, takes back the last step while the budget is broken, then times the two by turns.
void check(Lean& lean, LeanMeasure& measure, const LeanLimits& limits) {
  const std::vector<std::uint64_t>& seeds = lean.options.check_seeds;
  lean.options.progress("original and result on other seeds");
  lean.original_checked = measure.first_look(lean.original, seeds);
  demand_within(lean, limits, lean.original_checked, " on the seeds of the check");
  for (lean.kept = lean.path.steps.size();; --lean.kept) {
    lean.graph = lean.kept == 0 ? lean.original : lean.path.steps[lean.kept - 1].state;
    lean.lean_checked = measure.first_look(lean.graph, seeds);
    if (lean.kept == 0 || (lean.lean_checked.refused.empty() && limits.keep(lean.lean_checked))) break;
    lean.options.progress("over the budget on these seeds: the last step is taken back");
  }
  const std::array<LeanMeasure::Looked, 2> both{
      {{&lean.original, &lean.original_checked}, {&lean.graph, &lean.lean_checked}}};
  measure.time_by_turns(both, seeds);
}

Row error_cells(const LeanMetrics& f) {
  return {pretty(f.error), pretty(f.max_error), pretty(f.torque_error)};
}

Row joined(Row a, const Row& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

std::vector<Row> step_rows(const Lean& lean) {
  std::vector<Row> rows{
      {"", "step", "saves", "us a simulated s", "to", "spread", "error, N", "largest, N", "torque, N m"}};
  const auto add = [&rows](Row head, const LeanMetrics& f) {
    rows.push_back(
        joined(joined(std::move(head), {fmt::format("{:.0f}", f.cost), percent(spread_of_repeats(f.repeats))}),
               error_cells(f)));
  };
  add({"", "the graph as it is", "", ""}, lean.path.start);
  for (std::size_t i = 0; i < lean.path.steps.size(); ++i) {
    const LeanStep<GraphSpec>& step = lean.path.steps[i];
    add({std::to_string(i + 1), step.what + (i < lean.kept ? "" : " (taken back)"), percent(step.saving),
         fmt::format("{:.0f}", step.metrics.before.cost)},
        step.metrics.after);
  }
  return rows;
}

std::vector<Row> check_rows(const Lean& lean) {
  std::vector<Row> rows{{"", "us a simulated s", "spread", "error, N", "largest, N", "torque, N m"}};
  const auto add = [&rows](const char* name, const LeanMetrics& f) {
    rows.push_back(
        joined({name, fmt::format("{:.0f}", f.cost), percent(spread_of_repeats(f.repeats))}, error_cells(f)));
  };
  add("original", lean.original_checked);
  add("lean", lean.lean_checked);
  return rows;
}

/// The last trial of each move that was not taken and tells something.
std::vector<LeanTrial> not_taken(const Lean& lean) {
  std::map<std::string, const LeanTrial*> last;
  for (const LeanTrial& trial : lean.path.trials) last[trial.what] = &trial;
  std::vector<LeanTrial> kept;
  for (const LeanTrial& trial : lean.path.trials) {
    const bool tells = trial.outcome == LeanOutcome::over_budget || trial.outcome == LeanOutcome::no_saving ||
                       trial.outcome == LeanOutcome::refused;
    if (tells && last[trial.what] == &trial) kept.push_back(trial);
  }
  return kept;
}

std::vector<Row> trial_rows(const Lean& lean) {
  std::vector<Row> rows{{"not taken", "why", "saves", "error, N", "torque, N m"}};
  for (const LeanTrial& trial : not_taken(lean)) {
    const bool ran = trial.outcome != LeanOutcome::refused;
    const bool timed = trial.outcome == LeanOutcome::no_saving;
    const LeanMetrics& f = trial.metrics.after;
    rows.push_back({trial.what, word(trial.outcome), timed ? percent(trial.saving) : "-", ran ? pretty(f.error) : "-",
                    ran ? pretty(f.torque_error) : "-"});
  }
  return rows;
}

std::string plain(const std::vector<Row>& rows, std::size_t columns) {
  std::vector<TextTable::Column> heads;
  for (std::size_t c = 0; c < rows.front().size(); ++c) {
    const bool left = c < 2 && rows.front().size() > c + 1;
    heads.push_back({rows.front()[c], left ? TextTable::Align::left : TextTable::Align::right});
  }
  TextTable table(std::move(heads));
  for (std::size_t r = 1; r < rows.size(); ++r) table.add(rows[r]);
  return table.text(columns);
}

std::string markdown(const std::vector<Row>& rows) {
  std::string text;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (const std::string& cell : rows[r]) text += "| " + cell + " ";
    text += "|\n";
    if (r > 0) continue;
    for (std::size_t c = 0; c < rows[r].size(); ++c) text += "|---";
    text += "|\n";
  }
  return text;
}

std::string seeds_text(const std::vector<std::uint64_t>& seeds) {
  std::string text;
  for (const std::uint64_t seed : seeds) text += (text.empty() ? "" : ", ") + std::to_string(seed);
  return text;
}

std::string head(const Lean& lean) {
  return fmt::format("{}: budget {} N and {} N m, RMS of the {} force and torque against the original's reference run",
                     lean.original.name, pretty(lean.options.budget), pretty(lean.options.torque_budget),
                     word(lean.options.measure.metric));
}

std::string verdict(const Lean& lean) {
  const std::string unseen = fmt::format("on seeds {}, which the search (seeds {}) has not seen",
                                         seeds_text(lean.options.check_seeds), seeds_text(lean.options.seeds));
  if (lean.kept == 0) {
    return lean.path.steps.empty()
               ? "no cheaper graph was found: every trial costs as much, breaks the budget or cannot run; the result "
                 "is the unchanged graph"
               : "no cheaper graph was found: every saving on the seeds of the search broke the budget " + unseen +
                     "; the result is the unchanged graph";
  }
  const std::vector<double> ratios = lean.ratios();
  const std::string range =
      ratios.empty() ? std::string()
                     : fmt::format(" ({:.2f} to {:.2f} in runs by turns)", quantile(ratios, 0), quantile(ratios, 1));
  const bool saves = !ratios.empty() ? quantile(ratios, 0) > 1 : lean.ratio() > 1;
  if (!saves || lean.ratio() < no_cheaper) {
    return fmt::format("smaller, but not measurably cheaper: {:.2f} times{} {}", lean.ratio(), range, unseen);
  }
  // With one digit a saving of 4 % would read as none.
  return fmt::format("{:.{}f} times cheaper{} {}", lean.ratio(), lean.ratio() < 2 ? 2 : 1, range, unseen);
}

/// How the times were taken, and the warning where there is one, each line after `begin`.
std::string timing_text(const TimingNote& timing, const char* of, const char* begin) {
  std::string text = fmt::format("{}{}: {}\n", begin, of, timing.text);
  if (!timing.warning.empty()) text += fmt::format("{}{}\n", begin, timing.warning);
  return text;
}

/// Whether a step of physics fits a tick, each line after `begin`.
std::string physics_text(const Lean& lean, const char* begin) {
  if (!lean.physics) return {};
  return fmt::format("{}In the resulting graph:\n{}", begin, text_of(*lean.physics, begin));
}

nlohmann::ordered_json json_of(const LeanMetrics& f) {
  return {
      {"cost_us_per_s", f.cost}, {"repeats_us_per_s", f.repeats}, {"spread", number_json(spread_of_repeats(f.repeats))},
      {"error_N", f.error},      {"max_error_N", f.max_error},    {"torque_error_Nm", f.torque_error}};
}

}  // namespace

std::vector<double> Lean::ratios() const {
  std::vector<double> found;
  for (std::size_t i = 0; i < std::min(original_checked.repeats.size(), lean_checked.repeats.size()); ++i) {
    found.push_back(original_checked.repeats[i] / lean_checked.repeats[i]);
  }
  return found;
}

Lean make_lean(GraphSpec original, Registry& registry, const LeanOptions& options) {
  Lean lean{.options = options, .original = std::move(original), .graph = {}, .path = {}};
  const LeanLimits limits{.error = options.budget, .torque_error = options.torque_budget};
  LeanMeasure measure(lean.original, options.measure);
  options.progress("original");
  LeanMetrics start = measure.first_look(lean.original, options.seeds);
  demand_within(lean, limits, start, "");
  const LeanMeasure::Looked original_looked{&lean.original, &start};
  measure.time_by_turns(std::span(&original_looked, 1), options.seeds);
  const auto moves = [&registry](const GraphSpec& graph) { return lean_moves(graph, registry); };
  const auto compare = [&](const GraphSpec& before, const LeanMove<GraphSpec>& move) {
    return measure.compare(before, move.state, !move.leaves_out, options.seeds, limits);
  };
  const auto told = [&](const GraphSpec& graph) {
    auto found = moves(graph);
    options.progress(fmt::format("{} things to leave out or coarsen", found.size()));
    return found;
  };
  lean.path = LeanSearch<GraphSpec>(limits, told, compare).run(lean.original, std::move(start));
  lean.search_timing = measure.timing();
  check(lean, measure, limits);
  lean.check_timing = measure.timing();
  lean.physics = measure_physics_fit(make_plan(lean.graph), options.measure.interrupted);
  return lean;
}

std::string lean_table(const Lean& lean, std::size_t columns) {
  return wrapped("\n" + head(lean) + "\n\n" + plain(step_rows(lean), columns) + "\n" +
                     plain(check_rows(lean), columns) + "  " + verdict(lean) + "\n" + physics_text(lean, "  ") + "\n" +
                     timing_text(lean.check_timing, "The check", "  ") +
                     timing_text(lean.search_timing, "The search", "  ") + "\n" + plain(trial_rows(lean), columns),
                 columns);
}

std::string lean_markdown(const Lean& lean) {
  return "# " + lean.original.name + ", lean\n\n" + head(lean) + ".\n\n" + markdown(step_rows(lean)) + "\n" +
         timing_text(lean.search_timing, "The search", "") + "\n" + verdict(lean) + ":\n\n" +
         markdown(check_rows(lean)) + "\n" + physics_text(lean, "") + timing_text(lean.check_timing, "The check", "") +
         "\n" + markdown(trial_rows(lean));
}

nlohmann::ordered_json to_json(const Lean& lean) {
  nlohmann::ordered_json json{{"graph", lean.original.name},      {"metric", word(lean.options.measure.metric)},
                              {"budget_N", lean.options.budget},  {"torque_budget_Nm", lean.options.torque_budget},
                              {"seeds", lean.options.seeds},      {"check_seeds", lean.options.check_seeds},
                              {"start", json_of(lean.path.start)}};
  json["steps"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < lean.path.steps.size(); ++i) {
    const LeanStep<GraphSpec>& step = lean.path.steps[i];
    json["steps"].push_back({{"what", step.what},
                             {"taken_back", i >= lean.kept},
                             {"saving", step.saving},
                             {"before", json_of(step.metrics.before)},
                             {"after", json_of(step.metrics.after)}});
  }
  json["check"] = {{"original", json_of(lean.original_checked)},
                   {"lean", json_of(lean.lean_checked)},
                   {"ratio", lean.ratio()},
                   {"ratio_by_turn", lean.ratios()}};
  json["physics"] = lean.physics ? to_json(*lean.physics) : nlohmann::ordered_json(nullptr);
  json["timing"] = {{"search", to_json(lean.search_timing)}, {"check", to_json(lean.check_timing)}};
  json["trials"] = nlohmann::ordered_json::array();
  for (const LeanTrial& trial : lean.path.trials) {
    nlohmann::ordered_json t{{"round", trial.round}, {"what", trial.what}, {"outcome", word(trial.outcome)}};
    if (trial.outcome == LeanOutcome::refused) {
      t["why"] = trial.metrics.after.refused;
    } else {
      if (trial.outcome != LeanOutcome::over_budget) {
        t["saving"] = trial.saving;
        t["before"] = json_of(trial.metrics.before);
      }
      t["metrics"] = json_of(trial.metrics.after);
    }
    json["trials"].push_back(std::move(t));
  }
  return json;
}

}  // namespace tactor
