// The builder of node declarations: member pointers in, data out, so that nothing is looked up by string while running.
#pragma once

#include <concepts>
#include <filesystem>
#include <functional>
#include <optional>
#include <type_traits>

#include "framework/core/check.hpp"
#include "framework/node/info.hpp"

namespace tactor {

struct InputOptions {
  std::string doc{};
  Trigger trigger = Trigger::no;
  bool required = true;
  Queue queue{};
  bool in_reference = true;
  bool reference = false;
  bool judged = false;
};

struct RealOptions {
  std::string doc{};
  std::string unit = "1";
  std::optional<double> default_value{};
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool above_min = false;
  std::optional<double> in_reference{};
  std::optional<Role> as_in{};
};

struct IntegerOptions {
  std::string doc{};
  std::optional<std::int64_t> default_value{};
  std::int64_t min = 0;
  std::int64_t max = std::int64_t{1} << 31;
  std::optional<std::int64_t> in_reference{};
  std::optional<Role> as_in{};
};

/// A name for a value of an enumeration.
template <class E>
struct Choice {
  std::string name;
  E value;
};

/// Declares node class N with parameters N::Params (default-constructible) and a constructor
/// N(const N::Params&, const NodeContext&).
template <class N>
class Declare {
  using P = typename N::Params;

 public:
  Declare(std::string type, std::string summary) {
    info_.type = std::move(type);
    info_.summary = std::move(summary);
  }

