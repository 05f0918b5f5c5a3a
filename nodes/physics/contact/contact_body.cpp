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

}  // namespace

ContactBody::ContactBody(const Body& body, double spacing, bool sampled, double reach,
                         const MakeMeshDistance& make_distance, Notes* notes)
    : name(body.name), shape(body.shape), motion(body.motion), X_WB(body.X_WB), material(body.material) {
  TriangleMesh mesh;
  if (body.mesh() != nullptr) mesh = load_body_mesh(body, notes);
  try {
    if (body.mesh() == nullptr) {
      distance = shape_distance(shape);
      samples = about("spacing", [&] { return shape_samples(shape, spacing); });
      radius = shape_radius(shape);
      box = shape_box(shape);
      return;
    }
    const Bounds bounds = bounds_of(mesh);
    box = bounds;
    p_BM = bounds.middle();
    for (const Vec3& v : mesh.vertices) radius = std::max(radius, norm(v - p_BM));
    distance = make_distance(mesh, reach);
    if (!sampled) return;
    SurfaceSamples of_surface = spacing > 0 ? about("spacing", [&] { return sample_surface(mesh, spacing); })
                                            : vertex_samples(refine(mesh, bounds.longest() / 8).mesh);
    samples.points = std::move(of_surface.points);
    samples.creases = std::move(of_surface.creases);
  } catch (const ValueError& error) {
    throw ValueError(error.path(), "body '" + body.name + "': " + error.what());
  } catch (const InputError& error) {
    throw InputError("body '" + body.name + "': " + error.what());
  }
}

}  // namespace tactor
