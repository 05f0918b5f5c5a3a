#include "nodes/scene/body_mesh.hpp"

#include "framework/core/check.hpp"
#include "nodes/scene/mass_properties.hpp"

namespace tactor {

namespace {

TriangleMesh scaled_mesh(const Body& body) {
  TACTOR_DEMAND(body.mesh() != nullptr);
  TriangleMesh mesh = read_off(body.mesh()->file);
  if (const auto scale = body.mesh()->scale) {
    for (Vec3& v : mesh.vertices) v *= *scale;
  }
  return mesh;
}

MassProperties solid_properties(const Body& body, const TriangleMesh& mesh) {
  MassProperties properties = mass_properties(mesh);
  if (!(properties.volume > 0)) {
    throw InputError(body.mesh()->file.string() + ": the mesh of the moving body '" + body.name +
                     "' encloses a volume of " + std::to_string(properties.volume) +
                     " m^3; it must be closed, with faces counter-clockwise as seen from outside");
  }
  return properties;
}

/// A cylinder with two half balls at its ends, along z.
Eigen::Matrix3d capsule_inertia(double mass, const CapsuleShape& capsule) {
  const double r = capsule.radius, l = capsule.length;
  const double cylinder = mass * l / (l + 4.0 / 3.0 * r), ball = mass - cylinder;
  // The centre of a half ball is 3/8 r from its flat side.
  const double across = cylinder * (l * l / 12 + r * r / 4) + ball * (0.4 * r * r + l * l / 4 + 3.0 / 8.0 * l * r);
  const double along = cylinder * r * r / 2 + ball * 0.4 * r * r;
  return Eigen::Vector3d(across, across, along).asDiagonal();
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
  if (const auto* sphere = std::get_if<SphereShape>(&body.shape)) {
    return 0.4 * body.mass * sphere->radius * sphere->radius * Eigen::Matrix3d::Identity();
  }
  if (const auto* box = std::get_if<BoxShape>(&body.shape)) {
    const Vec3 square{box->size.x * box->size.x, box->size.y * box->size.y, box->size.z * box->size.z};
    return body.mass / 12 *
           Eigen::Vector3d(square.y + square.z, square.x + square.z, square.x + square.y).asDiagonal().toDenseMatrix();
  }
  if (const auto* capsule = std::get_if<CapsuleShape>(&body.shape)) return capsule_inertia(body.mass, *capsule);
  const MassProperties properties = solid_properties(body, scaled_mesh(body));
  return body.mass / properties.volume * properties.inertia;
}

}  // namespace tactor
