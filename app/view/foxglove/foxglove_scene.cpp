#include "app/view/foxglove/foxglove_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <nlohmann/json.hpp>

namespace tactor {

namespace {

using nlohmann::json;

constexpr FoxgloveColor fixed_color{0.78, 0.76, 0.72, 1}, moving_color{0.35, 0.55, 0.80, 1},
    handle_color{0.95, 0.65, 0.20, 0.5};
/// Of a plane and of the handle, in sizes of the scene.
constexpr double plane_extent = 10, plane_thickness = 0.01, handle_extent = 0.06;

json vector_object(double x, double y, double z) {
  return {{"x", x}, {"y", y}, {"z", z}};
}

json turn_object(double w, double x, double y, double z) {
  return {{"x", x}, {"y", y}, {"z", z}, {"w", w}};
}

json pose_object(const json& position, const json& orientation) {
  return {{"position", position}, {"orientation", orientation}};
}

/// `[x, y, z, w, x, y, z]` of hello.
json pose_object(const json& pose) {
  return pose_object(vector_object(pose[0], pose[1], pose[2]), turn_object(pose[3], pose[4], pose[5], pose[6]));
}

json color_object(const FoxgloveColor& color) {
  return {{"r", color.r}, {"g", color.g}, {"b", color.b}, {"a", color.a}};
}

const json here = pose_object(vector_object(0, 0, 0), turn_object(1, 0, 0, 0));

json entity_object(const std::string& frame, const std::string& id, std::int64_t time_ns) {
  json entity = {{"timestamp", json::parse(time_text(time_ns))}, {"frame_id", frame},    {"id", id},
                 {"lifetime", {{"sec", 0}, {"nsec", 0}}},        {"frame_locked", true}, {"metadata", json::array()}};
  for (const char* primitives : {"arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models"}) {
    entity[primitives] = json::array();
  }
  return entity;
}

std::string text_of_json(const json& value) {
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string update_text(const std::vector<std::string>& entities) {
  return fmt::format("{{\"deletions\":[],\"entities\":[{}]}}", fmt::join(entities, ","));
}

/// A mesh message of the view.
struct MeshView {
  std::uint32_t vertices = 0, triangles = 0;
  const char* positions = nullptr;
  const char* indices = nullptr;

  explicit MeshView(const std::string& message) {
    std::memcpy(&vertices, message.data() + 8, sizeof vertices);
    std::memcpy(&triangles, message.data() + 12, sizeof triangles);
    positions = message.data() + 16;
    indices = positions + std::size_t{12} * vertices;
  }
  [[nodiscard]] std::array<float, 3> vertex(std::size_t i) const {
    std::array<float, 3> p{};
    std::memcpy(p.data(), positions + 12 * i, sizeof p);
    return p;
  }
  [[nodiscard]] std::uint32_t index(std::size_t i) const {
    std::uint32_t value = 0;
    std::memcpy(&value, indices + 4 * i, sizeof value);
    return value;
  }
};

double half_extent(const MeshView& mesh) {
  std::array<float, 3> low{}, high{};
  for (std::size_t i = 0; i < mesh.vertices; ++i) {
    const std::array<float, 3> p = mesh.vertex(i);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = i == 0 ? p[axis] : std::min(low[axis], p[axis]);
      high[axis] = i == 0 ? p[axis] : std::max(high[axis], p[axis]);
    }
  }
  double largest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) largest = std::max(largest, 0.5 * (high[axis] - low[axis]));
  return largest;
}

double half_extent(const json& body, std::span<const std::string> meshes) {
  if (body.contains("mesh")) return half_extent(MeshView(meshes[body["mesh"].get<std::size_t>()]));
  if (body.contains("sphere")) return body["sphere"]["radius"];
  if (body.contains("capsule")) {
    return body["capsule"]["radius"].get<double>() + 0.5 * body["capsule"]["length"].get<double>();
  }
  if (body.contains("box")) {
    double largest = 0;
    for (const json& side : body["box"]["size"]) largest = std::max(largest, 0.5 * side.get<double>());
    return largest;
  }
  return 0;
}

/// A member `triangles` as text: as objects of json, large meshes would take seconds and hundreds of megabytes.
std::string triangles_text(const MeshView& mesh, const json& pose, const json& color) {
  std::string text = "[{\"pose\":" + pose.dump() + ",\"color\":" + color.dump() + ",\"colors\":[],\"points\":[";
  for (std::size_t i = 0; i < mesh.vertices; ++i) {
    const std::array<float, 3> p = mesh.vertex(i);
    fmt::format_to(std::back_inserter(text), "{}{{\"x\":{},\"y\":{},\"z\":{}}}", i > 0 ? "," : "", p[0], p[1], p[2]);
  }
  text += "],\"indices\":[";
  for (std::size_t i = 0; i < std::size_t{3} * mesh.triangles; ++i) {
    fmt::format_to(std::back_inserter(text), "{}{}", i > 0 ? "," : "", mesh.index(i));
  }
  return text + "]}]";
}

/// A pose that is `height` above `pose` along its z axis.
json above(const json& pose, double height) {
  const double w = pose["orientation"]["w"], x = pose["orientation"]["x"], y = pose["orientation"]["y"],
               z = pose["orientation"]["z"];
  json moved = pose;
  const std::array<double, 3> up{2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)};
  const std::array<const char*, 3> axes{"x", "y", "z"};
  for (std::size_t i = 0; i < 3; ++i) {
    moved["position"][axes[i]] = pose["position"][axes[i]].get<double>() + height * up[i];
  }
  return moved;
}

