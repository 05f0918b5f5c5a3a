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
#include "framework/core/own_scene.hpp"
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

/// A checked parameter value in SI units; std::monostate: the graph gives none, and the node chooses.
using ParamValue =
    std::variant<bool, std::int64_t, double, std::string, std::vector<double>, Table, Mapping, std::monostate>;
/// The values of a node, in the order of its type's parameters.
using ParamValues = std::vector<ParamValue>;

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

/// The surroundings of a node in a graph that decide which of its parameters count.
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
  prediction,     ///< predicts the next forces, or fits the coefficients for it
  interpolation,  ///< makes the force between two physics results
  force_field,    ///< makes the force from the position of the device
  sink,           ///< uses the results, such as metrics; a run exists for its sinks
};
inline constexpr std::size_t role_count = 10;
/// `force_field`.
std::string_view name_of(Role role);
/// The role of that name; Role::other where there is none.
Role role_of(std::string_view name);

/// What a parameter means to rules over several nodes.
enum class ParamMeaning : std::uint8_t {
  other,
  ramp,             ///< s: the time in which a new value of the node is reached
  settling_time,    ///< s: the time that a node which sets others gives them before it goes on
  answer_button,    ///< the device's button that answers, 1 for its first one; 0: none
  dead_man_button,  ///< the device's button that a person must hold, 1 for its first one; 0: none; std::monostate: its
                    ///< first one, where it has one
};

/// A parameter of a node type.
struct ParamInfo {
  std::string name;
  ParamKind kind = ParamKind::real;
  std::string unit = "1";                                 ///< the SI unit of the value
  std::optional<ParamValue> default_value;                ///< absent: the parameter must be given
  std::string chosen;                                     ///< where the node chooses: what, in a few words
  double min = -std::numeric_limits<double>::infinity();  ///< smallest value allowed, or see `above_min`
  double max = std::numeric_limits<double>::infinity();   ///< largest value allowed
  bool above_min = false;                                 ///< true: the value must be larger than `min`
  std::vector<std::string> choices;
  std::vector<ColumnInfo> columns;
  std::size_t size = 0;
  FileKind file;                           ///< of a file: where those of the user and the program lie
  std::string doc;                         ///< one line
  std::string former;                      ///< its earlier name; empty: none
  std::optional<ParamValue> in_reference;  ///< the value this parameter takes in a reference run
  std::optional<ParamValue> in_replay;     ///< the value this parameter takes where a run writes no file
  bool tunable = false;                    ///< it may be set while a session runs
  ParamMeaning meaning = ParamMeaning::other;
  std::optional<Role> as_in;        ///< if a graph gives no value: take that of its node of this role
  std::vector<ParamValue> coarser;  ///< coarser values, each coarser than the one before
  /// Of a file: the further files that its content names, on which results depend as on the file itself; null: none.
  /// Throws InputError where the content cannot be read.
  std::function<std::vector<std::filesystem::path>(const std::filesystem::path&)> includes;
  /// The reason why the node does not read it, given the values of all its parameters, or empty if it does; null: it
  /// always reads it.
  std::function<std::string(const ParamValues&, const ParamUse&)> unread;
  std::function<void(void* params, const ParamValue&)> assign;
};

/// When a message at an input makes the node step.
enum class Trigger : std::uint8_t {
  no,          ///< never; the node finds the newest message when something else makes it step
  yes,         ///< always
  when_alone,  ///< only if no input with `yes` is connected
};

/// The first value of `info.coarser` beyond `value`: for numbers, in the direction of the list; otherwise the one after
/// it, or the first if `value` is not in the list. Empty if there is no such value.
std::optional<ParamValue> next_coarser(const ParamInfo& info, const ParamValue& value);

struct InputInfo {
  std::string name;
  const MessageType* type = nullptr;
  std::string doc;
  Trigger trigger = Trigger::no;
  bool required = true;
  Queue queue{};             ///< the policy of an edge that names none
  bool in_reference = true;  ///< false: a reference run does without it, and without what only feeds it
  bool reference = false;    ///< the messages here in the reference run are the truth for the sink
  bool judged = false;       ///< the sink compares the messages here with that truth
  /// The reason why the input is not read under these parameter values (by index), or empty if it is.
  std::function<std::string(const ParamValues&)> ignored;
  std::function<InputBase&(Node&)> access;
  /// The reason why a scene requires the input although others do not, or empty if it does not.
  std::function<std::string(const Scene&)> needed{};
  /// The reason why a scene has nothing to send there, or empty if it has.
  std::function<std::string(const Scene&)> unneeded{};
  /// A kind of messages (see OutputInfo) that the input does not take, and what to do instead.
  std::string refused_kind{}, refused_why{};
  std::string former{};  ///< what it was called before; empty: always so
  /// The reason why its messages may not come from physics of another law (see NodeInfo::scene_law); empty: they may.
  std::string scene_law_why{};
};

