#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "framework/graph/format.hpp"
#include "framework/graph/plan.hpp"
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

/// What only deformable bodies have.
void add_deformable(Json& properties) {
  const Deformable usual;
  Json region = closed(
      {{"box", said("the nodes in a box along the axes", closed({{"low", said("one corner", list(number("m"), 3))},
                                                                 {"high", said("the other", list(number("m"), 3))}}))},
       {"behind", said("the nodes on a plane and behind it",
                       closed({{"p", said("a point of the plane", list(number("m"), 3))},
                               {"n", said("its normal, of any length; behind is against it", list(number("1"), 3))}}))},
       {"faces", said("the nodes of the faces that a file of tetrahedra names so", {{"type", "string"}})}});
  region["minProperties"] = 1;
  region["maxProperties"] = 1;
  Json inclusion = closed({{"p", said("centre, in the frame of the body", list(number("m"), 3))},
                           {"radius", said("radius of the ball", above_zero("m"))},
                           {"young", said("Young's modulus inside", above_zero("Pa"))}});
  inclusion["required"] = {"p", "radius", "young"};
  properties["young"] = said("Young's modulus of a deformable body", above_zero("Pa"), usual.young);
  properties["poisson"] = said("Poisson's ratio of a deformable body", number("1", 0, 0.495, false), usual.poisson);
  properties["density"] = said("mass per volume of a deformable body", above_zero("kg/m^3"), usual.density);
  properties["damping"] =
      said("stress per rate of strain, over the stiffness (Rayleigh's beta)", not_negative("s"), usual.damping);
  properties["drag"] = said("force per velocity, over the mass (Rayleigh's alpha)", not_negative("1/s"), usual.drag);
  properties["tetrahedra"] = said("about so many fill the shape; a file of tetrahedra has its own",
                                  whole_number(6, 2'000'000), usual.tetrahedra);
  properties["cell_size"] = said("length of the edges of tetrahedra, in place of `tetrahedra`", above_zero("m"));
  properties["fixed"] = said("what of a deformable body does not move, in its frame: a region or a list of them",
                             {{"anyOf", {region, {{"type", "array"}, {"items", region}}}}});
  properties["inclusions"] = said("balls of another stiffness in a deformable body, by name",
                                  {{"type", "object"}, {"additionalProperties", or_nothing(inclusion)}});
}

Json pose_schema() {
  return closed({{"p", said("position", list(number("m"), 3), {0, 0, 0})},
                 {"rpy", said("roll, pitch and yaw about the fixed x, y and z", list(number("rad"), 3), {0, 0, 0})},
                 {"quaternion", said("unit quaternion w, x, y, z, in place of `rpy`", list({{"type", "number"}}, 4))}});
}

Json material_schema() {
  const Material usual;
  return closed({{"stiffness", said("of one contact patch", above_zero("N/m"), usual.stiffness)},
                 {"damping", said("of one contact patch", not_negative("N s/m"), usual.damping)},
                 {"friction", said("Coulomb coefficient", not_negative("1"), usual.friction)},
                 {"patch_area", said("the area that a contact patch stands for where a mesh touches a mesh",
                                     above_zero("m^2"), usual.patch_area)}});
}

Json body_schema() {
  Json sphere = closed({{"radius", said("radius", above_zero("m"))}});
  sphere["required"] = {"radius"};
  Json capsule = closed({{"radius", said("radius", above_zero("m"))},
                         {"length", said("length of the segment, without the caps", above_zero("m"))}});
  capsule["required"] = {"radius", "length"};
  Json box = closed({{"size", said("whole edges along x, y and z", list(above_zero("m"), 3))}});
  box["required"] = {"size"};
  Json body = closed(
      {{"mesh", said("shape: the file of a closed triangle mesh", {{"type", "string"}})},
       {"sphere", said("shape: a ball about the body's origin", sphere)},
       {"capsule", said("shape: all points within `radius` of a segment along z", capsule)},
       {"box", said("shape: a cuboid about the body's origin", box)},
       {"plane", said("shape: the half-space z <= 0, written `{}`; it cannot move", closed(Json::object()))},
       {"scale", said("multiplies the mesh's coordinates to give metres; where it is absent they are in m "
                      "and the size must be usual",
                      above_zero("1"))},
       {"pose", said("the body in the world at the start", pose_schema())},
       {"motion", said("how it may move", {{"enum", {"static", "translation", "rigid", "deformable"}}}, "static")},
       {"mass", said("mass of a body that moves as a whole", above_zero("kg"), Body{}.mass)},
       {"inertia", said("principal moments in the body's frame; absent: by the shape", list(above_zero("kg m^2"), 3))},
       {"material", said("its surface in contact", material_schema())}});
  add_deformable(body["properties"]);
  for (auto& [key, schema] : body["properties"].items()) schema = or_nothing(schema);
  body["type"] = {"object", "null"};
  return body;
}

