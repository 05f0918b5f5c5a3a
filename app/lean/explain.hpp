// `tactor explain`: what a scene needs and what was left out, with what each costs, measured over short runs.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/lean/physics_fit.hpp"
#include "app/run/timing.hpp"
#include "framework/graph/plan.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

/// What a node costs: the median of the repeats.
struct ExplainedNode {
  std::string node, type, lane;
  std::uint64_t steps = 0;
  double us_per_step = 0;        ///< CPU time, the mean over the steps
  double us_per_second = 0;      ///< CPU time a simulated second
  double spread = 0;             ///< of the repeats, see spread_of_repeats()
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

/// CPU time in us a simulated second: the median of the repeats, the least and the most of them. Of a difference the
/// least, or all, may be below 0: it is then within what the machine's times differ by.
struct ExplainedCost {
  double median = 0, least = 0, most = 0;
};

/// What was left out, and what it would have cost.
struct ExplainedLeftOut {
  std::string what, why;
  std::optional<ExplainedCost> cost;  ///< absent: not measured
};

struct Explanation {
  std::string graph, title;
  std::uint64_t seed = 0;
  double duration_s = 0;  ///< simulated, of each run
  int degrees_of_freedom = 0;
  int moving_bodies = 0;
  bool torque = false;
  bool memory_is_counted = false;
  std::vector<Chosen> chosen;
  std::vector<ExplainedNode> nodes;
  ExplainedCost total;                      ///< of all nodes
  std::vector<ExplainedLibrary> libraries;  ///< ours first, then by size
  std::vector<ExplainedLeftOut> left_out;
  std::optional<PhysicsFit> physics;  ///< none where no node moves bodies
  TimingNote timing;
};

/// Runs the graph for `seconds` of simulated time as often as `repeats` says, and by turns with it what was left out,
/// kept in where the graph can be run so: torque with a tool that turns, and nodes whose outputs nobody reads. Once
/// more for memory. Throws InputError and RunError as a run does, Interrupted where the user ends it.
Explanation explain_measured(const GraphSpec& graph, double seconds, Repeats repeats, const Registry& registry,
                             const std::function<bool()>& interrupted);

/// What `tactor explain` prints, in so many columns.
std::string explanation_table(const Explanation& explanation, std::size_t columns);
nlohmann::ordered_json to_json(const Explanation& explanation);

}  // namespace tactor