  Declare& details(std::string text) {
    info_.details = std::move(text);
    return *this;
  }
  /// Its role in the pipeline; sinks and actuators have theirs already.
  Declare& role(Role role) {
    info_.role = role;
    return *this;
  }
  /// Its contacts follow Tactor's own law (see NodeInfo::scene_law).
  Declare& scene_law() {
    info_.scene_law = true;
    return *this;
  }
  /// It is warm (Node::warm_since) not from the start, but only when this has happened: `its window is full`.
  Declare& warms_up(std::string when) {
    info_.warm_when = std::move(when);
    return *this;
  }
  Declare& sink() {
    info_.sink = true;
    return role(Role::sink);
  }
  Declare& unneeded(std::function<std::string(const Scene&)> reason) {
    info_.unneeded = std::move(reason);
    return *this;
  }
  /// It drives a device and its steps are real-time safe; it belongs to the real-time lane.
  Declare& actuator() {
    info_.actuator = true;
    info_.lane = Lane::realtime;
    return role(Role::device).realtime_safe();
  }
  /// It talks to hardware, so it runs only with `clock: real`.
  Declare& hardware() {
    if (!info_.hardware) info_.hardware.emplace();
    return actuator();
  }
  /// Which devices are attached (see HardwareAccess).
  Declare& discover(std::function<std::vector<std::string>(std::vector<std::string>&)> list) {
    TACTOR_DEMAND(info_.hardware);
    info_.hardware->discover = std::move(list);
    return *this;
  }
  /// How the device is calibrated (see HardwareAccess).
  Declare& calibrate(std::function<std::string(const P&, const Ask&)> work) {
    TACTOR_DEMAND(info_.hardware);
    auto params = params_;
    info_.hardware->calibrate = [params, work](const ParamValues& values, const Ask& ask) {
      return work(assign_all(*params, values), ask);
    };
    return *this;
  }
  /// For a node that is slow to make: refuses what the constructor would refuse, and tells the same notes, in less time
  /// (see Making). A test compares the two.
  Declare& check(std::function<void(const P&, const NodeContext&)> check) {
    auto params = params_;
    making().check = [params, check](const ParamValues& values, const NodeContext& context) {
      check(assign_all(*params, values), context);
    };
    return *this;
  }
  /// The path along which it leads the hand (see NodeInfo::hand_path).
  Declare& hand_path(std::function<HandPath(const P&, const NodeContext&)> path) {
    auto params = params_;
    info_.hand_path = [params, path](const ParamValues& values, const NodeContext& context) {
      return path(assign_all(*params, values), context);
    };
    return *this;
  }
  /// The scene that it brings itself, and the tool of that scene (see NodeInfo::own_scene, own_tool).
  Declare& own_scene(std::function<OwnScene(const P&)> scene, std::function<OwnTool(const P&)> tool) {
    auto params = params_;
    info_.own_scene = [params, scene](const ParamValues& values) { return scene(assign_all(*params, values)); };
    info_.own_tool = [params, tool](const ParamValues& values) { return tool(assign_all(*params, values)); };
    return *this;
  }
  /// Its messages come from outside of the run (Session::feed); it never steps.
  Declare& fed() {
    info_.fed = true;
    return *this;
  }
  /// The parameters `names` may be set while a session runs. N has `void tune(const Params&)`. It is called between two
  /// steps, on the thread that makes them, with all parameters; in the real-time lane it must not allocate, lock or
  /// wait. A change that would make the force jump must be reached over some time. If N has `std::string refuses(const
  /// Params&) const`, it is called before, on any thread, and returns why the node cannot take them; empty: it can.
  Declare& tunable(std::initializer_list<std::string_view> names) {
    for (const std::string_view name : names) declared(name).tunable = true;
    auto params = params_;
    Tuning& tuning = info_.tuning.emplace();
    tuning.typed = [params](const ParamValues& values) -> std::shared_ptr<const void> {
      return std::make_shared<const P>(assign_all(*params, values));
    };
    tuning.tune = [](Node& node, const void* values) { own(node).tune(*static_cast<const P*>(values)); };
    if constexpr (requires(const N& node, const P& values) { node.refuses(values); }) {
      tuning.refuses = [](const Node& node, const void* values) {
        return own(node).refuses(*static_cast<const P*>(values));
      };
    }
    return *this;
  }
  /// Which parameters of other nodes it may set by an output of SetRequests (see NodeInfo::sets). A run with such a
  /// node is blind: a page shows neither methods nor parameters.
  Declare& sets(std::function<std::vector<Setting>(const P&)> settings) {
    auto params = params_;
    info_.sets = [params, settings](const ParamValues& values) { return settings(assign_all(*params, values)); };
    return *this;
  }
  /// The value that the parameter `name` takes if a run writes no file, such as a replay, or a session that keeps no
  /// tables.
  Declare& in_replay(std::string_view name, ParamValue value) {
    declared(name).in_replay = std::move(value);
    return *this;
  }
  /// Where a graph gives the parameter `name` no value, it has that of the graph's node of the role `role`.
  Declare& as_in(std::string_view name, Role role) {
    declared(name).as_in = role;
    return *this;
  }
  /// The parameter `name` has that meaning.
  Declare& means(std::string_view name, ParamMeaning meaning) {
    ParamInfo& param = declared(name);
    const bool is_time = meaning == ParamMeaning::ramp || meaning == ParamMeaning::settling_time;
    TACTOR_DEMAND(is_time ? param.kind == ParamKind::real && param.unit == "s" : param.kind == ParamKind::integer);
    param.meaning = meaning;
    return *this;
  }
  /// Its steps do not allocate, lock or wait, so a graph may put it into the real-time lane.
  Declare& realtime_safe() {
    info_.realtime_safe = true;
    return *this;
  }
  /// It is heavy: with `clock: real` it steps on the thread of that name, in turn with the other nodes there.
  Declare& on_thread(std::string name) {
    info_.lane = Lane::thread;
    info_.thread = std::move(name);
    return *this;
  }
  Declare& needs_torque() {
    info_.needs_torque = true;
    return *this;
  }

