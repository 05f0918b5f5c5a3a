#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "framework/graph/format.hpp"
#include "framework/graph/live_fields.hpp"
#include "framework/graph/plan.hpp"
#include "framework/graph/scene_fields.hpp"
#include "framework/graph/scheduling_words.hpp"
#include "framework/graph/spec.hpp"
#include "framework/graph/values.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace {

using Json = nlohmann::ordered_json;

// The bounds are those of the bare number; a text with a unit is checked by its form alone.
Json number(const std::string& unit, double min, double max, bool above_min) {
  Json bare = {{"type", "number"}};
  if (std::isfinite(min)) bare[above_min ? "exclusiveMinimum" : "minimum"] = min;
  if (std::isfinite(max)) bare["maximum"] = max;
  const Json with_unit = {{"type", "string"}, {"pattern", R"(^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?(\s*\S.*)?$)"}};
  return {{"description", "unit " + unit}, {"unit", unit}, {"anyOf", {bare, with_unit}}};
}

Json number(const std::string& unit) {
  return number(unit, -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), false);
}
Json above_zero(const std::string& unit) {
  return number(unit, 0, INFINITY, true);
}
Json run_duration() {
  Json schema = above_zero("s");
  schema["anyOf"].push_back(Json{{"const", std::string(until_stopped_text)}});
  return schema;
}
Json not_negative(const std::string& unit) {
  return number(unit, 0, INFINITY, false);
}

Json list(const Json& item, std::size_t size) {
  Json schema = {{"type", "array"}, {"items", item}};
  if (size > 0) schema["minItems"] = schema["maxItems"] = size;
  return schema;
}

/// The schema with what it means, and its default where there is one. The unit follows in the text, for editors, and
/// stands under `unit` too, for the reference.
Json said(const std::string& doc, Json schema, const Json& default_value = nullptr) {
  const Json& measured = schema.contains("items") ? schema["items"] : schema;
  const std::string unit = measured.value("unit", "");
  schema["description"] = unit.empty() || unit == "1" ? doc : doc + " (unit " + unit + ")";
  if (!unit.empty()) schema["unit"] = unit;
  if (!default_value.is_null()) schema["default"] = default_value;
  return schema;
}

Json closed(Json properties) {
  return {{"type", "object"}, {"properties", std::move(properties)}, {"additionalProperties", false}};
}

Json value_json(const ParamValue& value) {
  if (const auto* b = std::get_if<bool>(&value)) return *b;
  if (const auto* i = std::get_if<std::int64_t>(&value)) return *i;
  if (const auto* d = std::get_if<double>(&value)) return *d;
  if (const auto* s = std::get_if<std::string>(&value)) return *s;
  if (const auto* v = std::get_if<std::vector<double>>(&value)) return *v;
  return nullptr;
}

Json table_schema(const ParamInfo& param) {
  Json columns = Json::object();
  Json required = Json::array();
  Json cells = Json::array();
  for (const ColumnInfo& column : param.columns) {
    columns[column.name] = number(column.unit);
    cells.push_back(number(column.unit));
    if (!column.default_value) required.push_back(column.name);
  }
  Json as_map = closed(columns);
  as_map["required"] = required;
  const Json as_list = {{"type", "array"}, {"prefixItems", cells}, {"items", false}, {"minItems", cells.size()}};
  return {{"type", "array"}, {"items", {{"anyOf", {as_map, as_list}}}}};
}

