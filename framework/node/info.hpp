// The declaration of a node type as data: ports, parameters, and when a scene does not need it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "framework/core/file_lookup.hpp"
#include "framework/core/scene.hpp"
#include "framework/core/scheduling.hpp"
#include "framework/node/node.hpp"

namespace tactor {

/// A table of numbers, row by row.
struct Table {
  std::size_t columns = 0;
  std::vector<double> values;  ///< SI, `columns` to a row
  [[nodiscard]] std::size_t rows() const { return columns == 0 ? 0 : values.size() / columns; }
  [[nodiscard]] double at(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
  bool operator==(const Table&) const = default;
};

/// Pairs of texts, in the order of the file.
using Mapping = std::vector<std::pair<std::string, std::string>>;

/// A checked parameter value in SI units.
using ParamValue = std::variant<bool, std::int64_t, double, std::string, std::vector<double>, Table, Mapping>;

enum class ParamKind : std::uint8_t {
  boolean,  ///< bool
  integer,  ///< std::int64_t
  real,     ///< double, with a unit
  text,     ///< std::string
  choice,   ///< std::string, one of `choices`
  file,     ///< std::string: the absolute path of a file that exists, or empty where that is the default
  reals,    ///< std::vector<double>, with a unit, of `size` entries where size > 0
  table,    ///< Table with `columns`
  mapping,  ///< Mapping
};

/// A column of a table parameter.
struct ColumnInfo {
  std::string name;
  std::string unit;
  std::optional<double> default_value;  ///< in SI; absent: the column must be given
};

/// What a node of a graph meets, as far as it decides which of its parameters count.
struct ParamUse {
  const Scene* scene = nullptr;                ///< never null
  std::vector<std::string_view> read_outputs;  ///< those that something reads or records
  [[nodiscard]] bool is_read(std::string_view output) const {
    return std::find(read_outputs.begin(), read_outputs.end(), output) != read_outputs.end();
  }
};

/// What a node does in the pipeline.
enum class Role : std::uint8_t {
  other,
  source,         ///< makes motion or force, or plays it back
  device,         ///< what the hand holds
  collision,      ///< finds contacts
  dynamics,       ///< moves the bodies
  coupling,       ///< makes the force on the device from tool and handle
  prediction,     ///< expects the next forces, or learns how
  interpolation,  ///< makes the force between results of the physics
  force_field,    ///< makes the force from where the device is
  sink,           ///< what a run is made for
};
inline constexpr std::size_t role_count = 10;
/// `force_field`.
std::string_view name_of(Role role);
/// The role of that name; Role::other where there is none.
Role role_of(std::string_view name);

/// A parameter of a node type.
struct ParamInfo {
  std::string name;
  ParamKind kind = ParamKind::real;
  std::string unit = "1";                                 ///< the SI unit of the value
  std::optional<ParamValue> default_value;                ///< absent: the parameter must be given
  double min = -std::numeric_limits<double>::infinity();  ///< smallest value allowed, or see `above_min`
  double max = std::numeric_limits<double>::infinity();   ///< largest value allowed
  bool above_min = false;                                 ///< true: the value must be larger than `min`
  std::vector<std::string> choices;
  std::vector<ColumnInfo> columns;
  std::size_t size = 0;
  FileKind file;                           ///< of a file: where those of the user and the program lie
  std::string doc;                         ///< one line
  std::string former;                      ///< what it was called before; empty: always so
  std::optional<ParamValue> in_reference;  ///< the value this parameter takes in a reference run
  std::optional<ParamValue> in_replay;     ///< the value this parameter takes where a run writes no file
  bool tunable = false;                    ///< it may be set while a session runs
  std::optional<Role> as_in;               ///< where a graph gives none, the value that its node of that role has
  std::vector<ParamValue> coarser;         ///< coarser values, each more so than the one before
  /// Why the node does not read it, given the values of all its parameters, or empty where it does; null: it always
  /// reads it.
  std::function<std::string(const std::vector<ParamValue>&, const ParamUse&)> unread;
  std::function<void(void* params, const ParamValue&)> assign;
};

/// When a message at an input makes the node step.
enum class Trigger : std::uint8_t {
  no,          ///< never; the newest is there when something else makes the node step
  yes,         ///< always
  when_alone,  ///< only where no input with `yes` is connected
};

/// The first value of `info.coarser` that lies beyond `value`: of numbers, in the direction in which they go; else the
/// one after it, or the first where it is not among them. None where there is none.
std::optional<ParamValue> next_coarser(const ParamInfo& info, const ParamValue& value);

struct InputInfo {
  std::string name;
  const MessageType* type = nullptr;
  std::string doc;
  Trigger trigger = Trigger::no;
  bool required = true;
  Queue queue{};             ///< the policy of an edge that names none
  bool in_reference = true;  ///< false: a reference run does without it, and without what only feeds it
  bool reference = false;    ///< what arrives here in the reference run is the truth for the sink
  bool judged = false;       ///< the sink compares what arrives here with that truth
  /// Why the input is not read under these parameter values (by index), or empty where it is.
  std::function<std::string(const std::vector<ParamValue>&)> ignored;
  std::function<InputBase&(Node&)> access;
  /// Why a scene makes the input required that others are not, or empty where it does not.
  std::function<std::string(const Scene&)> needed{};
  /// Why a scene has nothing to send there, or empty where it has.
  std::function<std::string(const Scene&)> unneeded{};
  /// A kind of messages (see OutputInfo) that the input does not take, and what to do instead.
  std::string refused_kind{}, refused_why{};
  std::string former{};  ///< what it was called before; empty: always so
};

struct OutputInfo {
  std::string name;
  const MessageType* type = nullptr;
  std::string doc;
  std::function<OutputBase&(Node&)> access;
  /// What all its messages are beside their type, where some inputs do not take that; a word such as `massless`.
  std::string kind{};
  std::string former{};  ///< what it was called before; empty: always so
  /// Where `type` is `any_message()`: the type under the parameter values (by index), which lives as long as the
  /// process. Throws InputError where there is none.
  std::function<const MessageType&(const std::vector<ParamValue>&)> type_of{};
};

/// Which of two values of a metric is the better one.
enum class Better : std::uint8_t { lower, higher, neither };
/// `lower`, `higher` or `neither`.
std::string_view name_of(Better better);

/// What a node meets in a run, as far as it decides which of its metrics it reports.
struct MetricUse {
  bool torque = true;                    ///< the tool of the scene turns
  bool reference = true;                 ///< the run is compared with its reference run
  std::vector<std::string_view> inputs;  ///< those that something feeds
  [[nodiscard]] bool is_fed(std::string_view input) const {
    return std::find(inputs.begin(), inputs.end(), input) != inputs.end();
  }
};

/// A metric that runs report.
struct MetricInfo {
  std::string name;        ///< dotted, and carries the unit; no name is the beginning of another
  std::string unit = "1";  ///< of the value as it is reported
  std::string doc;         ///< one line
  Better better = Better::neither;
  bool summed = false;  ///< nodes add to one value; else the second node's has the node's name in front
  /// The runs that do not report it because of what happens in them: `contact is never lost`; empty: none.
  std::string missing{};
  /// Why the node does not report it, given the values of its parameters, or empty where it does; null: it does.
  std::function<std::string(const std::vector<ParamValue>&, const MetricUse&)> left_out{};
};

/// The keys that every node of a graph may have; no parameter has such a name.
inline constexpr std::array<std::string_view, 8> node_keys{"type",   "python", "cost",     "lane",
                                                           "thread", "policy", "priority", "cpu"};

/// A tunable parameter of another node that a node sets while the run goes on.
struct Setting {
  std::string path;  ///< of the value that says so, among the node's own parameters: `conditions.A`
  std::string text;  ///< `select.use=first`, as Session::set takes it
};

struct NodeInfo;

/// The declaration with the types of all outputs, for a node with these parameter values; the same one where it has no
/// output whose type depends on them. It lives as long as the process. Throws InputError as `type_of` does.
const NodeInfo& with_output_types(const NodeInfo& info, const std::vector<ParamValue>& values);

/// The type that a scene's nodes of another type become, and why.
struct Resolution {
  const NodeInfo* info = nullptr;  ///< lives as long as the process
  std::string reason;              ///< `the moving body tool is a sphere`
};

/// The rate of the haptic loop where a graph does not give one, in Hz.
inline constexpr double default_haptic_rate = 1000;

/// Shows a person a text and waits for the answer: true for yes.
using Ask = std::function<bool(const std::string& text)>;

/// A node type.
struct NodeInfo {
  std::string type;     ///< `library.name`
  std::string summary;  ///< one line
  std::string details;  ///< prose for the reference: equations, sources, when to use it
  /// Of a class in a Python file: what a graph says instead of its type, `/home/me/my_nodes.py:Gain`; else empty.
  std::string python{};
  /// Of such a class: a key over its code as it was loaded, on which results depend as they do on libraries.
  std::string code{};
  std::vector<InputInfo> inputs;
  std::vector<OutputInfo> outputs;
  std::vector<ParamInfo> params;
  std::vector<MetricInfo> metrics;  ///< all that the node's report() may set or add to
  Role role = Role::other;
  /// What has to happen in a run before the node works as it goes on to (see Node::warm_since): `its window is full`;
  /// empty: nothing.
  std::string warm_when{};
  bool sink = false;                          ///< it is what a run is made for; never left out for lack of readers
  bool needs_torque = false;                  ///< it makes no sense in a translation-only scene
  bool actuator = false;                      ///< it drives a device: a run starts and stops around it
  bool hardware = false;                      ///< it talks to hardware: it needs `clock: real`
  bool fed = false;                           ///< its messages come from outside of the run; it never steps
  bool realtime_safe = false;                 ///< its steps allocate, lock and wait for nothing
  Lane lane = Lane::pool;                     ///< where it steps when the clock is real, unless the graph says
  std::string thread;                         ///< for Lane::thread: the thread it shares, unless the graph says
  std::vector<std::string> cheaper_types;     ///< that do the same with less: in fewer scenes, or less exactly
  std::optional<std::size_t> rate_parameter;  ///< index of the parameter in Hz that makes the node step at a rate
  bool haptic_rate = false;                   ///< that rate is the graph's, the same in all nodes of the haptic loop
  /// Why a scene does not need the node, or empty where it does.
  std::function<std::string(const Scene&)> unneeded;
  /// Of a type that stands for others: the one that suits a scene, which a plan puts in its place. That one has the
  /// same ports; parameters pass on by name, those that it lacks are dropped, and its others take their defaults.
  std::function<Resolution(const Scene&)> resolve;
  /// Throws InputError where the constructor would (YamlError for errors inside a file that a parameter names), and
  /// tells the same notes. It makes the node and throws it away, unless the type declares a check of its own; neither
  /// touches hardware. Null where `create` is.
  std::function<void(const std::vector<ParamValue>&, const NodeContext&)> check{};
  /// Where a node leads the hand in a run of the context's duration; the values have passed `check`. Empty: the type
  /// leads no hand.
  std::function<HandPath(const std::vector<ParamValue>&, const NodeContext&)> hand_path{};
  /// Of hardware: a line for each attached device that the type recognises, asked without opening any for long. What
  /// keeps devices from being recognised, such as a broken profile, is a line each in `notes`.
  std::function<std::vector<std::string>(std::vector<std::string>& notes)> discover{};
  /// Of hardware: does what the device needs to know where it is, asks before anything moves, and returns what was
  /// done. Throws InputError or RunError. Empty: the device needs none.
  std::function<std::string(const std::vector<ParamValue>&, const Ask&)> calibrate{};
  /// The parameters as the node's struct, and what gives them to a node between two steps; null where none is tunable.
  std::function<std::shared_ptr<const void>(const std::vector<ParamValue>&)> typed{};
  std::function<void(Node&, const void* params)> tune{};
  /// Why the node as it is connected cannot have them, empty where it can, from any thread; null: no reason but those
  /// of `check`.
  std::function<std::string(const Node&, const void* params)> refuses{};
  /// What it may set by its SetRequests; a plan refuses what cannot be set, and keeps the node without readers. Empty:
  /// it sets nothing.
  std::function<std::vector<Setting>(const std::vector<ParamValue>&)> sets{};
  /// Makes the node from values in the order of `params`; null where there is `resolve`. Devices are opened when the
  /// node starts, not here.
  std::function<std::unique_ptr<Node>(const std::vector<ParamValue>&, const NodeContext&)> create;

  [[nodiscard]] const InputInfo* input(std::string_view name) const;
  [[nodiscard]] const OutputInfo* output(std::string_view name) const;
  [[nodiscard]] std::optional<std::size_t> param(std::string_view name) const;
};

}  // namespace tactor