  /// A cheaper type that can replace this one, with compatible ports. It works in fewer scenes (and refuses the
  /// others), or less exactly. `tactor lean` tries it.
  Declare& cheaper(std::string type) {
    info_.cheaper_types.push_back(std::move(type));
    return *this;
  }
  /// Values of the parameter `name`, each of which may be cheaper and less exact than the one before. `tactor lean`
  /// tries those beyond a graph's own. Numbers go up or go down, and there are at least two.
  Declare& coarser(std::string_view name, std::vector<ParamValue> values) {
    ParamInfo& param = declared(name);
    const bool is_number = param.kind == ParamKind::real || param.kind == ParamKind::integer;
    TACTOR_DEMAND(values.size() >= (is_number ? 2U : 1U));
    param.coarser = std::move(values);
    return *this;
  }

  /// When the parameters `names` do not count (see ParamInfo::unread).
  Declare& unread_when(std::initializer_list<std::string_view> names,
                       std::function<std::string(const P&, const ParamUse&)> why) {
    auto params = params_;
    for (const std::string_view name : names) {
      declared(name).unread = [params, why](const ParamValues& values, const ParamUse& use) {
        return why(assign_all(*params, values), use);
      };
    }
    return *this;
  }

  template <class T>
  Declare& input(std::string name, Input<T> N::*port, InputOptions o) {
    // What a reference run tells is kept as bytes.
    TACTOR_DEMAND(!o.reference || message_type<T>().arrays.empty());
    info_.inputs.push_back({std::move(name),
                            &message_type<T>(),
                            std::move(o.doc),
                            o.trigger,
                            o.required,
                            o.queue,
                            o.in_reference,
                            o.reference,
                            o.judged,
                            {},
                            [port](Node& node) -> InputBase& { return own(node).*port; }});
    return *this;
  }
  /// The input just declared is not read if `test(params)` gives a reason.
  Declare& ignored_when(std::function<std::string(const P&)> test) {
    // The parameters are declared by now or later; the lambda reads them when it is called.
    auto params = params_;
    info_.inputs.back().ignored = [params, test](const ParamValues& values) {
      return test(assign_all(*params, values));
    };
    return *this;
  }
  /// The input just declared is required by scenes for which `reason(scene)` is not empty.
  Declare& needed_when(std::function<std::string(const Scene&)> reason) {
    info_.inputs.back().needed = std::move(reason);
    return *this;
  }
  /// The input just declared is left out, with its edges, in scenes for which `reason(scene)` is not empty.
  Declare& unneeded_when(std::function<std::string(const Scene&)> reason) {
    info_.inputs.back().unneeded = std::move(reason);
    return *this;
  }
  /// The input just declared takes no messages of dynamics that are of another law than the scene's; `why` says what
  /// the node does with them.
  Declare& needs_scene_law(std::string why) {
    info_.inputs.back().scene_law_why = std::move(why);
    return *this;
  }
  /// The input `name` rejects messages of outputs of that kind; `why` says what to do instead.
  Declare& refuses(std::string_view name, std::string kind, std::string why) {
    for (InputInfo& input : info_.inputs) {
      if (input.name != name) continue;
      input.refused_kind = std::move(kind);
      input.refused_why = std::move(why);
      return *this;
    }
    TACTOR_DEMAND(!"the input is declared");
    return *this;
  }
  template <class T>
  Declare& output(std::string name, Output<T> N::*port, std::string doc) {
    info_.outputs.push_back({std::move(name), &message_type<T>(), std::move(doc),
                             [port](Node& node) -> OutputBase& { return own(node).*port; }});
    return *this;
  }

  /// An output whose message type follows from the parameters by `type_of`.
  Declare& output(std::string name, AnyOutput N::*port, std::string doc,
                  std::function<const MessageType&(const P&)> type_of) {
    OutputInfo output{std::move(name), &any_message(), std::move(doc),
                      [port](Node& node) -> OutputBase& { return own(node).*port; }};
    auto params = params_;
    output.type_of = [params, type_of](const ParamValues& values) -> const MessageType& {
      return type_of(assign_all(*params, values));
    };
    info_.outputs.push_back(std::move(output));
    return *this;
  }

