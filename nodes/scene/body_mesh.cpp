#include "nodes/scene/body_mesh.hpp"

#include "framework/core/check.hpp"
#include "nodes/scene/mass_properties.hpp"

namespace tactor {

namespace {

TriangleMesh scaled_mesh(const Body& body) {
  TACTOR_DEMAND(body.mesh.has_value());
  TriangleMesh mesh = read_off(*body.mesh);
  for (Vec3& v : mesh.vertices) v *= body.scale;
  return mesh;
}

MassProperties solid_properties(const Body& body, const TriangleMesh& mesh) {
  MassProperties properties = mass_properties(mesh);
  if (!(properties.volume > 0)) {
    throw InputError(body.mesh->string() + ": the mesh of the moving body '" + body.name + "' encloses a volume of " +
                     std::to_string(properties.volume) +
                     " m^3; it must be closed, with faces counter-clockwise as seen from outside");
  }
  return properties;
}

}  // namespace

TriangleMesh load_body_mesh(const Body& body) {
  TriangleMesh mesh = scaled_mesh(body);
  if (body.motion != Motion::fixed) {
    const Vec3 center = solid_properties(body, mesh).center;
    for (Vec3& v : mesh.vertices) v -= center;
  }
  return mesh;
}

Eigen::Matrix3d body_inertia(const Body& body) {
  if (body.inertia) return Eigen::Vector3d(body.inertia->x, body.inertia->y, body.inertia->z).asDiagonal();
  if (body.sphere_radius) {
    return 0.4 * body.mass * *body.sphere_radius * *body.sphere_radius * Eigen::Matrix3d::Identity();
  }
  const MassProperties properties = solid_properties(body, scaled_mesh(body));
  return body.mass / properties.volume * properties.inertia;
}

}  // namespace tactor
