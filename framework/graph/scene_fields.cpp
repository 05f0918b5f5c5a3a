#include "framework/graph/scene_fields.hpp"

#include <algorithm>
#include <cmath>

#include "framework/fields/read_fields.hpp"
#include "framework/graph/readers.hpp"
#include "framework/graph/values.hpp"

namespace tactor {

namespace {

Quat about(int axis, double angle) {
  Vec3 r;
  r[axis] = angle;
  return from_rotation_vector(r);
}

double square(const std::array<double, 4>& q) {
  return q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
}

void check_tool(Scene& scene, const FieldCheck& map, const SourceLocation& last,
                const std::vector<std::string>& moving) {
  if (const Tree* tool = map.value("tool")) {
    // One that is no text is told already.
    if (!tool->is_scalar() || map.value("bodies") == nullptr) return;
    scene.tool_name = read_choice(*tool, map.path() + ".tool", moving, map.diagnostics()).value_or("");
  } else if (moving.size() > 1) {
    map.diagnostics().error(last, map.path() + ".bodies: " + list_of(moving) +
                                      " move; expected scene.tool to say which of them hangs on the device");
  }
}

}  // namespace

PoseText as_text(const Pose& X) {
  return {X.p, std::nullopt, std::array{X.R.w, X.R.x, X.R.y, X.R.z}};
}

Pose from_text(const PoseText& text) {
  Pose X{text.p, {}};
  if (text.rpy) X.R = about(2, text.rpy->z) * about(1, text.rpy->y) * about(0, text.rpy->x);
  if (text.quaternion) {
    const auto& [w, x, y, z] = *text.quaternion;
    X.R = {w, x, y, z};
    // A quaternion that is unit to the last digits stays as it is, so that a written pose reads back the same.
    if (std::abs(square(*text.quaternion) - 1) >= 1e-12) X.R = normalized(X.R);
  }
  return X;
}

void check(PoseText& X, const FieldCheck& map) {
  if (X.rpy && X.quaternion) return map.error("", ": expected either rpy or quaternion, found both");
  if (!X.quaternion || std::abs(square(*X.quaternion) - 1) <= 1e-3) return;
  map.error("quaternion", ".quaternion: expected a unit quaternion [w, x, y, z], found one of length " +
                              number_text(std::sqrt(square(*X.quaternion))));
}

void check(BoxRegion& region, const FieldCheck& map) {
  if (!map.is_good()) return;
  for (int i = 0; i < 3; ++i) {
    if (region.low[i] > region.high[i]) return map.error("", ": expected low at or below high along every axis");
  }
}

void check(HalfSpaceRegion& region, const FieldCheck& map) {
  if (map.is_good() && !(norm(region.n) > 0)) map.error("", ".n: expected a normal above zero length");
}

void check(Body& body, const FieldCheck& map) {
  if (body.motion != Motion::fixed && std::holds_alternative<PlaneShape>(body.shape)) {
    map.error("motion", ".motion: a plane has no end and cannot move; expected static");
  }
  if (body.motion == Motion::deformable && map.value("tetrahedra") != nullptr && map.value("cell_size") != nullptr) {
    map.error("cell_size", ": expected either tetrahedra or cell_size, found both");
  }
  if (!body.inertia) return;
  const Vec3& I = *body.inertia;
  // Ten digits of slack for flat bodies, whose largest moment is the sum of the others.
  if (2 * std::max({I.x, I.y, I.z}) > (I.x + I.y + I.z) * (1 + 1e-10)) {
    map.error("inertia", ".inertia: expected moments, each at most the sum of the other two, found " +
                             number_text(I.x) + ", " + number_text(I.y) + ", " + number_text(I.z));
  }
}

void check(Camera& camera, const FieldCheck& map) {
  const double from = norm(camera.from_W), up = norm(camera.up_W);
  if (from == 0 || up == 0 || norm(cross(camera.from_W, camera.up_W)) < 1e-6 * from * up) {
    map.error("", ": expected from and up along different lines");
  }
}

void check(Scene& scene, const FieldCheck& map) {
  const Tree* bodies = map.value("bodies");
  std::vector<std::string> moving;
  SourceLocation last;
  for (std::size_t i = 0; bodies != nullptr && i < bodies->entries.size(); ++i) {
    const TreeEntry& entry = bodies->entries[i];
    const std::string path = map.path() + ".bodies." + entry.key;
    check_name(entry, path, map.diagnostics());
    if (entry.value.is_null()) {
      map.diagnostics().error(
          entry.value.place.line > 0 ? entry.value.place : entry.place,
          path +
              ": expected a body, found nothing; ~ takes out a body of the file that this one extends, "
              "and there is none of that name");
    }
    const auto is_it = [&entry](const Body& body) { return body.name == entry.key; };
    const auto body = std::find_if(scene.bodies.begin(), scene.bodies.end(), is_it);
    if (body == scene.bodies.end() || !body->moves()) continue;
    moving.push_back(entry.key);
    last = entry.place;
  }
  if (moving.size() > max_moving_bodies) {
    map.diagnostics().error(last, map.path() + ".bodies: expected at most " + std::to_string(max_moving_bodies) +
                                      " moving bodies, found " + list_of(moving));
  }
  check_tool(scene, map, last, moving);
}

Scene read_scene(const Tree& tree, const FileFinder& files, Diagnostics& diagnostics) {
  Scene scene;
  read_fields(tree, "scene", scene, files, diagnostics);
  return scene;
}

}  // namespace tactor
