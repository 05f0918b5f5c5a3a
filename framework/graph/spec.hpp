// A graph as its file says it, checked and in SI units: what a Plan is made from.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/scene.hpp"
#include "framework/core/time.hpp"
#include "framework/graph/patch.hpp"
#include "framework/node/info.hpp"
#include "framework/yaml/diagnostics.hpp"

namespace tactor {

/// A graph cannot be used: an error of its file, or of one that it names.
using GraphError = YamlError;

/// How graphs write the duration `until_stopped`.
inline constexpr std::string_view until_stopped_text = "until stopped";

/// What drives a run.
enum class Clock : std::uint8_t {
  virtual_,  ///< the deterministic engine
  real,      ///< the live engine
};

/// What a step costs under the virtual clock.
struct CostModel {
  enum class Kind : std::uint8_t {
    none,      ///< outputs are visible at once
    constant,  ///< `base`
    per_item,  ///< base + each * (items the step worked on); YAML key `per_contact`
    trace,     ///< the durations of `trace`, one a step, from the start again at its end
  };
  Kind kind = Kind::none;
  Duration base;
  Duration each;
  double jitter = 0;            ///< standard deviation as a fraction of the cost; the draw is cut at 3 of them
  Duration min;                 ///< the cost is never below
  std::optional<Duration> max;  ///< nor above
  std::vector<Duration> trace;
  std::filesystem::path trace_file;  ///< absolute, where `trace` was read from
};

/// A node of a graph.
struct NodeSpec {
  std::string name;
  const NodeInfo* info = nullptr;  ///< owned by the Registry
  std::vector<ParamValue> params;  ///< in the order of info->params, complete
  CostModel cost;
  Scheduling scheduling;  ///< complete: what the graph says over default_scheduling(*info)
  SourceLocation place;
  /// Hz, at which the node steps; none where its inputs make it step, or it never does.
  [[nodiscard]] std::optional<double> rate() const {
    if (!info->rate_parameter || info->fed) return std::nullopt;
    return std::get<double>(params[*info->rate_parameter]);
  }
};

/// The value of the node's parameter at index `param` that such a text in a graph file means (`1200 N/m`). Throws
/// YamlError with `where` as the place.
ParamValue parse_parameter(const NodeSpec& node, std::size_t param, const std::string& text, const std::string& where);

/// How nodes of a type are scheduled where their graph says nothing: in the lane of the type; `realtime` with policy
/// fifo and priority 80, `thread` with policy other, `pool` as the pool is.
Scheduling default_scheduling(const NodeInfo& info);

/// An edge of a graph.
struct EdgeSpec {
  std::string from_node, from_port;
  std::string to_node, to_port;
  Queue queue;
  bool queue_is_default = true;  ///< the graph named none
  Duration delay;                ///< added between becoming visible and arriving
  SourceLocation place;
  [[nodiscard]] std::string name() const { return from_node + "." + from_port + " -> " + to_node + "." + to_port; }
};

/// A checked graph.
struct GraphSpec {
  std::string name;   ///< graph_name of the file, then `_local` for each file that is laid over it
  std::string title;  ///< one line of prose, or empty
  std::filesystem::path file;
  /// The files of the graph as they were read: its own, those that it extends, those laid over it. Without symbolic
  /// links.
  std::vector<std::filesystem::path> files;
  Clock clock = Clock::virtual_;
  Duration duration;  ///< above 0; `until_stopped` with clock: real alone, and without `record`
  std::uint64_t seed = 1;
  double rate = default_haptic_rate;  ///< Hz, of the haptic loop; its nodes have it as their parameter `rate`
  LiveSettings live;
  Scene scene;
  std::vector<NodeSpec> nodes;
  std::vector<EdgeSpec> edges;
  std::vector<std::string> record;  ///< outputs to record, `node.port`
  /// Where each value was written, by its path (`scene.bodies.tool.mesh`, `nodes.device.rate`); null in a graph that no
  /// file made.
  std::shared_ptr<const std::map<std::string, SourceLocation, std::less<>>> places;

  /// Where the value of that path was written, or the nearest above it that was.
  [[nodiscard]] SourceLocation place_of(std::string_view path) const;
  [[nodiscard]] const NodeSpec* node(std::string_view name) const;
};

class Registry;

/// The name of a graph: its file's stem. Graphs that share a folder with a `scene.yaml` have the folder's name in
/// front, so that bunny/refit.yaml is `bunny_refit`; the scene itself has the folder's name alone.
std::string graph_name(const std::filesystem::path& file);

/// Reads a graph, resolves `extends`, applies the overrides in their order and checks it against the declarations of
/// its node types. Throws GraphError with every error there is. Files that it names are looked for as FileFinder does.
GraphSpec load_graph(const std::filesystem::path& file, Registry& registry, const Overrides& overrides = {});

/// The graph with `extends` resolved and every parameter written out but those that a node chooses, as YAML that loads
/// to the same graph.
/// Files (meshes, data) are absolute paths.
std::string to_yaml(const GraphSpec& spec);

/// What makes `to` of `from`, as a file that extends `extends` (the paths of the files that `from` was loaded from, as
/// the text is to name them): the rate of the haptic loop, parameters, types, costs and lanes of nodes, edges that are
/// gone, and the motion and material of bodies. Other differences are not listed, so to find them all, compare what the
/// text loads to.
std::string to_overlay(const GraphSpec& from, const GraphSpec& to, const std::string& title,
                       const std::vector<std::string>& extends);

}  // namespace tactor
