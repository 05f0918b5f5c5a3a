// Several graphs, or one in several settings, over several seeds: errors and run times side by side.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/run.hpp"
#include "app/statistics.hpp"
#include "framework/graph/spec.hpp"

namespace tactor {

/// What is run with every seed.
struct CompareCase {
  std::filesystem::path graph;
  Overrides overrides;      ///< its seed is replaced
  std::string setting;      ///< how it differs from other cases of the same graph, or empty
  std::size_t against = 0;  ///< the case that it is judged against; itself where there is none
};

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
  /// Against the row `against`; absent for that row itself.
  std::optional<Anova> one_step_anova;        ///< over the single one-step errors of all seeds, as in the paper
  std::optional<PairedDifference> one_step;   ///< of the one-step RMS error over seeds, in N
  std::optional<PairedDifference> delivered;  ///< of the delivered RMS error over seeds, in N

  /// The values of the column that shows this figure, one a seed; empty where there is no such column.
  [[nodiscard]] std::span<const double> figure(std::string_view name, const std::vector<Column>& columns) const;
};

struct Comparison {
  std::vector<std::uint64_t> seeds;
  std::vector<Column> columns;
  std::vector<CompareRow> rows;
};

struct CompareOptions {
  int seeds = 6;
  std::uint64_t first_seed = 1;
  unsigned jobs = 2;  ///< reference runs at once
  unsigned run_jobs =
      1;               ///< judged runs at once; figures do not depend on it, run times are fairest one after the other
  bool curves = true;  ///< keep those of the first seed
  std::filesystem::path cache_folder;
  std::function<bool(double share, const std::string& what)> progress;  ///< false interrupts
  std::function<void(const std::string& note)> note;  ///< as RunOptions::note, by one thread at a time
  std::function<bool()> interrupted;                  ///< true interrupts; may be asked by several threads at once
};

/// Runs every case with every seed. Throws what the runs throw; an interrupt throws RunError.
Comparison compare(const std::vector<CompareCase>& cases, Registry& registry,
                   const std::vector<std::filesystem::path>& mesh_folders, const CompareOptions& options);

nlohmann::ordered_json to_json(const Comparison& comparison);
/// One row of it, with mean, deviation and the values by seed of every figure, and what it is against another.
nlohmann::ordered_json to_json(const CompareRow& row, const std::vector<Column>& columns);

/// A line for each row that is judged against another: ANOVA of the single one-step errors, and paired differences with
/// their 95 % confidence interval, effect size d_z and Wilcoxon's p.
std::string judged_text(const Comparison& comparison);
/// The table that `tactor compare` prints.
std::string comparison_table(const Comparison& comparison);

}  // namespace tactor
