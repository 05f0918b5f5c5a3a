#include "app/view/drawn_scene.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "framework/core/value_error.hpp"
#include "nodes/physics/mesh/body_volume.hpp"
#include "nodes/physics/mesh/box_mesh.hpp"
#include "nodes/physics/mesh/turned_mesh.hpp"

namespace tactor {

namespace {

/// Shapes of nodes as shapes of a scene, or as triangles.
class FormReader {
 public:
  /// Sets the shape of `body`, or returns what is drawn in its place.
  DrawnScene::Surface read(const OwnShape& shape, Body& body) {
    if (std::optional<Shape> of_scene = scene_shape(shape)) {
      body.shape = *std::move(of_scene);
      return nullptr;
    }
    if (const auto* cylinder = std::get_if<CylinderShape>(&shape.form)) {
      return std::make_shared<const TriangleMesh>(cylinder_mesh(cylinder->radius, cylinder->length));
    }
    if (const auto* ellipsoid = std::get_if<EllipsoidShape>(&shape.form)) {
      return std::make_shared<const TriangleMesh>(ellipsoid_mesh(ellipsoid->radii));
    }
    const Triangles* triangles = std::get<TrianglesShape>(shape.form).triangles.get();
    // One surface for all shapes that share the triangles.
    DrawnScene::Surface& surface = known_[triangles];
    if (surface == nullptr) {
      surface = std::make_shared<const TriangleMesh>(TriangleMesh{triangles->vertices, triangles->faces});
    }
    return surface;
  }

 private:
  std::map<const Triangles*, DrawnScene::Surface> known_;
};

OwnScene scene_of_node(const NodeSpec& node, const GraphSpec& graph) {
  try {
    return node.info->own_scene(node.params);
  } catch (const YamlError&) {
    throw;
  } catch (const InputError& error) {
    const auto* value = dynamic_cast<const ValueError*>(&error);
    const std::string path = "nodes." + node.name + (value == nullptr ? "" : "." + value->path());
    throw YamlError({{graph.place_of(path), "node " + node.name + ": " + error.what()}});
  }
}

void take_out_body(DrawnScene& drawn, std::size_t body) {
  const auto at = static_cast<std::ptrdiff_t>(body);
  drawn.scene.bodies.erase(drawn.scene.bodies.begin() + at);
  drawn.surfaces.erase(drawn.surfaces.begin() + at);
  drawn.moved.erase(drawn.moved.begin() + at);
}

/// Out of the drawn scene: the bodies of the graph's scene that are bodies of the node.
void take_out_doubles(DrawnScene& drawn, const OwnScene& own, const GraphSpec& graph) {
  if (own.bodies.empty()) return;
  for (const std::size_t i : graph.scene.moving()) {
    const Body& body = graph.scene.bodies[i];
    const bool is_own =
        &body == graph.scene.tool() ||
        std::any_of(own.bodies.begin(), own.bodies.end(), [&](const OwnBody& one) { return one.name == body.name; });
    const std::optional<std::size_t> at = drawn.index_of(body.name);
    if (is_own && at) take_out_body(drawn, *at);
  }
}

void refuse_name(const DrawnScene& drawn, const std::string& name, const NodeSpec& node, const GraphSpec& graph) {
  const std::optional<std::size_t> other = drawn.index_of(name);
  if (!other) return;
  const auto& moved = drawn.moved[*other];
  const std::string path = moved ? "nodes." + moved->node : "scene.bodies." + name;
  throw YamlError(
      {{graph.place_of(path), path + ": it has a body called " + name + ", and node " + node.name + " (" +
                                  node.place.text() + ") brings one of this name; rename one of them or take it out"}});
}

void add_own(DrawnScene& drawn, const OwnScene& own, const NodeSpec& node, const GraphSpec& graph) {
  take_out_doubles(drawn, own, graph);
  for (const OwnBody& body : own.bodies) {
    if (!body.name.empty()) refuse_name(drawn, body.name, node, graph);
  }
  FormReader forms;
  for (const OwnShape& shape : own.shapes) {
    refuse_name(drawn, shape.name, node, graph);
    Body body;
    body.name = shape.name;
    body.X_WB = shape.X_BS;
    std::optional<DrawnScene::Moved> moved;
    if (shape.body) {
      body.motion = Motion::rigid;
      body.X_WB = own.bodies.at(*shape.body).X_WB * shape.X_BS;
      moved = {node.name, own.bodies[*shape.body].name, *shape.body, shape.X_BS};
    }
    DrawnScene::Surface surface = forms.read(shape, body);
    drawn.scene.bodies.push_back(std::move(body));
    drawn.surfaces.push_back(std::move(surface));
    drawn.moved.push_back(std::move(moved));
  }
}

}  // namespace

DrawnScene drawn_scene(const GraphSpec& graph) {
  DrawnScene drawn(graph.scene);
  for (const NodeSpec& node : graph.nodes) {
    if (node.info->own_scene) add_own(drawn, scene_of_node(node, graph), node, graph);
  }
  return drawn;
}

void DrawnScene::put(const std::string& name, bool is_the_tool, const Pose& X_WB) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (!moved[i]) {
      if (scene.bodies[i].name == name) scene.bodies[i].X_WB = X_WB;
    } else if (is_the_tool ? moved[i]->pose == 0 : moved[i]->body == name) {
      scene.bodies[i].X_WB = X_WB * moved[i]->X_BS;
    }
  }
}

bool DrawnScene::has_bodies_beside(const Scene& of) const {
  return std::any_of(moved.begin(), moved.end(), [&of](const std::optional<Moved>& one) {
    return one && one->pose != 0 &&
           std::none_of(of.bodies.begin(), of.bodies.end(), [&](const Body& body) { return body.name == one->body; });
  });
}

std::optional<Pose> DrawnScene::tool_pose() const {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (!is_tool(i)) continue;
    return moved[i] ? scene.bodies[i].X_WB * inverse(moved[i]->X_BS) : scene.bodies[i].X_WB;
  }
  return std::nullopt;
}

TriangleMesh drawn_surface(const DrawnScene& drawn, std::size_t body, Notes* notes) {
  if (drawn.surfaces[body] != nullptr) return *drawn.surfaces[body];
  const Body& of = drawn.scene.bodies[body];
  if (const auto* sphere = std::get_if<SphereShape>(&of.shape)) return capsule_mesh(sphere->radius, 0);
  if (const auto* capsule = std::get_if<CapsuleShape>(&of.shape)) return capsule_mesh(capsule->radius, capsule->length);
  const auto* box = std::get_if<BoxShape>(&of.shape);
  if (box != nullptr && of.motion != Motion::deformable) return box_mesh(box->size);
  return load_body_surface(of, notes);
}

}  // namespace tactor