  /// All messages of the output `name` are of that kind (see OutputInfo::kind).
  Declare& kind(std::string_view name, std::string word) {
    for (OutputInfo& output : info_.outputs) {
      if (output.name != name) continue;
      output.kind = std::move(word);
      return *this;
    }
    TACTOR_DEMAND(!"the output is declared");
    return *this;
  }

  /// A metric that the node's report() sets. `unit` is that of the value, which the name carries too.
  Declare& metric(std::string name, std::string unit, std::string doc, Better better) {
    info_.metrics.push_back({std::move(name), std::move(unit), std::move(doc), better});
    return *this;
  }
  /// A metric with its value: a member, or a function of the node (of N or a base of it) that returns a number, or an
  /// optional one that is empty in a run without the metric.
  template <class Value>
  Declare& metric(std::string name, std::string unit, std::string doc, Better better, Value value) {
    metric(std::move(name), std::move(unit), std::move(doc), better);
    info_.metrics.back().value = [value](const Node& node) -> std::optional<double> {
      const auto found = std::invoke(value, own(node));
      if constexpr (std::is_arithmetic_v<std::remove_const_t<decltype(found)>>) {
        return static_cast<double>(found);
      } else {
        return found;
      }
    };
    return *this;
  }
  /// Nodes add to the metric just declared instead of setting it.
  Declare& summed() {
    info_.metrics.back().summed = true;
    return *this;
  }
  /// A run in which this happens does not report the metric just declared: `contact is never lost`.
  Declare& missing_where(std::string event) {
    info_.metrics.back().missing = std::move(event);
    return *this;
  }
  /// The metric just declared is not reported if `test(params, use)` gives a reason.
  Declare& left_out_when(std::function<std::string(const P&, const MetricUse&)> test) {
    auto params = params_;
    info_.metrics.back().left_out = [params, test](const ParamValues& values, const MetricUse& use) {
      return test(assign_all(*params, values), use);
    };
    return *this;
  }

  /// The parameters and ports `name` were called `before`. The error for a graph with that name says so, and `tactor
  /// migrate` rewrites it.
  Declare& formerly(std::string_view name, const std::string& before) {
    const auto note = [&](auto& list) {
      for (auto& one : list) {
        if (one.name == name) one.former = before;
      }
    };
    note(info_.params);
    note(info_.inputs);
    note(info_.outputs);
    return *this;
  }

