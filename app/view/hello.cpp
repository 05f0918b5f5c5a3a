#include "app/view/hello.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "app/view/hold.hpp"
#include "app/view/samples.hpp"
#include "framework/core/messages.hpp"
#include "framework/graph/scheduling_words.hpp"
#include "framework/graph/texts.hpp"
#include "framework/realtime/safety_gate.hpp"

namespace tactor {

namespace {

using nlohmann::json;

json array_of(const Vec3& v) {
  return json::array({v.x, v.y, v.z});
}

json array_of(const Pose& X) {
  return json::array({X.p.x, X.p.y, X.p.z, X.R.w, X.R.x, X.R.y, X.R.z});
}

/// Two bodies show one mesh where file, scale and frame are the same: that of a moving body lies at its centre of mass.
/// A deformable body has a mesh of its own, the boundary of its tetrahedra. Shapes of nodes share their triangles.
bool same_mesh(const DrawnScene& drawn, std::size_t i, std::size_t j) {
  if (i == j || drawn.surfaces[i] != nullptr || drawn.surfaces[j] != nullptr) {
    return i == j || drawn.surfaces[i] == drawn.surfaces[j];
  }
  const Body &a = drawn.scene.bodies[i], &b = drawn.scene.bodies[j];
  if (a.motion == Motion::deformable || b.motion == Motion::deformable) return false;
  return a.mesh() != nullptr && b.mesh() != nullptr && *a.mesh() == *b.mesh() && a.moves() == b.moves();
}

bool is_shown_as_mesh(const DrawnScene& drawn, std::size_t i) {
  const Body& body = drawn.scene.bodies[i];
  return drawn.surfaces[i] != nullptr || body.mesh() != nullptr || body.motion == Motion::deformable;
}

/// The bodies whose meshes are sent, in this order.
std::vector<std::size_t> mesh_bodies(const DrawnScene& drawn) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < drawn.scene.bodies.size(); ++i) {
    if (!is_shown_as_mesh(drawn, i)) continue;
    const bool known = std::any_of(found.begin(), found.end(), [&](std::size_t j) { return same_mesh(drawn, i, j); });
    if (!known) found.push_back(i);
  }
  return found;
}

/// `meshes`: those of mesh_bodies.
void add_shape(json& object, const DrawnScene& drawn, std::size_t i, const std::vector<std::size_t>& meshes) {
  const Body& body = drawn.scene.bodies[i];
  if (is_shown_as_mesh(drawn, i)) {
    const auto at = std::find_if(meshes.begin(), meshes.end(), [&](std::size_t j) { return same_mesh(drawn, i, j); });
    object["mesh"] = at - meshes.begin();
  } else if (const auto* sphere = std::get_if<SphereShape>(&body.shape)) {
    object["sphere"] = {{"radius", sphere->radius}};
  } else if (const auto* capsule = std::get_if<CapsuleShape>(&body.shape)) {
    object["capsule"] = {{"radius", capsule->radius}, {"length", capsule->length}};
  } else if (const auto* box = std::get_if<BoxShape>(&body.shape)) {
    object["box"] = {{"size", array_of(box->size)}};
  } else {
    object["plane"] = json::object();
  }
}

/// The tool begins at the handle.
json scene_object(const DrawnScene& drawn, const Pose& start) {
  const std::vector<std::size_t> meshes = mesh_bodies(drawn);
  json bodies = json::array();
  for (std::size_t i = 0; i < drawn.scene.bodies.size(); ++i) {
    const Body& body = drawn.scene.bodies[i];
    const bool is_tool = drawn.is_tool(i);
    const auto& moved = drawn.moved[i];
    const Pose X_WB = !is_tool ? body.X_WB : moved ? start * moved->X_BS : start;
    json object = {{"name", body.name}, {"moves", body.moves()}, {"tool", is_tool}, {"pose", array_of(X_WB)}};
    if (body.motion == Motion::deformable) object["deforms"] = true;
    add_shape(object, drawn, i, meshes);
    bodies.push_back(std::move(object));
  }
  const Camera& camera = drawn.scene.camera;
  return {{"bodies", std::move(bodies)},
          {"camera", {{"from", array_of(camera.from_W)}, {"up", array_of(camera.up_W)}}}};
}

json streams_array(const std::vector<ShownStream>& streams) {
  json list = json::array();
  for (const ShownStream& stream : streams) {
    json columns = json::array();
    for (const ShownColumn& column : stream.columns) columns.push_back({{"name", column.name}, {"unit", column.unit}});
    json object = {{"role", stream.role}, {"name", stream.output}, {"columns", std::move(columns)}};
    if (stream.body) object["body"] = *stream.body;
    if (!stream.method.empty()) object["method"] = stream.method;
    list.push_back(std::move(object));
  }
  return list;
}

/// The value of a parameter that a page shows; null for those that it has no knob for.
json knob(const ParamInfo& info, const ParamValue& value) {
  json object = {{"doc", info.doc}, {"unit", info.unit}};
  switch (info.kind) {
    case ParamKind::boolean:
      object["kind"] = "flag";
      object["value"] = std::get<bool>(value);
      return object;
    case ParamKind::integer:
      object["kind"] = "integer";
      object["value"] = std::get<std::int64_t>(value);
      break;
    case ParamKind::real:
      object["kind"] = "real";
      object["value"] = std::get<double>(value);
      break;
    case ParamKind::choice:
      object["kind"] = "choice";
      object["choices"] = info.choices;
      object["value"] = std::get<std::string>(value);
      return object;
    case ParamKind::text:
    case ParamKind::file:
    case ParamKind::reals:
    case ParamKind::table:
    case ParamKind::mapping:
      return nullptr;
  }
  if (std::isfinite(info.min)) object["min"] = info.min;
  if (std::isfinite(info.max)) object["max"] = info.max;
  return object;
}

