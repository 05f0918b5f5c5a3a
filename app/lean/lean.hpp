// `tactor lean`: the leanest graph that keeps an error budget, checked on seeds that the search has not seen.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/lean/lean_measure.hpp"
#include "app/lean/lean_search.hpp"
#include "app/lean/physics_fit.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

struct LeanOptions {
  double budget = 0;         ///< N, RMS
  double torque_budget = 0;  ///< N m, RMS
  std::vector<std::uint64_t> seeds{1};
  std::vector<std::uint64_t> check_seeds{1001};  ///< on which the result is checked; none of `seeds`
  LeanMeasureOptions measure;
  /// Told what is being measured, before it is.
  std::function<void(const std::string& what)> progress = [](const std::string&) {};
};

/// The leanest graph, and how it came about.
struct Lean {
  LeanOptions options;
  GraphSpec original;  ///< of the chosen types
  GraphSpec graph;
  LeanPath<GraphSpec> path;
  std::size_t kept = 0;  ///< steps of the path; those after them did not keep the budget on the check's seeds
  LeanMetrics original_checked, lean_checked;  ///< their repeats by turns
  TimingNote search_timing, check_timing;
  /// Of the lean graph; none where no node moves bodies.
  std::optional<PhysicsFit> physics;

  /// How many times cheaper the lean graph is, by the check.
  [[nodiscard]] double ratio() const { return original_checked.cost / lean_checked.cost; }
  /// The same by each turn; none where nothing was repeated.
  [[nodiscard]] std::vector<double> ratios() const;
};

/// Searches from `original`, runs it and the result on other seeds, and takes back the last steps as long as the budget
/// is broken there. Throws InputError where the original itself is over the budget, Interrupted where the user ends it.
Lean make_lean(GraphSpec original, Registry& registry, const LeanOptions& options);

/// What is printed: the steps with what each saved, original and result by the check, and what was tried and not taken.
std::string lean_table(const Lean& lean, std::size_t columns);
/// The same as Markdown.
std::string lean_markdown(const Lean& lean);
nlohmann::ordered_json to_json(const Lean& lean);

}  // namespace tactor