Json param_schema(const ParamInfo& param) {
  Json schema;
  switch (param.kind) {
    case ParamKind::boolean:
      schema = {{"type", "boolean"}};
      break;
    case ParamKind::integer:
      schema = {{"type", "integer"},
                {"minimum", static_cast<std::int64_t>(param.min)},
                {"maximum", static_cast<std::int64_t>(param.max)}};
      break;
    case ParamKind::real:
      schema = number(param.unit, param.min, param.max, param.above_min);
      break;
    case ParamKind::text:
      // A text that looks like a number is one to an editor.
      schema = {{"type", {"string", "number", "boolean"}}};
      break;
    case ParamKind::choice:
      schema = {{"enum", param.choices}};
      break;
    case ParamKind::file:
      schema = {{"type", "string"}};
      break;
    case ParamKind::reals:
      schema = list(number(param.unit, param.min, param.max, param.above_min), param.size);
      break;
    case ParamKind::table:
      schema = table_schema(param);
      break;
    case ParamKind::mapping:
      schema = {{"type", "object"}, {"additionalProperties", {{"type", {"string", "number", "boolean"}}}}};
      break;
  }
  return said(param.doc, std::move(schema), param.default_value ? value_json(*param.default_value) : Json(nullptr));
}

// A file that extends another takes a value out of it by ~.
Json or_nothing(Json schema) {
  return {{"anyOf", {std::move(schema), {{"type", "null"}}}}};
}

Json whole_number(int min, int max) {
  return {{"type", "integer"}, {"minimum", min}, {"maximum", max}};
}

/// The JSON Schema of described structs; a visitor.
class FieldSchema {
 public:
  /// `with_nothing`: a file that extends another takes a value out of it by ~.
  explicit FieldSchema(bool with_nothing = false) : with_nothing_(with_nothing) {}

  template <class T>
  void field(const char* name, const T& member, const FieldRule& rule) {
    add(name, said(std::string(rule.doc), value(member, rule), usual(member, rule)));
    if (rule.required) required_.push_back(name);
  }
  template <class E>
  void choice(const char* name, E member, const std::vector<std::string>& words, const FieldRule& rule) {
    add(name, said(std::string(rule.doc), {{"enum", words}}, words[static_cast<std::size_t>(member)]));
  }
  template <class Inner>
  void map(const char* name, const FieldRule& rule, const Inner& inner) {
    FieldSchema schema;
    inner(schema);
    add(name, said(std::string(rule.doc), schema.json()));
  }
  template <class Variant, class... Alternatives>
  void one_of(const Variant& /*member*/, const Alternatives&... alternatives) {
    (add(alternatives.name, said(std::string(alternatives.rule.doc), value_of(alternatives))), ...);
    alternatives_ = sizeof...(alternatives);
  }
  template <class T>
  void list_or_one(const char* name, const std::vector<T>& /*member*/, const FieldRule& rule) {
    const Json one = of<T>();
    Json several = list(one, 0);
    several["minItems"] = 1;
    add(name, said(std::string(rule.doc), {{"anyOf", {one, several}}}));
  }
  template <class T>
  void by_name(const char* name, const std::vector<T>& /*member*/, const FieldRule& rule) {
    // A file that extends another takes a named value out of it by ~, and the keys of a body too.
    constexpr bool named = requires(T one) {
      one.name;
    };
    Json one = of<T>(named);
    if (named) {
      one["type"] = {"object", "null"};
    } else {
      one = or_nothing(std::move(one));
    }
    add(name, said(std::string(rule.doc), {{"type", "object"}, {"additionalProperties", std::move(one)}}));
  }
  template <class Inner>
  void only(bool /*applies*/, std::string_view /*otherwise*/, const Inner& inner) {
    inner();
  }

  [[nodiscard]] Json json() const {
    Json schema = closed(properties_);
    if (!required_.empty()) schema["required"] = required_;
    // Nothing but the alternatives of a variant: one of them.
    if (alternatives_ > 0 && alternatives_ == properties_.size()) schema["minProperties"] = schema["maxProperties"] = 1;
    return schema;
  }
  template <Described T>
  static Json of(bool with_nothing = false) {
    FieldSchema schema(with_nothing);
    T value;
    fields(schema, value);
    return schema.json();
  }

 private:
  void add(const char* name, Json schema) {
    properties_[name] = with_nothing_ ? or_nothing(std::move(schema)) : schema;
  }

