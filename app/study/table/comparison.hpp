// Several graphs, or one in several configurations, over several seeds: errors and run times side by side.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/run/provenance.hpp"
#include "app/run/timing.hpp"
#include "app/statistics.hpp"
#include "app/study/plan/run_case.hpp"
#include "app/study/table/run_table.hpp"

namespace tactor {

/// A metric that every graph of a comparison reports.
struct Column {
  std::string metric;  ///< dotted name of the metric
  std::string label;   ///< for tables
  bool run_time = false;
};

/// One case over all seeds.
struct CompareRow {
  std::string graph;
  std::string configuration;
  std::string title;
  std::size_t against = 0;
  std::vector<RunResult> runs;              ///< one a seed, without curves except the first's
  std::vector<std::vector<double>> values;  ///< [column][seed]
  std::vector<RunStatus> status;            ///< one a seed
  std::vector<std::string> message;         ///< one a seed; empty where it is done
  std::vector<double> spread;               ///< one a seed: (longest - shortest) / median CPU time of its repeats
  std::vector<double> control_us;           ///< one a seed, see RunRecord
  /// How it differs from what the rows are compared on, such as in its scene; empty: in nothing.
  std::string unlike;
  JudgedFrom judged;             ///< the interval that its metrics are of
  std::string too_coarse;        ///< why a run has no truth that is finer than it: the row is not ranked; else empty
  bool identical_seeds = false;  ///< the runs of all seeds that are done, two or more, have the same metrics
  /// Against the row `against`; absent for that row itself, and where the two are not compared (see is_compared).
  /// Over the single one-step errors of all seeds, as in the paper; absent too where the seeds are copies of one run.
  std::optional<Anova> one_step_anova;
  std::optional<PairedDifference> one_step;   ///< of the one-step RMS error over seeds, in N
  std::optional<PairedDifference> delivered;  ///< of the delivered RMS error over seeds, in N

  /// The values of the column that shows this metric, one a seed; empty where there is no such column.
  [[nodiscard]] std::span<const double> metric(std::string_view name, const std::vector<Column>& columns) const;
  /// Of values by seed those of the runs that are done, which means are taken over.
  [[nodiscard]] std::vector<double> done(std::span<const double> by_seed) const;
  /// The mean of a metric over the runs that are done; NaN where there is none.
  [[nodiscard]] double mean_of(std::string_view name, const std::vector<Column>& columns) const;
  /// True where collision looked for contacts in the runs that are done, and none of them found one.
  [[nodiscard]] bool never_touches() const;
  /// True where a run that is done was judged against a reference.
  [[nodiscard]] bool has_reference(const std::vector<Column>& columns) const;
  /// How many runs are done.
  [[nodiscard]] std::size_t seeds_done() const;
  /// `9 of 10 seeds`; empty where all runs are done.
  [[nodiscard]] std::string seeds_text() const;
  /// `wall_off`, `wall kalman`: the graph, and the configuration where there is one.
  [[nodiscard]] std::string full_name() const;
  /// `name`, and the seeds that are there where some are not.
  [[nodiscard]] std::string with_seeds(const std::string& name) const;
  /// The name in tables: the full name, with_seeds.
  [[nodiscard]] std::string name() const;
};

struct Comparison {
  std::vector<std::uint64_t> seeds;  ///< of every row
  std::vector<Column> columns;
  std::vector<CompareRow> rows;
  MetricMap declared{};                         ///< the metrics of the runs, and the run times derived from them
  std::vector<std::string> further_warnings{};  ///< what makes it doubtful beside what comparison_warnings finds
  std::vector<std::string> where{};             ///< sentences on where the runs were made
  Provenance provenance{};                      ///< empty: not told

  /// The index of the column that shows this metric; absent where there is none.
  [[nodiscard]] std::optional<std::size_t> column(std::string_view metric) const;
  /// The declaration of a metric, or null.
  [[nodiscard]] const MetricInfo* info(std::string_view metric) const;
};

/// Puts the runs of the cases side by side. Runs that are not there, or failed, have no metrics. `metrics`: the metrics
/// that columns show beside the run times; none: the usual ones. `declared`: what the runs may report.
Comparison make_comparison(const std::vector<RunCase>& cases, const std::vector<std::uint64_t>& seeds,
                           std::vector<RunRecord> records, const std::vector<std::string>& metrics = {},
                           MetricMap declared = {});

/// How the values of one row over the seeds lie, beside their mean.
struct SeedSpread {
  double low = 0, middle = 0, high = 0;  ///< the quantiles 0.05, 0.5 and 0.95
  double worst = 0;                      ///< the value of the worst seed
  std::uint64_t worst_seed = 0;
  std::optional<TwoPopulations> populations;
};
/// Of values by seed, those that are finite; absent for none. The worst is that of the largest badness.
std::optional<SeedSpread> seed_spread(const std::vector<std::uint64_t>& seeds, std::span<const double> by_seed,
                                      Better better = Better::lower);
/// `two populations: 8 seeds at 0.24 to 0.34, 2 at 0.69 to 0.7`; empty where there are none.
std::string populations_text(const std::optional<SeedSpread>& spread);
/// What tables say of the part of the runs that they judge, a sentence for each group of rows that is not judged from
/// its start: `duck: judged from 3.7 s on, when all is warm (last: duck refit, seed 1003: refit)`; and the version of
/// the metrics' definitions.
std::vector<std::string> judged_sentences(const Comparison& comparison);

/// `text` with the unit of the metric behind it.
std::string with_unit(const Comparison& comparison, const std::string& text, std::string_view metric);
/// The column's label, and an arrow down where lower is better, up where higher is.
std::string head_of(const Comparison& comparison, const Column& column);
/// What the arrows of head_of say, for readers.
inline constexpr const char* arrows_text = "↓: lower is better; ↑: higher is better; →0: nearer to zero is better";

/// Of all runs that are done. `warning` names the rows with a run whose repeats spread too far, the worst first.
TimingNote timing_note(const Comparison& comparison, Repeats repeats);

nlohmann::ordered_json to_json(const SeedSpread& spread);
nlohmann::ordered_json to_json(const Comparison& comparison);
/// One row of it: how each run ended, mean and deviation (null for fewer than two) over the runs that are done and the
/// values by seed of every metric, and what it is against another.
nlohmann::ordered_json to_json(const Comparison& comparison, const CompareRow& row);
/// A line for every run that failed or was refused.
std::string failures_text(const Comparison& comparison);
std::string word_of(RunStatus status);

/// Whether the row is tested against the row `against`: it is another, differs in its method alone, and either of them
/// touches something. Runs
/// without a truth that is finer than they are have no delivered error, and are compared by their one-step errors
/// alone.
bool is_compared(const Comparison& comparison, std::size_t row);

/// The ANOVA of the row as tables show it: from `fewest_seeds` on, like all statistics; null where there is none.
const Anova* shown_anova(const Comparison& comparison, const CompareRow& row);
/// Of how many seeds the row and what it is compared with are both done.
std::size_t judged_seeds(const Comparison& comparison, const CompareRow& row);
/// `9 of 10 seeds`.
std::string of_seeds(std::size_t count, std::size_t seeds);
/// ` over 9 seeds` where the `count` is less than the `seeds` there should be; else empty.
std::string over_seeds(std::size_t count, std::size_t seeds);
}  // namespace tactor
