#include "nodes/collision/contact_body.hpp"

#include <algorithm>

#include "framework/core/check.hpp"
#include "nodes/collision/shape_distance.hpp"
#include "nodes/scene/body_mesh.hpp"

namespace tactor {

namespace {

double shape_reach(const Shape& shape) {
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) return sphere->radius;
  if (const auto* capsule = std::get_if<CapsuleShape>(&shape)) return capsule->radius + capsule->length / 2;
  if (const auto* box = std::get_if<BoxShape>(&shape)) return norm(box->size) / 2;
  return std::numeric_limits<double>::infinity();
}

}  // namespace

ContactBody::ContactBody(const Body& body, double spacing, const MakeMeshDistance& make_distance)
    : shape(body.shape), motion(body.motion), X_WB(body.X_WB), material(body.material) {
  try {
    if (body.mesh() == nullptr) {
      distance = shape_distance(shape);
      samples = shape_samples(shape, spacing);
      reach = shape_reach(shape);
      return;
    }
    const TriangleMesh mesh = load_body_mesh(body);
    distance = make_distance(mesh, body.mesh()->file.string());
    samples.points = sample_surface(mesh, spacing);
    Vec3 low = mesh.vertices.front(), high = low;
    for (const Vec3& v : mesh.vertices) {
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], v[axis]);
        high[axis] = std::max(high[axis], v[axis]);
      }
    }
    p_BM = 0.5 * (low + high);
    for (const Vec3& v : mesh.vertices) reach = std::max(reach, norm(v - p_BM));
  } catch (const InputError& error) {
    throw InputError("body '" + body.name + "': " + error.what());
  }
}

}  // namespace tactor