  static Json of_numbers(const FieldRule& rule) {
    return number(std::string(rule.unit), rule.min, rule.max, rule.above_min);
  }
  static Json value(double /*member*/, const FieldRule& rule) { return of_numbers(rule); }
  static Json value(Duration /*member*/, const FieldRule& rule) { return of_numbers(rule); }
  static Json value(int /*member*/, const FieldRule& rule) {
    return whole_number(static_cast<int>(rule.min), static_cast<int>(rule.max));
  }
  static Json value(bool /*member*/, const FieldRule& /*rule*/) { return {{"type", "boolean"}}; }
  static Json value(const std::string& /*member*/, const FieldRule& /*rule*/) { return {{"type", "string"}}; }
  static Json value(const std::filesystem::path& /*member*/, const FieldRule& /*rule*/) { return {{"type", "string"}}; }
  static Json value(const Vec3& /*member*/, const FieldRule& rule) { return list(of_numbers(rule), 3); }
  template <std::size_t n>
  static Json value(const std::array<double, n>& /*member*/, const FieldRule& rule) {
    return list(of_numbers(rule), n);
  }
  template <class T>
  static Json value(const std::optional<T>& /*member*/, const FieldRule& rule) {
    return value(T{}, rule);
  }
  template <class T>
  requires(has_text<T> || Described<T>) static Json value(const T& /*member*/, const FieldRule& /*rule*/) {
    return of<TextOf<T>>();
  }
  template <class T>
  static Json value_of(const Alternative<T>& /*alternative*/) {
    return of<T>();
  }
  template <class T, class Member>
  static Json value_of(const MemberAlternative<T, Member>& alternative) {
    return value(Member{}, alternative.rule);
  }

  // A default that its own rule refuses stands for none.
  static Json usual(double member, const FieldRule& rule) {
    const bool allowed = !rule.required && member >= rule.min && !(rule.above_min && member == rule.min);
    return allowed ? Json(member) : Json(nullptr);
  }
  static Json usual(int member, const FieldRule& rule) { return member >= rule.min ? Json(member) : Json(nullptr); }
  static Json usual(bool member, const FieldRule& /*rule*/) { return member; }
  static Json usual(Duration member, const FieldRule& rule) { return usual(member.seconds(), rule); }
  static Json usual(const Vec3& member, const FieldRule& rule) {
    return rule.required ? Json(nullptr) : Json{member.x, member.y, member.z};
  }
  template <class T>
  static Json usual(const T& /*member*/, const FieldRule& /*rule*/) {
    return nullptr;
  }

  bool with_nothing_;
  std::size_t alternatives_ = 0;
  Json properties_ = Json::object();
  Json required_ = Json::array();
};

Json cost_schema() {
  const Json jitter =
      said("standard deviation as a fraction of the cost, cut at three of them", number("1", 0, 1, false), 0);
  const Json min = said("the cost is never below", not_negative("s"), 0), max = said("nor above", not_negative("s"));
  const Json constant = closed(
      {{"constant", said("what a step takes", not_negative("s"))}, {"jitter", jitter}, {"min", min}, {"max", max}});
  const Json per_contact =
      closed({{"per_contact", said("for each contact that the step worked on, beside `base`", not_negative("s"))},
              {"base", said("what a step takes without contacts", not_negative("s"), 0)},
              {"jitter", jitter},
              {"min", min},
              {"max", max}});
  // A file that extends another may name the jitter alone, so no key is required.
  const Json trace = closed(
      {{"trace", said("a file of durations in s, one a line, from the start again at its end", {{"type", "string"}})}});
  return said("the time that a step takes under the virtual clock",
              {{"anyOf", {{{"const", "none"}}, constant, per_contact, trace}}}, "none");
}

