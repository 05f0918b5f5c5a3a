#include "app/view/foxglove/foxglove_schemas.hpp"

#include <nlohmann/json.hpp>

namespace tactor {

namespace {

using nlohmann::ordered_json;
using Members = std::initializer_list<std::pair<const char*, ordered_json>>;

const ordered_json number_schema = {{"type", "number"}};
const ordered_json text_schema = {{"type", "string"}};
const ordered_json flag_schema = {{"type", "boolean"}};

ordered_json object_schema(Members members) {
  ordered_json properties = ordered_json::object();
  for (const auto& [name, schema] : members) properties[name] = schema;
  return {{"type", "object"}, {"properties", std::move(properties)}};
}

ordered_json list_schema(ordered_json of) {
  return {{"type", "array"}, {"items", std::move(of)}};
}

ordered_json time_schema() {
  const ordered_json whole = {{"type", "integer"}, {"minimum", 0}};
  return object_schema({{"sec", whole}, {"nsec", whole}});
}

}  // namespace

std::string scene_update_schema() {
  const ordered_json vector = object_schema({{"x", number_schema}, {"y", number_schema}, {"z", number_schema}});
  const ordered_json turn =
      object_schema({{"x", number_schema}, {"y", number_schema}, {"z", number_schema}, {"w", number_schema}});
  const ordered_json pose = object_schema({{"position", vector}, {"orientation", turn}});
  const ordered_json color =
      object_schema({{"r", number_schema}, {"g", number_schema}, {"b", number_schema}, {"a", number_schema}});
  const ordered_json colors = list_schema(color), points = list_schema(vector),
                     indices = list_schema({{"type", "integer"}, {"minimum", 0}});
  const ordered_json arrow = object_schema({{"pose", pose},
                                            {"shaft_length", number_schema},
                                            {"shaft_diameter", number_schema},
                                            {"head_length", number_schema},
                                            {"head_diameter", number_schema},
                                            {"color", color}});
  const ordered_json solid = object_schema({{"pose", pose}, {"size", vector}, {"color", color}});
  const ordered_json cylinder = object_schema({{"pose", pose},
                                               {"size", vector},
                                               {"bottom_scale", number_schema},
                                               {"top_scale", number_schema},
                                               {"color", color}});
  const ordered_json line = object_schema({{"type", {{"type", "integer"}}},
                                           {"pose", pose},
                                           {"thickness", number_schema},
                                           {"scale_invariant", flag_schema},
                                           {"points", points},
                                           {"color", color},
                                           {"colors", colors},
                                           {"indices", indices}});
  const ordered_json triangles =
      object_schema({{"pose", pose}, {"points", points}, {"color", color}, {"colors", colors}, {"indices", indices}});
  const ordered_json text = object_schema({{"pose", pose},
                                           {"billboard", flag_schema},
                                           {"font_size", number_schema},
                                           {"scale_invariant", flag_schema},
                                           {"color", color},
                                           {"text", text_schema}});
  const ordered_json model = object_schema({{"pose", pose},
                                            {"scale", vector},
                                            {"color", color},
                                            {"override_color", flag_schema},
                                            {"url", text_schema},
                                            {"media_type", text_schema},
                                            {"data", {{"type", "string"}, {"contentEncoding", "base64"}}}});
  const ordered_json entity =
      object_schema({{"timestamp", time_schema()},
                     {"frame_id", text_schema},
                     {"id", text_schema},
                     {"lifetime", time_schema()},
                     {"frame_locked", flag_schema},
                     {"metadata", list_schema(object_schema({{"key", text_schema}, {"value", text_schema}}))},
                     {"arrows", list_schema(arrow)},
                     {"cubes", list_schema(solid)},
                     {"spheres", list_schema(solid)},
                     {"cylinders", list_schema(cylinder)},
                     {"lines", list_schema(line)},
                     {"triangles", list_schema(triangles)},
                     {"texts", list_schema(text)},
                     {"models", list_schema(model)}});
  const ordered_json deletion =
      object_schema({{"timestamp", time_schema()}, {"type", {{"type", "integer"}}}, {"id", text_schema}});
  ordered_json update = object_schema({{"deletions", list_schema(deletion)}, {"entities", list_schema(entity)}});
  update["title"] = "foxglove.SceneUpdate";
  return update.dump();
}

std::string row_schema(const std::string& title, std::span<const std::string> texts,
                       std::span<const std::string> numbers, std::span<const std::string> units) {
  ordered_json schema = object_schema({{"timestamp", time_schema()}});
  schema["title"] = title;
  for (const std::string& text : texts) schema["properties"][text] = text_schema;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const std::size_t dot = numbers[i].find('.');
    ordered_json value = number_schema;
    value["description"] = units[i];
    if (dot == std::string::npos) {
      schema["properties"][numbers[i]] = std::move(value);
      continue;
    }
    ordered_json& group = schema["properties"][numbers[i].substr(0, dot)];
    group["type"] = "object";
    group["properties"][numbers[i].substr(dot + 1)] = std::move(value);
  }
  return schema.dump();
}

}  // namespace tactor