void add_capsule(json& entity, const json& capsule, const json& pose, const json& color) {
  const double radius = capsule["radius"], length = capsule["length"];
  entity["cylinders"].push_back({{"pose", pose},
                                 {"size", vector_object(2 * radius, 2 * radius, length)},
                                 {"bottom_scale", 1},
                                 {"top_scale", 1},
                                 {"color", color}});
  for (const double end : {-0.5, 0.5}) {
    entity["spheres"].push_back({{"pose", above(pose, end * length)},
                                 {"size", vector_object(2 * radius, 2 * radius, 2 * radius)},
                                 {"color", color}});
  }
}

std::string body_entity(const json& body, std::span<const std::string> meshes, double size) {
  const bool moves = body["moves"];
  const json pose = moves ? here : pose_object(body["pose"]);
  const json color = color_object(moves ? moving_color : fixed_color);
  json entity = entity_object(moves ? body["name"].get<std::string>() : "world", body["name"], 0);
  if (body.contains("mesh")) {
    entity.erase("triangles");
    std::string text = text_of_json(entity);
    text.back() = ',';
    return text + "\"triangles\":" + triangles_text(MeshView(meshes[body["mesh"].get<std::size_t>()]), pose, color) +
           "}";
  } else if (body.contains("sphere")) {
    const double across = 2 * body["sphere"]["radius"].get<double>();
    entity["spheres"].push_back({{"pose", pose}, {"size", vector_object(across, across, across)}, {"color", color}});
  } else if (body.contains("capsule")) {
    add_capsule(entity, body["capsule"], pose, color);
  } else if (body.contains("box")) {
    const json& sides = body["box"]["size"];
    entity["cubes"].push_back(
        {{"pose", pose}, {"size", vector_object(sides[0], sides[1], sides[2])}, {"color", color}});
  } else {
    const double extent = plane_extent * size, thickness = plane_thickness * size;
    entity["cubes"].push_back({{"pose", above(pose, -0.5 * thickness)},
                               {"size", vector_object(extent, extent, thickness)},
                               {"color", color}});
  }
  return text_of_json(entity);
}

/// The turn that brings the x axis onto d, of length `norm`.
json turn_of(const float d[3], double norm) {
  const double x = d[0] / norm, y = d[1] / norm, z = d[2] / norm;
  // Half way between both; against the x axis any turn by 180 degrees about an axis across will do.
  if (x < -0.999999) return turn_object(0, 0, 0, 1);
  const double w = 1 + x, length = std::sqrt(w * w + y * y + z * z);
  return turn_object(w / length, 0, -z / length, y / length);
}

}  // namespace

std::string time_text(std::int64_t time_ns) {
  constexpr std::int64_t second = 1'000'000'000;
  const std::int64_t shown = std::max<std::int64_t>(time_ns, 0);
  return fmt::format("{{\"sec\":{},\"nsec\":{}}}", shown / second, shown % second);
}

double scene_size(const json& hello, std::span<const std::string> meshes) {
  double size = 0;
  for (const json& body : hello["scene"]["bodies"]) size = std::max(size, half_extent(body, meshes));
  return size > 0 ? size : 0.1;
}

std::string bodies_update(const json& hello, std::span<const std::string> meshes) {
  const double size = scene_size(hello, meshes), across = handle_extent * size;
  std::vector<std::string> entities;
  for (const json& body : hello["scene"]["bodies"]) entities.push_back(body_entity(body, meshes, size));
  json handle = entity_object(handle_frame, handle_frame, 0);
  handle["spheres"].push_back(
      {{"pose", here}, {"size", vector_object(across, across, across)}, {"color", color_object(handle_color)}});
  entities.push_back(text_of_json(handle));
  return update_text(entities);
}

std::string arrows_update(const std::string& id, std::int64_t time_ns, const std::vector<FoxgloveArrow>& arrows,
                          const FoxgloveColor& color) {
  json entity = entity_object("world", id, time_ns);
  for (const FoxgloveArrow& arrow : arrows) {
    const double norm = std::hypot(arrow.d[0], arrow.d[1], arrow.d[2]);
    if (!(norm > 0) || !std::isfinite(norm) || !(arrow.length > 0)) continue;
    const double head = 0.25 * arrow.length;
    entity["arrows"].push_back(
        {{"pose", pose_object(vector_object(arrow.p[0], arrow.p[1], arrow.p[2]), turn_of(arrow.d, norm))},
         {"shaft_length", arrow.length - head},
         {"shaft_diameter", 0.06 * arrow.length},
         {"head_length", head},
         {"head_diameter", 0.15 * arrow.length},
         {"color", color_object(color)}});
  }
  return update_text({text_of_json(entity)});
}

}  // namespace tactor
