#include "nodes/physics/mesh/body_mesh.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "framework/core/check.hpp"
#include "framework/core/value_error.hpp"
#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/mesh/mass_properties.hpp"
#include "nodes/physics/mesh/solid_file.hpp"

namespace tactor {

namespace {

std::string joined(const std::vector<std::string>& phrases) {
  std::string text;
  for (const std::string& phrase : phrases) text += (text.empty() ? "" : ", ") + phrase;
  return text;
}

std::string mesh_path(const Body& body) {
  return "scene.bodies." + body.name + ".mesh";
}

/// What decides how large the body is.
std::string size_path(const Body& body) {
  return body.mesh()->scale ? "scene.bodies." + body.name + ".scale" : mesh_path(body);
}

TriangleMesh scaled_mesh(const Body& body, Notes* notes) {
  TACTOR_DEMAND(body.mesh() != nullptr);
  SolidFile solid = [&] {
    try {
      return load_solid(body.mesh()->file);
    } catch (const InputError& error) {
      throw ValueError(mesh_path(body), "body '" + body.name + "': " + error.what());
    }
  }();
  const std::string name = "body '" + body.name + "': " + body.mesh()->file.string();
  if (const auto scale = body.mesh()->scale) {
    for (Vec3& v : solid.mesh.vertices) v *= *scale;
  }
  check_body_size(body, bounds_of(solid.mesh).longest(), notes);
  if (!solid.report.repairs.empty()) add_once(notes, name + ": repaired: " + joined(solid.report.repairs));
  for (const std::string& warning : solid.report.warnings) add_once(notes, name + ": warning: " + warning);
  for (std::string& note : solid.notes) add_once(notes, std::move(note));
  return solid.mesh;
}

MassProperties solid_properties(const Body& body, const TriangleMesh& mesh) {
  MassProperties properties = mass_properties(mesh);
  if (!(properties.volume > 0)) {
    throw ValueError(mesh_path(body), "body '" + body.name + "': " + body.mesh()->file.string() +
                                          ": the mesh of a moving body encloses a volume of " +
                                          std::to_string(properties.volume) +
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

std::string metres(double length) {
  std::array<char, 40> text{};
  const bool small = length < 0.1;
  std::snprintf(text.data(), text.size(), "%.3g %s", small ? 1e3 * length : length, small ? "mm" : "m");
  return text.data();
}

SizeVerdict judge_size(double length, bool has_scale) {
  constexpr double shortest = 1e-3, longest = 10;
  if (length >= shortest && length <= longest) return {};
  const std::string what = "is " + metres(length) + " long";
  // Beyond, collision's floats run over or under.
  if (!(length >= 1e-6 && length <= 1e3)) return {what + "; a body must be 1 um to 1 km long, with its scale", {}};
  if (has_scale) return {{}, what + " with its scale, which is unusual for a body that is touched"};
  return {
      what + (length > longest ? "; is it in mm? write scale: 0.001, or mesh check --unit mm" : "; write its scale") +
          " (the size of one unit of the file in metres; 1 if this length is meant): without scale, a body must be 1 "
          "mm to 10 m long",
      {}};
}

void add_once(Notes* notes, std::string note) {
  if (notes == nullptr || std::find(notes->begin(), notes->end(), note) != notes->end()) return;
  notes->push_back(std::move(note));
}

void check_body_size(const Body& body, double length, Notes* notes) {
  TACTOR_DEMAND(body.mesh() != nullptr);
  const std::string name = "body '" + body.name + "': " + body.mesh()->file.string();
  const SizeVerdict verdict = judge_size(length, body.mesh()->scale.has_value());
  if (!verdict.refusal.empty()) throw ValueError(size_path(body), name + ": " + verdict.refusal);
  if (!verdict.warning.empty()) add_once(notes, name + ": warning: " + verdict.warning);
}

TriangleMesh load_body_mesh(const Body& body, Notes* notes) {
  TriangleMesh mesh = scaled_mesh(body, notes);
  if (body.moves()) {
    const Vec3 center = solid_properties(body, mesh).center;
    for (Vec3& v : mesh.vertices) v -= center;
  }
  return mesh;
}

Eigen::Matrix3d body_inertia(const Body& body, Notes* notes) {
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
  const MassProperties properties = solid_properties(body, scaled_mesh(body, notes));
  return body.mass / properties.volume * properties.inertia;
}

}  // namespace tactor