/// `only`: this parameter alone, where it is given.
json parameters_array(const Plan& plan, const std::map<std::string, std::string>& values,
                      const std::optional<std::string>& only = std::nullopt) {
  json list = json::array();
  for (const NodeSpec& node : plan.nodes) {
    for (std::size_t p = 0; p < node.params.size(); ++p) {
      const ParamInfo& info = node.info->params[p];
      if (!info.tunable) continue;
      const std::string name = node.name + "." + info.name;
      if (only && name != *only) continue;
      const auto changed = values.find(name);
      json object =
          knob(info, changed == values.end() ? node.params[p] : parse_parameter(node, p, changed->second, name));
      if (object.is_null()) continue;
      object["name"] = name;
      list.push_back(std::move(object));
    }
  }
  return list;
}

json nodes_array(const Plan& plan) {
  json list = json::array();
  for (const NodeSpec& node : plan.nodes) {
    list.push_back({{"name", node.name},
                    {"type", node.info->type},
                    {"role", name_of(node.info->role)},
                    {"lane", word(node.scheduling.lane)}});
  }
  return list;
}

json edges_array(const Plan& plan) {
  json list = json::array();
  for (const PlannedEdge& edge : plan.edges) {
    list.push_back({{"name", edge.spec.name()},
                    {"from", edge.spec.from_node},
                    {"to", edge.spec.to_node},
                    {"queue", queue_text(edge.spec.queue)}});
  }
  return list;
}

/// The device that the page shows: the one it leads, or the first.
json device_object(const Plan& plan, const HelloExtras& extras) {
  for (std::size_t n = 0; n < plan.nodes.size(); ++n) {
    const NodeSpec& node = plan.nodes[n];
    if (extras.mouse ? n != *extras.mouse : !node.info->actuator) continue;
    json object = {{"node", node.name}, {"mouse", extras.mouse.has_value()}, {"start", array_of(extras.start)}};
    if (const auto param = node.info->param("force_max")) object["force_max"] = std::get<double>(node.params[*param]);
    return object;
  }
  return {{"mouse", false}, {"start", array_of(extras.start)}};
}

template <class E>
json names_of(int count) {
  json list = json::array();
  for (int i = 0; i < count; ++i) list.push_back(std::string(name_of(static_cast<E>(i))));
  return list;
}

}  // namespace

std::string hello_text(const Plan& plan, const std::vector<ShownStream>& streams, const HelloExtras& extras) {
  std::optional<std::string> answer = extras.replay ? std::nullopt : experiment_of(plan);
  if (answer) *answer += ".answer";
  const auto drawn = extras.drawn ? extras.drawn : std::make_shared<const DrawnScene>(drawn_scene(plan.graph));
  json hello = {{"type", "hello"},
                {"mode", extras.replay ? "replay" : "live"},
                {"graph", plan.graph.name},
                {"title", plan.graph.title},
                {"version", TACTOR_VERSION},
                {"duration", extras.duration},
                {"scene", scene_object(*drawn, extras.start)},
                {"meshes", mesh_bodies(*drawn).size()},
                {"rotates", plan.torque},
                {"device", device_object(plan, extras)},
                {"streams", streams_array(streams)},
                {"engagements", names_of<Engagement>(4)},
                {"causes", names_of<SafetyCause>(safety_cause_count)},
                {"holds", hold_words},
                {"ends", run_end_words},
                {"parameters", extras.replay ? json::array() : parameters_array(plan, extras.values, answer)},
                {"nodes", answer ? json::array() : nodes_array(plan)},
                {"edges", answer ? json::array() : edges_array(plan)}};
  if (answer) {
    hello["experiment"] = {{"answer", *answer}};
    return hello.dump(-1, ' ', false, json::error_handler_t::replace);
  }
  if (const std::optional<MethodSwitch> methods = method_switch(plan)) {
    json choices = json::array();
    for (const MethodSwitch::Choice& choice : methods->choices) {
      choices.push_back({{"value", choice.value}, {"label", choice.label}});
    }
    hello["methods"] = {{"parameter", methods->parameter}, {"choices", std::move(choices)}};
  }
  return hello.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string parameter_value_text(const Plan& plan, const std::string& parameter, const std::string& value) {
  for (const json& knob : parameters_array(plan, {{parameter, value}})) {
    if (knob["name"] == parameter) return knob["value"].dump();
  }
  return "null";
}

std::vector<std::string> mesh_messages(const DrawnScene& drawn, const std::function<void(const std::string&)>& note) {
  std::vector<std::string> messages;
  for (const std::size_t body : mesh_bodies(drawn)) {
    std::vector<std::string> notes;
    const TriangleMesh mesh = drawn_surface(drawn, body, &notes);
    for (const std::string& text : notes) note(text);
    std::vector<float> positions;
    positions.reserve(3 * mesh.vertices.size());
    for (const Vec3& v : mesh.vertices) {
      for (const double x : {v.x, v.y, v.z}) positions.push_back(static_cast<float>(x));
    }
    std::vector<std::uint32_t> indices;
    indices.reserve(3 * mesh.faces.size());
    for (const auto& face : mesh.faces) {
      for (const int vertex : face) indices.push_back(static_cast<std::uint32_t>(vertex));
    }
    messages.push_back(mesh_message(messages.size(), positions, indices));
  }
  return messages;
}

}  // namespace tactor