  /// A real number, or a Duration (in s) if the member is one.
  template <class M>
  requires std::same_as<M, double> || std::same_as<M, Duration> Declare& real(std::string name, M P::*member,
                                                                              RealOptions o) {
    ParamInfo p = base(std::move(name), ParamKind::real, std::move(o.doc));
    p.unit = std::move(o.unit);
    if (o.default_value) p.default_value = *o.default_value;
    p.min = o.min;
    p.max = o.max;
    p.above_min = o.above_min;
    if (o.in_reference) p.in_reference = *o.in_reference;
    p.as_in = o.as_in;
    p.assign = [member](void* params, const ParamValue& v) {
      if constexpr (std::same_as<M, Duration>) {
        static_cast<P*>(params)->*member = Duration::from_seconds(std::get<double>(v));
      } else {
        static_cast<P*>(params)->*member = std::get<double>(v);
      }
    };
    return push(std::move(p));
  }
  /// A rate in Hz at which the node steps.
  Declare& rate(std::string name, double P::*member, RealOptions o) {
    o.unit = "Hz";
    o.min = 0;
    o.above_min = true;
    info_.rate_parameter = info_.params.size();
    return real(std::move(name), member, std::move(o));
  }
  /// The rate of the haptic loop, at which the node steps. The graph gives it, once for all of its nodes.
  Declare& haptic_rate(double P::*member, RealOptions o) {
    o.default_value = default_haptic_rate;
    info_.haptic_rate = true;
    return rate("rate", member, std::move(o));
  }
  template <std::integral M>
  requires(!std::same_as<M, bool>) Declare& integer(std::string name, M P::*member, IntegerOptions o) {
    ParamInfo p = base(std::move(name), ParamKind::integer, std::move(o.doc));
    if (o.default_value) p.default_value = *o.default_value;
    p.min = static_cast<double>(o.min);
    p.max = static_cast<double>(o.max);
    if (o.in_reference) p.in_reference = *o.in_reference;
    p.as_in = o.as_in;
    p.assign = [member](void* params, const ParamValue& v) {
      static_cast<P*>(params)->*member = static_cast<M>(std::get<std::int64_t>(v));
    };
    return push(std::move(p));
  }
  /// An integer that the node chooses where neither the graph nor `o` gives one; `chosen` says what it takes then.
  template <std::integral M>
  Declare& integer(std::string name, std::optional<M> P::*member, std::string chosen, IntegerOptions o) {
    ParamInfo p = base(std::move(name), ParamKind::integer, std::move(o.doc));
    p.default_value = o.default_value ? ParamValue(*o.default_value) : ParamValue(std::monostate{});
    p.chosen = std::move(chosen);
    p.min = static_cast<double>(o.min);
    p.max = static_cast<double>(o.max);
    p.assign = [member](void* params, const ParamValue& v) {
      const auto* given = std::get_if<std::int64_t>(&v);
      static_cast<P*>(params)->*member = given != nullptr ? std::optional(static_cast<M>(*given)) : std::nullopt;
    };
    return push(std::move(p));
  }
  Declare& boolean(std::string name, bool P::*member, std::optional<bool> default_value, std::string doc,
                   std::optional<Role> as_in = std::nullopt) {
    ParamInfo p = base(std::move(name), ParamKind::boolean, std::move(doc));
    p.as_in = as_in;
    if (default_value) p.default_value = *default_value;
    p.assign = [member](void* params, const ParamValue& v) { static_cast<P*>(params)->*member = std::get<bool>(v); };
    return push(std::move(p));
  }
  Declare& text(std::string name, std::string P::*member, std::optional<std::string> default_value, std::string doc) {
    ParamInfo p = base(std::move(name), ParamKind::text, std::move(doc));
    if (default_value) p.default_value = *default_value;
    p.assign = [member](void* params, const ParamValue& v) {
      static_cast<P*>(params)->*member = std::get<std::string>(v);
    };
    return push(std::move(p));
  }
  /// A file that must exist; `required` false: it may be left out, and the path is then empty. `kind`: where to search
  /// after the folder of the graph.
  Declare& file(std::string name, std::filesystem::path P::*member, bool required, std::string doc,
                FileKind kind = any_file) {
    ParamInfo p = base(std::move(name), ParamKind::file, std::move(doc));
    p.file = std::move(kind);
    if (!required) p.default_value = std::string();
    p.assign = [member](void* params, const ParamValue& v) {
      static_cast<P*>(params)->*member = std::get<std::string>(v);
    };
    return push(std::move(p));
  }
  /// The further files that the file parameter `name` pulls in, given its path (see ParamInfo::includes).
  Declare& includes(std::string_view name,
                    std::function<std::vector<std::filesystem::path>(const std::filesystem::path&)> files) {
    ParamInfo& param = declared(name);
    TACTOR_DEMAND(param.kind == ParamKind::file);
    param.includes = std::move(files);
    return *this;
  }
  template <class E>
  requires std::is_enum_v<E> Declare& choice(std::string name, E P::*member, std::vector<Choice<E>> choices,
                                             std::optional<E> default_value, std::string doc,
                                             std::optional<E> in_reference = std::nullopt,
                                             std::optional<Role> as_in = std::nullopt) {
    ParamInfo p = base(std::move(name), ParamKind::choice, std::move(doc));
    p.as_in = as_in;
    for (const Choice<E>& c : choices) {
      p.choices.push_back(c.name);
      if (default_value && *default_value == c.value) p.default_value = c.name;
      if (in_reference && *in_reference == c.value) p.in_reference = c.name;
    }
    p.assign = [member, choices = std::move(choices)](void* params, const ParamValue& v) {
      for (const Choice<E>& c : choices) {
        if (c.name == std::get<std::string>(v)) static_cast<P*>(params)->*member = c.value;
      }
    };
    return push(std::move(p));
  }
  /// A list of numbers; `size` 0: of any length. Bounds hold for each.
  Declare& reals(std::string name, std::vector<double> P::*member, std::size_t size,
                 std::optional<std::vector<double>> default_value, RealOptions o) {
    ParamInfo p = base(std::move(name), ParamKind::reals, std::move(o.doc));
    p.unit = std::move(o.unit);
    p.size = size;
    p.min = o.min;
    p.max = o.max;
    p.above_min = o.above_min;
    if (default_value) p.default_value = *default_value;
    p.assign = [member](void* params, const ParamValue& v) {
      static_cast<P*>(params)->*member = std::get<std::vector<double>>(v);
    };
    return push(std::move(p));
  }
  Declare& table(std::string name, Table P::*member, std::vector<ColumnInfo> columns, bool required, std::string doc) {
    ParamInfo p = base(std::move(name), ParamKind::table, std::move(doc));
    if (!required) p.default_value = Table{columns.size(), {}};
    p.columns = std::move(columns);
    p.assign = [member](void* params, const ParamValue& v) { static_cast<P*>(params)->*member = std::get<Table>(v); };
    return push(std::move(p));
  }
  Declare& mapping(std::string name, Mapping P::*member, bool required, std::string doc) {
    ParamInfo p = base(std::move(name), ParamKind::mapping, std::move(doc));
    if (!required) p.default_value = Mapping{};
    p.assign = [member](void* params, const ParamValue& v) { static_cast<P*>(params)->*member = std::get<Mapping>(v); };
    return push(std::move(p));
  }

