#include "nodes/physics/deformable/soft_scene.hpp"

#include <algorithm>
#include <map>

#include "framework/core/check.hpp"
#include "nodes/physics/mesh/body_volume.hpp"

namespace tactor {

namespace {

SoftBody soft_body(const Body& body, Notes* notes) {
  BodyVolume volume = load_body_volume(body, notes);
  for (Vec3& p : volume.mesh.nodes) p = transform(body.X_WB, p);
  const Deformable& d = body.deformable;
  return {.mesh = std::move(volume.mesh),
          .young = std::move(volume.young),
          .poisson = d.poisson,
          .density = d.density,
          .damping = d.damping,
          .drag = d.drag,
          .fixed = std::move(volume.fixed)};
}

std::vector<SoftBody> soft_bodies(const Scene& scene, Notes* notes) {
  std::vector<SoftBody> bodies;
  for (const std::size_t i : scene.deformable()) bodies.push_back(soft_body(scene.bodies[i], notes));
  if (bodies.empty()) throw InputError("dynamics.deformable needs a body with motion: deformable in the scene");
  return bodies;
}

/// The mid-edge nodes of a model by the ends of their edges, the lower one first.
std::map<std::array<int, 2>, int> mid_edges(const ElasticModel& model) {
  std::map<std::array<int, 2>, int> found;
  for (int node = 0; node < model.nodes(); ++node) {
    const std::array<int, 2> ends = model.ends_of(node);
    if (ends[0] != ends[1]) found[{std::min(ends[0], ends[1]), std::max(ends[0], ends[1])}] = node;
  }
  return found;
}

Vec3 rest_of(const ElasticModel& model, int node) {
  const auto at = static_cast<Eigen::Index>(3 * node);
  return {model.rest()[at], model.rest()[at + 1], model.rest()[at + 2]};
}

void add_face(const ElasticModel& model, const std::array<int, 3>& nodes, int body, SoftSurface& surface) {
  const Vec3 a = rest_of(model, nodes[0]), b = rest_of(model, nodes[1]), c = rest_of(model, nodes[2]);
  surface.faces.push_back({nodes[0], nodes[1], nodes[2]});
  surface.body.push_back(body);
  surface.area.push_back(0.5 * norm(cross(b - a, c - a)));
}

SoftSurface surface_of(const ElasticModel& model) {
  SoftSurface surface;
  const auto mid = mid_edges(model);
  const auto middle = [&mid](int a, int b) { return mid.at({std::min(a, b), std::max(a, b)}); };
  for (std::size_t b = 0; b < model.bodies().size(); ++b) {
    const int body = static_cast<int>(b), first = model.first_node(body);
    for (const std::array<int, 3>& face : model.bodies()[b].mesh.faces) {
      const int i = first + face[0], j = first + face[1], k = first + face[2];
      if (model.order() == ElementOrder::linear) {
        add_face(model, {i, j, k}, body, surface);
        continue;
      }
      const int ij = middle(i, j), jk = middle(j, k), ki = middle(k, i);
      add_face(model, {i, ij, ki}, body, surface);
      add_face(model, {ij, j, jk}, body, surface);
      add_face(model, {ki, jk, k}, body, surface);
      add_face(model, {ij, jk, ki}, body, surface);
    }
  }
  return surface;
}

}  // namespace

SoftScene soft_scene(const Scene& scene, const DeformableOptions& options, Notes* notes) {
  SoftScene soft{ElasticModel(soft_bodies(scene, notes), options.law, options.elements), {}, {}, {}};
  soft.surface = surface_of(soft.model);
  for (const auto& face : soft.surface.faces) {
    soft.surface_nodes.insert(soft.surface_nodes.end(), face.begin(), face.end());
  }
  std::sort(soft.surface_nodes.begin(), soft.surface_nodes.end());
  soft.surface_nodes.erase(std::unique(soft.surface_nodes.begin(), soft.surface_nodes.end()), soft.surface_nodes.end());
  for (const int node : soft.surface_nodes) {
    const std::array<int, 2> ends = soft.model.ends_of(node);
    if (ends[0] == ends[1]) soft.shown_nodes.push_back(node);
  }
  return soft;
}

}  // namespace tactor
