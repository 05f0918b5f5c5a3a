// Several graphs, or one in several settings, over several seeds: errors and run times side by side.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/run/timing.hpp"
#include "app/statistics.hpp"
#include "app/study/run_cases.hpp"

namespace tactor {

/// A figure that every graph of a comparison reports.
struct Column {
  std::string figure;  ///< dotted name of the figure
  std::string label;   ///< for tables
  bool run_time = false;
};

/// One case over all seeds.
struct CompareRow {
  std::string graph;
  std::string setting;
  std::string title;
  std::size_t against = 0;
  std::vector<RunResult> runs;              ///< one a seed, without curves except the first's
  std::vector<std::vector<double>> values;  ///< [column][seed]
  std::vector<RunStatus> status;            ///< one a seed
  std::vector<std::string> message;         ///< one a seed; empty where it is done
  std::vector<double> spread;               ///< one a seed: (longest - shortest) / median CPU time of its repeats
  std::vector<double> control_us;           ///< one a seed, see RunRecord
  /// Against the row `against`; absent for that row itself.
  std::optional<Anova> one_step_anova;        ///< over the single one-step errors of all seeds, as in the paper
  std::optional<PairedDifference> one_step;   ///< of the one-step RMS error over seeds, in N
  std::optional<PairedDifference> delivered;  ///< of the delivered RMS error over seeds, in N

  /// The values of the column that shows this figure, one a seed; empty where there is no such column.
  [[nodiscard]] std::span<const double> figure(std::string_view name, const std::vector<Column>& columns) const;
};

struct Comparison {
  std::vector<std::uint64_t> seeds;  ///< of every row
  std::vector<Column> columns;
  std::vector<CompareRow> rows;
};

/// Puts the runs of the cases side by side. Runs that are not there, or failed, have no figures. `metrics`: the figures
/// that columns show beside the run times; none: the usual ones.
Comparison make_comparison(const std::vector<RunCase>& cases, const std::vector<std::uint64_t>& seeds,
                           std::vector<RunRecord> records, const std::vector<std::string>& metrics = {});

/// Of all runs that are done; the spread of the repeats warns by the median over the runs.
TimingNote timing_note(const Comparison& comparison, Repeats repeats);

nlohmann::ordered_json to_json(const Comparison& comparison);
/// One row of it, with mean, deviation and the values by seed of every figure, and what it is against another.
nlohmann::ordered_json to_json(const CompareRow& row, const std::vector<Column>& columns);

/// A line for each row that is judged against another: ANOVA of the single one-step errors, and paired differences with
/// their 95 % confidence interval, effect size d_z and Wilcoxon's p.
std::string judged_text(const Comparison& comparison);
/// The table that `tactor compare` prints.
std::string comparison_table(const Comparison& comparison, const TimingNote& timing);

}  // namespace tactor
