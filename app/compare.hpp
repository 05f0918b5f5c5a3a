// The ablation: several graphs over several seeds, their errors and run times side by side.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/run.hpp"
#include "app/statistics.hpp"
#include "framework/graph/spec.hpp"

namespace tactor {

/// A figure that every graph of a comparison reports.
struct Column {
  std::string figure;  ///< dotted name of the figure
  std::string label;   ///< for tables
  bool run_time = false;
};

/// One graph over all seeds.
struct CompareRow {
  std::string graph;
  std::string title;
  std::vector<RunResult> runs;              ///< one a seed, without curves except the first's
  std::vector<std::vector<double>> values;  ///< [column][seed]
  /// Against the first graph; absent for the first.
  std::optional<Anova> one_step_anova;        ///< over the single one-step errors of all seeds, as in the paper
  std::optional<PairedDifference> one_step;   ///< of the one-step RMS error over seeds, in N
  std::optional<PairedDifference> delivered;  ///< of the delivered RMS error over seeds, in N
};

struct Comparison {
  std::vector<std::uint64_t> seeds;
  std::vector<Column> columns;
  std::vector<CompareRow> rows;
};

struct CompareOptions {
  int seeds = 6;
  std::uint64_t first_seed = 1;
  unsigned jobs = 2;  ///< reference runs at once; the judged runs go one after the other so that their times are fair
  Overrides overrides;
  std::filesystem::path cache_folder;
  std::function<bool(double share, const std::string& what)> progress;  ///< false interrupts
  std::function<void(const std::string& note)> note;  ///< as RunOptions::note, by one thread at a time
  std::function<bool()> interrupted;                  ///< true interrupts; may be asked by several threads at once
};

/// Runs every graph with every seed. Throws what the runs throw; an interrupt throws RunError.
Comparison compare(const std::vector<std::filesystem::path>& graphs, Registry& registry,
                   const std::vector<std::filesystem::path>& mesh_folders, const CompareOptions& options);

nlohmann::ordered_json to_json(const Comparison& comparison);

/// The table that `tactor compare` prints.
std::string comparison_table(const Comparison& comparison);

}  // namespace tactor