struct OutputInfo {
  std::string name;
  const MessageType* type = nullptr;
  std::string doc;
  std::function<OutputBase&(Node&)> access;
  /// A tag that all messages of the output carry and that some inputs reject; a word such as `massless`.
  std::string kind{};
  std::string former{};  ///< what it was called before; empty: always so
  /// Where `type` is `any_message()`: the type under the parameter values (by index), which lives as long as the
  /// process. Throws InputError where there is none.
  std::function<const MessageType&(const ParamValues&)> type_of{};
};

/// Which of two values of a metric is the better one; near_zero: that of the smaller size.
enum class Better : std::uint8_t { lower, higher, near_zero, neither };
/// `lower`, `higher`, `near zero` or `neither`.
std::string_view name_of(Better better);

/// The surroundings of a node in a run that decide which of its metrics it reports.
struct MetricUse {
  bool torque = true;                    ///< the tool of the scene turns
  bool reference = true;                 ///< the run is compared with its reference run
  bool whole = true;                     ///< the run has an end of its own, so a node may keep all of it
  std::vector<std::string_view> inputs;  ///< the connected inputs
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
  bool summed = false;  ///< nodes add to one value; else the name of a second one gets its node's name in front
  /// The runs that do not report it because of what happens in them: `contact is never lost`; empty: none.
  std::string missing{};
  /// The reason why the node does not report it, given its parameters, or empty if it does; null: it always does.
  std::function<std::string(const ParamValues&, const MetricUse&)> left_out{};
  /// The node's value after a run, none if it has none; null: its report() sets the metric.
  std::function<std::optional<double>(const Node&)> value{};
};

/// The keys that every node of a graph may have; no parameter has such a name.
inline constexpr std::array<std::string_view, 8> node_keys{"type",   "python", "cost",     "lane",
                                                           "thread", "policy", "priority", "cpu"};

/// A tunable parameter of another node that a node sets during the run, and the value.
struct Setting {
  std::string path;       ///< of what says so, among the node's own parameters: `conditions.A`
  std::string parameter;  ///< `select.use`
  std::string value;      ///< `first`, as a graph file has it
  [[nodiscard]] std::string text() const { return parameter + "=" + value; }
};

struct NodeInfo;

/// How nodes of a type are made.
struct Making {
  /// Makes the node. Devices are opened when the node starts, not here.
  std::function<std::unique_ptr<Node>(const ParamValues&, const NodeContext&)> create;
  /// Throws InputError where the constructor would (YamlError for errors inside a file that a parameter names), and
  /// tells the same notes. It makes the node and throws it away, unless the type declares a check of its own; neither
  /// touches hardware.
  std::function<void(const ParamValues&, const NodeContext&)> check;
};

/// How parameters reach a node while a run goes on.
struct Tuning {
  /// Makes the struct of the node's class.
  std::function<std::shared_ptr<const void>(const ParamValues&)> typed;
  /// Passes it to the node between two steps.
  std::function<void(Node&, const void* params)> tune;
  /// The reason why the node cannot take it as it is connected, empty if it can; from any thread. Null: only `check`
  /// gives reasons.
  std::function<std::string(const Node&, const void* params)> refuses;
};

/// The declaration with the types of all outputs, for a node with these parameter values; the same one where it has no
/// output whose type depends on them. It lives as long as the process. Throws InputError as `type_of` does.
const NodeInfo& with_output_types(const NodeInfo& info, const ParamValues& values);

/// The type that replaces a node's type in a scene, and why.
struct Resolution {
  const NodeInfo* info = nullptr;  ///< lives as long as the process
  std::string reason;              ///< `the moving body tool is a sphere`
};

/// Of a type that stands for others.
struct StandIn {
  /// Chooses the type that suits a scene; a plan puts that one in its place. It has the same ports. Parameters pass on
  /// by name; those that it lacks are dropped, and its others take their defaults.
  std::function<Resolution(const Scene&)> resolve;
};

/// The rate of the haptic loop in Hz if a graph gives none.
inline constexpr double default_haptic_rate = 1000;