// Only types that are made for it may be in the realtime lane.
Json lane_schema(const NodeInfo& info) {
  Json lanes = Json::array();
  for (const Lane lane : {Lane::pool, Lane::thread, Lane::realtime}) {
    if (lane != Lane::realtime || (info.realtime_safe && info.rate_parameter)) lanes.push_back(word(lane));
  }
  return said("where it steps when the clock is real", {{"enum", lanes}}, word(info.lane));
}

/// The keys that every node may have, but its type and its lane.
Json node_properties() {
  const Json cost = {{"$ref", "#/$defs/cost"}};
  return {
      {"cost", or_nothing(cost)},
      {"thread", said("with lane `thread`: nodes that name the same thread share it",
                      {{"type", "string"}, {"pattern", "^[A-Za-z]\\w{0,63}$"}})},
      {"policy",
       said("how its thread is scheduled; `fifo` in lane `realtime`, `other` in lane `thread` where it is absent",
            {{"enum", policy_words}})},
      {"priority", said("with `fifo` or `round_robin`: higher comes first; 80 in lane `realtime`, 40 in lane `thread` "
                        "where it is absent",
                        whole_number(lowest_priority, highest_priority))},
      {"cpu", said("the core that its thread is pinned to", whole_number(0, highest_cpu))}};
}

Json bind_schema() {
  Json roles = Json::array();
  for (std::size_t i = 0; i < role_count; ++i) roles.push_back(name_of(static_cast<Role>(i)));
  const Json role = {{"enum", roles}};
  const Json full =
      closed({{"role", said("the only node of that role", role)},
              {"node", said("the node of that name", {{"type", "string"}})},
              {"optional", said("leave out what names it where there is none", {{"type", "boolean"}}, false)}});
  return {{"type", "object"}, {"additionalProperties", {{"anyOf", {role, full}}}}};
}

Json edges_schema() {
  const Json arrow = {{"type", "string"}, {"pattern", R"(^\s*(into\s+)?\w+\.\w+\s*->\s*\w+\.\w+\s*$)"}};
  const Json queue = {{"type", "string"},
                      {"pattern", R"(^(latest|queue\(\s*[1-9]\d*\s*,\s*(drop_oldest|drop_newest|block)\s*\))$)"}};
  const Json end = {{"type", "string"}, {"pattern", R"(^\w+\.\w+$)"}};
  const Json kept = said("`latest`, or `queue(SIZE, POLICY)`; the input's where it is absent", queue);
  const Json optional = said("in a file with `bind`: leave the edge out where the graph below has no such port",
                             {{"type", "boolean"}}, false);
  const Json delay = said("how long after a message became visible it arrives", not_negative("s"), 0);
  Json full = closed({{"from", said("an output, `node.output`", end)},
                      {"to", said("an input, `node.input`", end)},
                      {"queue", kept},
                      {"delay", delay},
                      {"optional", optional}});
  full["required"] = {"from", "to"};
  const Json value = {
      {"anyOf", {{{"type", "null"}}, queue, closed({{"queue", kept}, {"delay", delay}, {"optional", optional}})}}};
  const Json one_entry = {{"type", "object"},
                          {"minProperties", 1},
                          {"maxProperties", 1},
                          {"propertyNames", arrow},
                          {"additionalProperties", value}};
  return {{"type", "array"}, {"items", {{"anyOf", {arrow, one_entry, full}}}}};
}

// Its parameters are in the file, which a schema of the libraries does not know.
Json python_schema() {
  return {{"type", "string"},
          {"pattern", R"(^.+:[^\W\d]\w*$)"},
          {"description", "instead of type: a class in a Python file, FILE.py:Class"}};
}

// `if` the node's type is this one, `then` that.
Json when_type(const std::string& type, Json then) {
  return {{"if", {{"type", "object"}, {"properties", {{"type", {{"const", type}}}}}, {"required", {"type"}}}},
          {"then", std::move(then)}};
}

}  // namespace

