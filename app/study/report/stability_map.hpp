// The stability report of a study: a verdict for each cell of a map over two parameters, with metrics and reason.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/study/table/study.hpp"
#include "framework/core/stability.hpp"

namespace tactor {

class Registry;

/// What became of a cell: the worst of its seeds.
struct StabilityCell {
  std::size_t row = 0;   ///< of the comparison
  std::size_t seed = 0;  ///< index of the worst seed
  StabilityVerdict verdict = StabilityVerdict::stable;
  bool failed = false;  ///< the run ended before it could be judged: the verdict is `refused`
  std::string reason;   ///< empty where it is stable
  double peak_energy_J = 0, passivity_violation_J = 0, amplitude_m = 0, frequency_Hz = 0;  ///< of that seed; NaN: none
  std::optional<bool> passive;  ///< of all seeds, the strict form of stable; absent where one does not tell
  std::string recording;        ///< the folder with its recording, below the study's; empty where it was not recorded
};

/// The map of one graph and method; cells are [row of y][column of x].
struct StabilityMap {
  std::string graph, method;
  std::optional<std::size_t> own_x, own_y;  ///< the values that the graph has without the study's; absent: others
  std::vector<std::vector<StabilityCell>> cells;
};

/// The first parameter of the study goes along x, the second along y.
struct StabilityMaps {
  StudyAxis x, y;
  std::vector<StabilityMap> maps;
};

/// Looks in every graph that can run for the outputs that `report.record` names. Throws GraphError with the places of
/// those that one of them lacks.
void check_record(const StudySpec& spec, const std::vector<RunCase>& cases, Registry& registry);

/// Throws InputError where no run was judged.
StabilityMaps stability_maps(const Study& study);

/// Finds in each map which values are the graph's own, by comparing the graphs that they make. False where
/// `interrupted`, which is asked before each of these, ended it.
bool find_own_values(StabilityMaps& maps, const Study& study, const std::vector<RunCase>& cases, Registry& registry,
                     const std::function<bool()>& interrupted);

/// The worst cells that are not stable, as many as the study wants to be recorded; none where this build cannot record.
std::vector<StabilityCell*> worst_cells(StabilityMaps& maps, const Study& study);
/// Runs such a cell of the case anew, with a recording, and returns its folder below the study's, worst/NAME. Empty
/// where `interrupted`, which is asked during the run, ended it: then it leaves nothing.
std::string record_cell(const StabilityCell& cell, const Study& study, const RunCase& c, Registry& registry,
                        const std::filesystem::path& folder, const std::function<bool()>& interrupted);

std::string stability_table(const Study& study, const StabilityMaps& maps, std::size_t columns);
nlohmann::ordered_json to_json(const StabilityMaps& maps);

/// Writes stability_GRAPH.svg and .png into the folder and returns the page with the maps and tables.
std::string write_stability(const std::filesystem::path& folder, const Study& study, const StabilityMaps& maps);

}  // namespace tactor
