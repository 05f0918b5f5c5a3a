#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "framework/graph/format.hpp"
#include "framework/graph/plan.hpp"
#include "framework/graph/scheduling_words.hpp"
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
  return {{"description", "unit " + unit}, {"anyOf", {bare, with_unit}}};
}

Json number(const std::string& unit) {
  return number(unit, -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), false);
}
Json above_zero(const std::string& unit) {
  return number(unit, 0, INFINITY, true);
}
Json not_negative(const std::string& unit) {
  return number(unit, 0, INFINITY, false);
}

Json list(const Json& item, std::size_t size) {
  Json schema = {{"type", "array"}, {"items", item}};
  if (size > 0) schema["minItems"] = schema["maxItems"] = size;
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
  std::string unit;
  if (schema.contains("description")) unit = " (" + schema["description"].get<std::string>() + ")";
  schema["description"] = param.doc + unit;
  if (param.default_value) {
    if (Json value = value_json(*param.default_value); !value.is_null()) schema["default"] = value;
  }
  return schema;
}

// A file that extends another takes a value out of it by ~.
Json or_nothing(Json schema) {
  return {{"anyOf", {std::move(schema), {{"type", "null"}}}}};
}

Json whole_number(int min, int max) {
  return {{"type", "integer"}, {"minimum", min}, {"maximum", max}};
}

/// What only deformable bodies have.
void add_deformable(Json& properties) {
  Json region = closed({{"box", closed({{"low", list(number("m"), 3)}, {"high", list(number("m"), 3)}})},
                        {"behind", closed({{"p", list(number("m"), 3)}, {"n", list(number("1"), 3)}})},
                        {"faces", {{"type", "string"}}}});
  region["minProperties"] = 1;
  region["maxProperties"] = 1;
  Json inclusion = closed({{"p", list(number("m"), 3)}, {"radius", above_zero("m")}, {"young", above_zero("Pa")}});
  inclusion["required"] = {"p", "radius", "young"};
  properties["young"] = above_zero("Pa");
  properties["poisson"] = number("1", 0, 0.495, false);
  properties["density"] = above_zero("kg/m^3");
  properties["damping"] = not_negative("s");
  properties["drag"] = not_negative("1/s");
  properties["tetrahedra"] = whole_number(6, 2'000'000);
  properties["cell_size"] = above_zero("m");
  properties["fixed"] = {{"anyOf", {region, {{"type", "array"}, {"items", region}}}}};
  properties["inclusions"] = {{"type", "object"}, {"additionalProperties", or_nothing(inclusion)}};
}

Json scene_schema() {
  const Json pose = closed(
      {{"p", list(number("m"), 3)}, {"rpy", list(number("rad"), 3)}, {"quaternion", list({{"type", "number"}}, 4)}});
  Json sphere = closed({{"radius", above_zero("m")}});
  sphere["required"] = {"radius"};
  Json capsule = closed({{"radius", above_zero("m")}, {"length", above_zero("m")}});
  capsule["required"] = {"radius", "length"};
  Json box = closed({{"size", list(above_zero("m"), 3)}});
  box["required"] = {"size"};
  const Json material = closed({{"stiffness", above_zero("N/m")},
                                {"damping", not_negative("N s/m")},
                                {"friction", not_negative("1")},
                                {"patch_area", above_zero("m^2")}});
  Json body = closed({{"mesh", {{"type", "string"}}},
                      {"sphere", sphere},
                      {"capsule", capsule},
                      {"box", box},
                      {"plane", closed(Json::object())},
                      {"scale", above_zero("1")},
                      {"pose", pose},
                      {"motion", {{"enum", {"static", "translation", "rigid", "deformable"}}}},
                      {"mass", above_zero("kg")},
                      {"inertia", list(above_zero("kg m^2"), 3)},
                      {"material", material}});
  add_deformable(body["properties"]);
  for (auto& [key, schema] : body["properties"].items()) schema = or_nothing(schema);
  body["type"] = {"object", "null"};
  return closed({{"gravity", list(number("m/s^2"), 3)},
                 {"camera", closed({{"from", list(number("1"), 3)}, {"up", list(number("1"), 3)}})},
                 {"tool", {{"type", "string"}}},
                 {"bodies", {{"type", "object"}, {"additionalProperties", body}}}});
}