std::string graph_schema(Registry& registry) {
  registry.load_all();
  Json definitions = Json::object();
  Json types = Json::array();
  Json by_type = Json::array();
  Json complete = Json::array();
  for (const NodeInfo* info : registry.types()) {
    Json properties = {{"type", {{"const", info->type}, {"description", info->summary}}}, {"lane", lane_schema(*info)}};
    properties.update(node_properties());
    Json required = Json::array();
    for (std::size_t i = 0; i < info->params.size(); ++i) {
      const ParamInfo& param = info->params[i];
      Json schema = param_schema(param);
      // Where the graph gives the rate of the haptic loop, that is the default.
      if (info->haptic_rate && i == info->rate_parameter) schema.erase("default");
      properties[param.name] = or_nothing(std::move(schema));
      if (!param.default_value) required.push_back(param.name);
    }
    definitions[info->type] = closed(properties);
    definitions[info->type]["description"] = info->summary;
    types.push_back(info->type);
    by_type.push_back(when_type(info->type, {{"$ref", "#/$defs/" + info->type}}));
    if (!required.empty()) complete.push_back(when_type(info->type, {{"required", required}}));
  }
  definitions["cost"] = cost_schema();

  Json properties = {{"type", said("the node type", {{"enum", types}})},
                     {"python", python_schema()},
                     {"lane", said("where it steps when the clock is real; the type's where it is absent",
                                   {{"enum", {word(Lane::pool), word(Lane::thread), word(Lane::realtime)}}})}};
  properties.update(node_properties());
  Json node = {{"type", {"object", "null"}}, {"properties", properties}};
  if (!by_type.empty()) node["allOf"] = by_type;
  // Without `extends` nothing can come from elsewhere, so each node must be complete.
  Json whole_node = {{"type", "object"}, {"anyOf", {{{"required", {"type"}}}, {{"required", {"python"}}}}}};
  if (!complete.empty()) whole_node["allOf"] = complete;

  Json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", "Tactor graph"}};
  schema.update(closed(
      {{"format", said("of this file; `tactor migrate` rewrites older ones", {{"const", file_format}})},
       {"title", said("one line of prose", {{"type", "string"}})},
       {"extends", said("a graph file, or several, that this file is laid over",
                        {{"type", {"string", "array"}}, {"items", {{"type", "string"}}}, {"minItems", 1}})},
       {"bind",
        said("in an overlay: names that stand for nodes of the graph below, each with its role where that graph "
             "has no node of the name",
             bind_schema())},
       {"clock", said("`virtual` is deterministic; `real` drives devices in wall time", {{"enum", {"virtual", "real"}}},
                      "virtual")},
       {"duration",
        said("time of the graph's clock to run, or `until stopped` with `clock: real`; required where nothing is "
             "extended",
             run_duration())},
       {"seed", said("every random stream derives from it", {{"type", "integer"}, {"minimum", 0}}, GraphSpec{}.seed)},
       {"rate",
        said("how often the haptic loop runs", number("Hz", lowest_rate, highest_rate, false), default_haptic_rate)},
       {"live", said("what a run with `clock: real` asks of the system", FieldSchema::of<LiveSettings>())},
       {"scene", said("the bodies that nodes act on", FieldSchema::of<Scene>())},
       {"nodes", said("the nodes, by name; beside these keys each has the parameters of its type",
                      {{"type", "object"}, {"additionalProperties", node}})},
       {"edges", said("`from.output -> to.input`, with a queue or a delay behind `:` where needed", edges_schema())},
       {"record", said("the outputs that go into the recording, `node.output`",
                       {{"type", "array"}, {"items", {{"type", "string"}, {"pattern", R"(^\w+\.\w+$)"}}}})}}));
  schema["if"] = {{"not", {{"required", {"extends"}}}}};
  schema["then"] = {{"required", {"duration", "nodes"}},
                    {"properties", {{"nodes", {{"minProperties", 1}, {"additionalProperties", whole_node}}}}}};
  schema["$defs"] = definitions;
  return schema.dump(2) + "\n";
}

}  // namespace tactor