/// Shows a person a text and waits for the answer: true for yes.
/// The files that a value of the parameter makes results depend on: the file that it names, then those that this one
/// includes; none for other kinds. Throws InputError where such a file cannot be read.
std::vector<std::filesystem::path> files_of(const ParamInfo& info, const ParamValue& value);

using Ask = std::function<bool(const std::string& text)>;

/// What a type that talks to hardware can do with its devices. A function that is null: it cannot.
struct HardwareAccess {
  /// A line for each attached device that the type recognises, without opening any for long. Each problem that keeps
  /// devices from being recognised, such as a broken profile, is a line in `notes`.
  std::function<std::vector<std::string>(std::vector<std::string>& notes)> discover;
  /// Calibrates the device, so that it knows its position. Asks before anything moves, and returns what was done.
  /// Throws InputError or RunError.
  std::function<std::string(const ParamValues&, const Ask&)> calibrate;
};

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
  /// Of dynamics and collision: contacts follow Tactor's own law with the materials of the scene. Physics without it is
  /// physics of another kind, which no node can step again by the scene alone.
  bool scene_law = false;
  /// What has to happen in a run before the node works normally (see Node::warm_since): `its window is full`; empty:
  /// nothing.
  std::string warm_when{};
  bool sink = false;                          ///< it uses results; never left out for lack of readers
  bool needs_torque = false;                  ///< it has no use in a translation-only scene
  bool actuator = false;                      ///< it drives a device: a run starts and stops around it
  bool fed = false;                           ///< its messages come from outside of the run; it never steps
  bool realtime_safe = false;                 ///< its steps allocate, lock and wait for nothing
  Lane lane = Lane::pool;                     ///< where it steps when the clock is real, unless the graph says
  std::string thread;                         ///< for Lane::thread: the thread it shares, unless the graph says
  std::vector<std::string> cheaper_types;     ///< cheaper types for the same: for fewer scenes, or less exact
  std::optional<std::size_t> rate_parameter;  ///< index of the parameter in Hz that makes the node step at a rate
  bool haptic_rate = false;                   ///< that rate is the graph's, the same in all nodes of the haptic loop
  /// The reason why a scene does not need the node, or empty if it does.
  std::function<std::string(const Scene&)> unneeded;
  /// It makes nodes, or stands for types that do.
  std::variant<Making, StandIn> nature;
  std::optional<Tuning> tuning;            ///< none: no parameter is tunable
  std::optional<HardwareAccess> hardware;  ///< it talks to hardware: it needs `clock: real`
  /// The path along which a node leads the hand in a run of the context's duration; the values have passed `check`.
  /// Empty: the type leads no hand.
  std::function<HandPath(const ParamValues&, const NodeContext&)> hand_path{};
  /// The scene that such a node brings itself, for a view or a picture; a run without one never asks. Throws
  /// InputError. Empty: the graph's scene is all there is.
  std::function<OwnScene(const ParamValues&)> own_scene{};
  /// The tool of that scene. A graph asks while it is loaded, and only if no body of its scene moves. Throws
  /// InputError. Empty: the graph's scene needs a tool.
  std::function<OwnTool(const ParamValues&)> own_tool{};
  /// The settings that its SetRequests name by their index. A plan refuses those that cannot be made, and keeps the
  /// node even without readers. Empty: it sets nothing.
  std::function<std::vector<Setting>(const ParamValues&)> sets{};

  /// Dynamics of another law than the scene's.
  [[nodiscard]] bool is_foreign_physics() const { return role == Role::dynamics && !scene_law; }
  /// Null where it makes nodes.
  [[nodiscard]] const StandIn* stand_in() const { return std::get_if<StandIn>(&nature); }
  /// See Making; for types that make nodes.
  [[nodiscard]] std::unique_ptr<Node> create(const ParamValues& values, const NodeContext& context) const {
    return std::get<Making>(nature).create(values, context);
  }
  void check(const ParamValues& values, const NodeContext& context) const {
    std::get<Making>(nature).check(values, context);
  }
  [[nodiscard]] const InputInfo* input(std::string_view name) const;
  [[nodiscard]] const OutputInfo* output(std::string_view name) const;
  [[nodiscard]] std::optional<std::size_t> param(std::string_view name) const;
  /// The first parameter with that meaning.
  [[nodiscard]] std::optional<std::size_t> param(ParamMeaning meaning) const;
};

}  // namespace tactor