Json cost_schema() {
  const Json time = not_negative("s");
  Json constant = closed({{"constant", time}, {"jitter", number("1", 0, 1, false)}, {"min", time}, {"max", time}});
  Json per_contact = closed(
      {{"per_contact", time}, {"base", time}, {"jitter", number("1", 0, 1, false)}, {"min", time}, {"max", time}});
  // A file that extends another may name the jitter alone, so no key is required.
  const Json trace = closed({{"trace", {{"type", "string"}}}});
  return {{"anyOf", {{{"const", "none"}}, constant, per_contact, trace}}};
}

Json live_schema() {
  const Json pool = closed({{"workers", whole_number(1, max_pool_workers)},
                            {"policy", {{"enum", policy_words}}},
                            {"priority", whole_number(lowest_priority, highest_priority)},
                            {"cpu", whole_number(0, highest_cpu)}});
  return closed({{"on_missing_privilege", {{"enum", on_missing_privilege_words}}},
                 {"on_stall", {{"enum", on_stall_words}}},
                 {"stall_timeout", above_zero("s")},
                 {"impose_cost", {{"type", "boolean"}}},
                 {"pool", pool}});
}

// Only types that are made for it may be in the realtime lane.
Json lane_schema(const NodeInfo& info) {
  Json lanes = Json::array();
  for (const Lane lane : {Lane::pool, Lane::thread, Lane::realtime}) {
    if (lane != Lane::realtime || (info.realtime_safe && info.rate_parameter)) lanes.push_back(word(lane));
  }
  return {{"enum", lanes}, {"default", word(info.lane)}, {"description", "where it steps when the clock is real"}};
}

Json edges_schema() {
  const Json arrow = {{"type", "string"}, {"pattern", R"(^\s*(into\s+)?\w+\.\w+\s*->\s*\w+\.\w+\s*$)"}};
  const Json queue = {{"type", "string"},
                      {"pattern", R"(^(latest|queue\(\s*[1-9]\d*\s*,\s*(drop_oldest|drop_newest|block)\s*\))$)"}};
  const Json end = {{"type", "string"}, {"pattern", R"(^\w+\.\w+$)"}};
  Json full = closed({{"from", end}, {"to", end}, {"queue", queue}, {"delay", not_negative("s")}});
  full["required"] = {"from", "to"};
  const Json value = {{"anyOf", {{{"type", "null"}}, queue, closed({{"queue", queue}, {"delay", not_negative("s")}})}}};
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
    Json properties = {{"type", {{"const", info->type}, {"description", info->summary}}},
                       {"cost", or_nothing({{"$ref", "#/$defs/cost"}})},
                       {"lane", lane_schema(*info)},
                       {"thread", {{"type", "string"}, {"pattern", "^[A-Za-z]\\w{0,63}$"}}},
                       {"policy", {{"enum", policy_words}}},
                       {"priority", whole_number(lowest_priority, highest_priority)},
                       {"cpu", whole_number(0, highest_cpu)}};
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

  Json node = {{"type", {"object", "null"}},
               {"properties", {{"type", {{"enum", types}}}, {"python", python_schema()}}}};
  if (!by_type.empty()) node["allOf"] = by_type;
  // Without `extends` nothing can come from elsewhere, so each node must be complete.
  Json whole_node = {{"type", "object"}, {"anyOf", {{{"required", {"type"}}}, {{"required", {"python"}}}}}};
  if (!complete.empty()) whole_node["allOf"] = complete;

  Json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", "Tactor graph"}};
  schema.update(
      closed({{"format", {{"const", file_format}}},
              {"title", {{"type", "string"}}},
              {"extends", {{"type", {"string", "array"}}, {"items", {{"type", "string"}}}, {"minItems", 1}}},
              {"clock", {{"enum", {"virtual", "real"}}}},
              {"duration", above_zero("s")},
              {"seed", {{"type", "integer"}, {"minimum", 0}}},
              {"rate", number("Hz", lowest_rate, highest_rate, false)},
              {"live", live_schema()},
              {"scene", scene_schema()},
              {"nodes", {{"type", "object"}, {"additionalProperties", node}}},
              {"edges", edges_schema()},
              {"record", {{"type", "array"}, {"items", {{"type", "string"}, {"pattern", R"(^\w+\.\w+$)"}}}}}}));
  schema["if"] = {{"not", {{"required", {"extends"}}}}};
  schema["then"] = {{"required", {"duration", "nodes"}},
                    {"properties", {{"nodes", {{"minProperties", 1}, {"additionalProperties", whole_node}}}}}};
  schema["$defs"] = definitions;
  return schema.dump(2) + "\n";
}

}  // namespace tactor