  /// The finished declaration.
  [[nodiscard]] NodeInfo info() const {
    NodeInfo info = info_;
    auto params = params_;
    auto& making = std::get<Making>(info.nature);
    making.create = [params](const ParamValues& values, const NodeContext& context) {
      return std::make_unique<N>(assign_all(*params, values), context);
    };
    if (!making.check) {
      making.check = [create = making.create](const ParamValues& values, const NodeContext& context) {
        create(values, context);
      };
    }
    return info;
  }

 private:
  Making& making() { return std::get<Making>(info_.nature); }
  /// The node as one of the declared class. A node of another one, such as a wrapper, is a mistake in a program.
  static N& own(Node& node) {
    auto* mine = dynamic_cast<N*>(&node);
    TACTOR_DEMAND(mine != nullptr);
    return *mine;
  }
  static const N& own(const Node& node) {
    const auto* mine = dynamic_cast<const N*>(&node);
    TACTOR_DEMAND(mine != nullptr);
    return *mine;
  }
  ParamInfo& declared(std::string_view name) {
    const auto param =
        std::find_if(info_.params.begin(), info_.params.end(), [&](const auto& p) { return p.name == name; });
    TACTOR_DEMAND(param != info_.params.end());
    return *param;
  }
  static ParamInfo base(std::string name, ParamKind kind, std::string doc) {
    ParamInfo p;
    p.name = std::move(name);
    p.kind = kind;
    p.doc = std::move(doc);
    return p;
  }
  Declare& push(ParamInfo p) {
    params_->push_back(p);
    info_.params.push_back(std::move(p));
    return *this;
  }
  static P assign_all(const std::vector<ParamInfo>& params, const ParamValues& values) {
    TACTOR_DEMAND(params.size() == values.size());
    P result{};
    for (std::size_t i = 0; i < params.size(); ++i) params[i].assign(&result, values[i]);
    return result;
  }

  NodeInfo info_;
  // Shared with the lambdas above, so that `ignored_when` may come before the parameters it reads.
  std::shared_ptr<std::vector<ParamInfo>> params_ = std::make_shared<std::vector<ParamInfo>>();
};

}  // namespace tactor