Json scene_schema() {
  const Camera usual;
  const auto numbers = [](const Vec3& v) { return Json{v.x, v.y, v.z}; };
  const Json camera = closed(
      {{"from", said("from the middle of the scene towards the camera", list(number("1"), 3), numbers(usual.from_W))},
       {"up", said("what is up in the picture", list(number("1"), 3), numbers(usual.up_W))}});
  return closed(
      {{"gravity", said("in the world frame", list(number("m/s^2"), 3), numbers(Scene{}.gravity_W))},
       {"camera", said("from where views and pictures look at the scene", camera)},
       {"tool", said("the moving body that hangs on the device; needed where several move", {{"type", "string"}})},
       {"bodies", said("the bodies, by name", {{"type", "object"}, {"additionalProperties", body_schema()}})}});
}

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

Json live_schema() {
  const LiveSettings usual;
  const Json pool =
      closed({{"workers", said("threads of the pool; absent: the run chooses", whole_number(1, max_pool_workers))},
              {"policy", said("as of nodes", {{"enum", policy_words}}, "fifo")},
              {"priority", said("as of nodes; below the devices, above the threads",
                                whole_number(lowest_priority, highest_priority), 50)},
              {"cpu", said("the core of its threads; absent: any", whole_number(0, highest_cpu))}});
  return closed(
      {{"on_missing_privilege",
        said("where `fifo` or locked memory is refused", {{"enum", on_missing_privilege_words}}, "warn")},
       {"on_stall",
        said("where a step does not come back: `stop` ends the run, `recover` keeps the force at zero until it does",
             {{"enum", on_stall_words}}, "stop")},
       {"stall_timeout", said("a step that takes longer has stalled", above_zero("s"), usual.stall_timeout.seconds())},
       {"impose_cost", said("a step takes at least its declared cost", {{"type", "boolean"}}, false)},
       {"pool", said("the threads of all light nodes", pool)}});
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

Json edges_schema() {
  const Json arrow = {{"type", "string"}, {"pattern", R"(^\s*(into\s+)?\w+\.\w+\s*->\s*\w+\.\w+\s*$)"}};
  const Json queue = {{"type", "string"},
                      {"pattern", R"(^(latest|queue\(\s*[1-9]\d*\s*,\s*(drop_oldest|drop_newest|block)\s*\))$)"}};
  const Json end = {{"type", "string"}, {"pattern", R"(^\w+\.\w+$)"}};
  const Json kept = said("`latest`, or `queue(SIZE, POLICY)`; the input's where it is absent", queue);
  const Json delay = said("how long after a message became visible it arrives", not_negative("s"), 0);
  Json full = closed({{"from", said("an output, `node.output`", end)},
                      {"to", said("an input, `node.input`", end)},
                      {"queue", kept},
                      {"delay", delay}});
  full["required"] = {"from", "to"};
  const Json value = {{"anyOf", {{{"type", "null"}}, queue, closed({{"queue", kept}, {"delay", delay}})}}};
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
       {"clock", said("`virtual` is deterministic; `real` drives devices in wall time", {{"enum", {"virtual", "real"}}},
                      "virtual")},
       {"duration", said("time of the graph's clock to run; required where nothing is extended", above_zero("s"))},
       {"seed", said("every random stream derives from it", {{"type", "integer"}, {"minimum", 0}}, GraphSpec{}.seed)},
       {"rate",
        said("how often the haptic loop runs", number("Hz", lowest_rate, highest_rate, false), default_haptic_rate)},
       {"live", said("what a run with `clock: real` asks of the system", live_schema())},
       {"scene", said("the bodies that nodes act on", scene_schema())},
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
