#include "nodes/physics/contact/contact_body.hpp"

#include <algorithm>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/core/value_error.hpp"
#include "nodes/physics/geometry/shape_distance.hpp"
#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/mesh/refine.hpp"

namespace tactor {

namespace {

double shape_radius(const Shape& shape) {
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) return sphere->radius;
  if (const auto* capsule = std::get_if<CapsuleShape>(&shape)) return capsule->radius + capsule->length / 2;
  if (const auto* box = std::get_if<BoxShape>(&shape)) return norm(box->size) / 2;
  return std::numeric_limits<double>::infinity();
}

Bounds shape_box(const Shape& shape) {
  constexpr double endless = std::numeric_limits<double>::infinity();
  Bounds box;
  const auto add = [&box](const Vec3& half) {
    box.add(-half);
    box.add(half);
  };
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) add({sphere->radius, sphere->radius, sphere->radius});
  if (const auto* capsule = std::get_if<CapsuleShape>(&shape)) {
    add({capsule->radius, capsule->radius, capsule->radius + capsule->length / 2});
  }
  if (const auto* cuboid = std::get_if<BoxShape>(&shape)) add(0.5 * cuboid->size);
  if (std::holds_alternative<PlaneShape>(shape)) {
    box.add({-endless, -endless, -endless});
    box.add({endless, endless, 0});
  }
  return box;
}

/// About how many faces `refine` adds.
double faces_added(const TriangleMesh& mesh, double longest_edge) {
  double added = 0;
  for (const auto& face : mesh.faces) {
    const auto at = [&](std::size_t i) { return mesh.vertices[static_cast<std::size_t>(face[i % 3])]; };
    double longest = 0;
    for (std::size_t i = 0; i < 3; ++i) longest = std::max(longest, norm(at(i + 1) - at(i)));
    if (longest <= longest_edge) continue;
    // Halves of squares whose diagonal is an edge and three quarters of the longest; a row of them where it is narrow.
    const double edge = 0.75 * longest_edge;
    added += 2 * norm(doubled_area_normal(mesh, face)) / (edge * edge) + 2 * longest / edge;
  }
  return added;
}

/// The longest edge between the samples of a mesh that by itself has `own` and meets others with `others`, in m. Twice
/// that of the others does: on a large face their rim leads, and curved meshes have no more samples than before. Long
/// narrow faces have many samples for their area.
double mesh_spacing(const TriangleMesh& mesh, double own, double others) {
  constexpr double most_by_default = 2e5;
  double spacing = std::min(own, 2 * others);
  while (spacing < own && faces_added(mesh, spacing) > most_by_default) spacing = std::min(own, 1.25 * spacing);
  return spacing;
}

}  // namespace

double usual_spacing(const Shape& shape, const TriangleMesh& mesh) {
  return std::holds_alternative<MeshShape>(shape) ? bounds_of(mesh).longest() / 8 : default_spacing(shape);
}

ContactBody::ContactBody(const Body& body, double given, bool sampled, double reach,
                         const MakeMeshDistance& make_distance, Notes* notes)
    : ContactBody(body, body.mesh() != nullptr ? load_body_mesh(body, notes) : TriangleMesh{},
                  Sampling{.mesh = sampled, .given = given}, reach, make_distance) {}

ContactBody::ContactBody(const Body& body, const TriangleMesh& mesh, const Sampling& sampling, double reach,
                         const MakeMeshDistance& make_distance)
    : name(body.name), shape(body.shape), motion(body.motion), X_WB(body.X_WB), material(body.material) {
  try {
    spacing = usual_spacing(shape, mesh);
    if (const auto* cuboid = std::get_if<BoxShape>(&shape)) spacing = box_spacing(*cuboid, sampling.others);
    if (body.mesh() == nullptr) {
      distance = shape_distance(shape);
      samples = about("spacing", [&] { return shape_samples(shape, sampling.given > 0 ? sampling.given : spacing); });
      radius = shape_radius(shape);
      box = shape_box(shape);
      return;
    }
    const Bounds bounds = bounds_of(mesh);
    box = bounds;
    p_BM = bounds.middle();
    for (const Vec3& v : mesh.vertices) radius = std::max(radius, norm(v - p_BM));
    distance = make_distance(mesh, reach);
    if (!sampling.mesh) return;
    spacing = mesh_spacing(mesh, spacing, sampling.others);
    SurfaceSamples of_surface = sampling.given > 0
                                    ? about("spacing", [&] { return sample_surface(mesh, sampling.given); })
                                    : vertex_samples(refine(mesh, spacing).mesh);
    samples.points = std::move(of_surface.points);
    samples.creases = std::move(of_surface.creases);
  } catch (const ValueError& error) {
    throw ValueError(error.path(), "body '" + body.name + "': " + error.what());
  } catch (const InputError& error) {
    throw InputError("body '" + body.name + "': " + error.what());
  }
}

}  // namespace tactor
