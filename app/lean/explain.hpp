// `tactor explain`: what a scene needs and what was left out, with what each costs, measured over a short run.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

/// What a node costs.
struct ExplainedNode {
  std::string node, type, lane;
  std::uint64_t steps = 0;
  double us_per_step = 0;        ///< CPU time, the mean
  double us_per_second = 0;      ///< CPU time a simulated second
  double share = 0;              ///< of all nodes; the shares sum to 1
  std::int64_t built_bytes = 0;  ///< of the heap, taken while it was made
  std::int64_t peak_bytes = 0;   ///< the most of the heap it had while it was made and ran
};

/// A file of code that is loaded.
struct ExplainedLibrary {
  std::string name;
  std::uint64_t bytes = 0;  ///< of the file
  bool ours = false;
};

/// What was left out, and what it would have cost.
struct ExplainedLeftOut {
  std::string what, why;
  std::optional<double> us_per_second;  ///< CPU time a simulated second; absent: not measured
};

struct Explanation {
  std::string graph, title;
  std::uint64_t seed = 0;
  double duration_s = 0;  ///< simulated
  int degrees_of_freedom = 0;
  int moving_bodies = 0;
  bool torque = false;
  bool memory_is_counted = false;
  std::vector<Chosen> chosen;
  std::vector<ExplainedNode> nodes;
  std::vector<ExplainedLibrary> libraries;  ///< ours first, then by size
  std::vector<ExplainedLeftOut> left_out;
};

/// Runs the graph for `seconds` of simulated time, and again for memory, and with what was left out kept in where the
/// graph can be run so: torque with a tool that turns, and nodes whose outputs nobody reads. Throws InputError and
/// RunError as a run does.
Explanation explain_measured(const GraphSpec& graph, double seconds, const Registry& registry,
                             const std::function<bool()>& interrupted);

std::string explanation_table(const Explanation& explanation);
nlohmann::ordered_json to_json(const Explanation& explanation);

}  // namespace tactor
