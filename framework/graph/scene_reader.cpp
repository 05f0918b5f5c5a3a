#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "framework/graph/deformable_reader.hpp"
#include "framework/graph/readers.hpp"
#include "framework/graph/values.hpp"

namespace tactor {

namespace {

std::optional<Vec3> read_vector(const Tree& tree, const std::string& path, const NumberRule& rule,
                                Diagnostics& diagnostics) {
  const auto values = read_numbers(tree, path, 3, rule, diagnostics);
  if (!values) return std::nullopt;
  return Vec3{(*values)[0], (*values)[1], (*values)[2]};
}

void set_number(double& target, const Tree& map, std::string_view key, const std::string& path, const NumberRule& rule,
                Diagnostics& diagnostics) {
  if (const Tree* tree = map.value(key)) {
    target = read_number(*tree, path + "." + std::string(key), rule, diagnostics).value_or(target);
  }
}

Quat about(int axis, double angle) {
  Vec3 r;
  r[axis] = angle;
  return from_rotation_vector(r);
}

std::optional<Quat> read_quaternion(const Tree& tree, const std::string& path, Diagnostics& diagnostics) {
  const auto q = read_numbers(tree, path, 4, {}, diagnostics);
  if (!q) return std::nullopt;
  const Quat R{(*q)[0], (*q)[1], (*q)[2], (*q)[3]};
  const double square = R.w * R.w + R.x * R.x + R.y * R.y + R.z * R.z;
  if (std::abs(square - 1) > 1e-3) {
    diagnostics.error(tree.place, path + ": expected a unit quaternion [w, x, y, z], found one of length " +
                                      number_text(std::sqrt(square)));
    return std::nullopt;
  }
  // A quaternion that is unit to the last digits stays as it is, so that a written pose reads back the same.
  return std::abs(square - 1) < 1e-12 ? R : normalized(R);
}

Pose read_pose(const Tree& tree, const std::string& path, Diagnostics& diagnostics) {
  Pose X;
  if (!expect_map(tree, path, "a map with p and rpy or quaternion", diagnostics)) return X;
  check_keys(tree, path, "key", {"p", "rpy", "quaternion"}, diagnostics);
  if (const Tree* p = tree.value("p")) {
    X.p = read_vector(*p, path + ".p", {.unit = "m"}, diagnostics).value_or(X.p);
  }
  const Tree* rpy = tree.value("rpy");
  const Tree* quaternion = tree.value("quaternion");
  if (rpy != nullptr && quaternion != nullptr) {
    diagnostics.error(tree.place, path + ": expected either rpy or quaternion, found both");
  } else if (rpy != nullptr) {
    const double turn = 2 * std::numbers::pi;
    const auto angles = read_vector(*rpy, path + ".rpy", {.unit = "rad", .min = -turn, .max = turn}, diagnostics);
    if (angles) X.R = about(2, angles->z) * about(1, angles->y) * about(0, angles->x);
  } else if (quaternion != nullptr) {
    X.R = read_quaternion(*quaternion, path + ".quaternion", diagnostics).value_or(X.R);
  }
  return X;
}

Material read_material(const Tree& tree, const std::string& path, Diagnostics& diagnostics) {
  Material m;
  if (!expect_map(tree, path, "a map with stiffness, damping, friction, patch_area", diagnostics)) return m;
  check_keys(tree, path, "key", {"stiffness", "damping", "friction", "patch_area"}, diagnostics);
  set_number(m.stiffness, tree, "stiffness", path, {.unit = "N/m", .min = 0, .above_min = true}, diagnostics);
  set_number(m.damping, tree, "damping", path, {.unit = "N s/m", .min = 0}, diagnostics);
  set_number(m.friction, tree, "friction", path, {.min = 0}, diagnostics);
  set_number(m.patch_area, tree, "patch_area", path, {.unit = "m^2", .min = 0, .above_min = true}, diagnostics);
  return m;
}

constexpr std::array<const char*, 5> shape_keys{"mesh", "sphere", "capsule", "box", "plane"};

double needed_number(const Tree& map, const char* key, const std::string& path, const NumberRule& rule,
                     Diagnostics& diagnostics) {
  const Tree* tree = map.value(key);
  if (tree == nullptr) {
    diagnostics.error(map.place, path + ": expected the key " + key + ", found none");
    return 1;
  }
  return read_number(*tree, path + "." + key, rule, diagnostics).value_or(1);
}

void read_shape(Body& body, const TreeEntry& entry, const std::string& path, const FileFinder& files,
                Diagnostics& diagnostics) {
  std::vector<std::string> found;
  for (const char* key : shape_keys) {
    if (entry.value.value(key) != nullptr) found.emplace_back(key);
  }
  if (found.size() != 1) {
    diagnostics.error(entry.place, path + ": expected one of " + list_of({shape_keys.begin(), shape_keys.end()}) +
                                       ", found " + (found.empty() ? "none" : list_of(found)));
    return;
  }
  const std::string& kind = found.front();
  const Tree& tree = *entry.value.value(kind);
  const std::string at = path + "." + kind;
  const NumberRule length{.unit = "m", .min = 0, .above_min = true};
  if (kind == "mesh") {
    MeshShape mesh;
    if (auto file = files.find(tree, at, mesh_files, diagnostics)) mesh.file = *file;
    if (const Tree* scale = entry.value.value("scale")) {
      mesh.scale = read_number(*scale, path + ".scale", {.min = 0, .above_min = true}, diagnostics);
    }
    body.shape = mesh;
    return;
  }
  if (const Tree* scale = entry.value.value("scale")) {
    diagnostics.error(scale->place,
                      path + ".scale: only a mesh has a scale; give the size of the " + kind + " in metres");
  }
  if (kind == "sphere") {
    if (!expect_map(tree, at, "a map with radius", diagnostics)) return;
    check_keys(tree, at, "key", {"radius"}, diagnostics);
    body.shape = SphereShape{needed_number(tree, "radius", at, length, diagnostics)};
  } else if (kind == "capsule") {
    if (!expect_map(tree, at, "a map with radius and length", diagnostics)) return;
    check_keys(tree, at, "key", {"radius", "length"}, diagnostics);
    body.shape = CapsuleShape{needed_number(tree, "radius", at, length, diagnostics),
                              needed_number(tree, "length", at, length, diagnostics)};
  } else if (kind == "box") {
    if (!expect_map(tree, at, "a map with size", diagnostics)) return;
    check_keys(tree, at, "key", {"size"}, diagnostics);
    if (const Tree* size = tree.value("size")) {
      body.shape = BoxShape{read_vector(*size, at + ".size", length, diagnostics).value_or(Vec3{1, 1, 1})};
    } else {
      diagnostics.error(tree.place, at + ": expected the key size, found none");
    }
  } else if (expect_map(tree, at, "a map without keys: {}", diagnostics)) {
    check_keys(tree, at, "key", {}, diagnostics);
    body.shape = PlaneShape{};
  }
}

/// What only a deformable body has, and what one has not.
void read_deformation(Body& body, const Tree& tree, const std::string& path, Diagnostics& diagnostics) {
  if (body.motion == Motion::deformable) {
    body.deformable = read_deformable(tree, path, diagnostics);
    for (const char* key : {"mass", "inertia"}) {
      if (const Tree* value = tree.value(key)) {
        diagnostics.error(value->place,
                          path + "." + key + ": expected no mass, because the density of a deformable body gives it");
      }
    }
    return;
  }
  for (const std::string& key : deformable_keys()) {
    if (const Tree* value = tree.value(key)) {
      diagnostics.error(value->place, path + "." + key + ": only a body with motion: deformable has it");
    }
  }
}

Body read_body(const TreeEntry& entry, const std::string& path, const FileFinder& files, Diagnostics& diagnostics) {
  static const std::vector<std::string> keys = [] {
    std::vector<std::string> all{"mesh", "sphere", "capsule", "box",     "plane",   "scale",
                                 "pose", "motion", "mass",    "inertia", "material"};
    all.insert(all.end(), deformable_keys().begin(), deformable_keys().end());
    return all;
  }();
  Body body;
  body.name = entry.key;
  const Tree& tree = entry.value;
  if (tree.is_null()) {
    diagnostics.error(tree.place.line > 0 ? tree.place : entry.place,
                      path +
                          ": expected a body, found nothing; ~ takes out a body of the file that this one extends, "
                          "and there is none of that name");
    return body;
  }
  if (!expect_map(tree, path, "a body: a map with a shape", diagnostics)) return body;
  check_keys(tree, path, "key", keys, diagnostics);
  read_shape(body, entry, path, files, diagnostics);
  if (const Tree* pose = tree.value("pose")) body.X_WB = read_pose(*pose, path + ".pose", diagnostics);
  if (const Tree* motion = tree.value("motion")) {
    const auto text =
        read_choice(*motion, path + ".motion", {"static", "translation", "rigid", "deformable"}, diagnostics);
    if (text == "deformable") body.motion = Motion::deformable;
    if (text == "translation") body.motion = Motion::translation;
    if (text == "rigid") body.motion = Motion::rigid;
    if (body.motion != Motion::fixed && std::holds_alternative<PlaneShape>(body.shape)) {
      diagnostics.error(motion->place, path + ".motion: a plane has no end and cannot move; expected static");
    }
  }
  read_deformation(body, tree, path, diagnostics);
  set_number(body.mass, tree, "mass", path, {.unit = "kg", .min = 0, .above_min = true}, diagnostics);
  if (const Tree* inertia = tree.value("inertia")) {
    body.inertia =
        read_vector(*inertia, path + ".inertia", {.unit = "kg m^2", .min = 0, .above_min = true}, diagnostics);
    if (body.inertia) {
      const Vec3& I = *body.inertia;
      // Ten digits of slack for flat bodies, whose largest moment is the sum of the others.
      if (2 * std::max({I.x, I.y, I.z}) > (I.x + I.y + I.z) * (1 + 1e-10)) {
        diagnostics.error(inertia->place,
                          path + ".inertia: expected moments, each at most the sum of the other two, found " +
                              number_text(I.x) + ", " + number_text(I.y) + ", " + number_text(I.z));
      }
    }
  }
  if (const Tree* material = tree.value("material")) {
    body.material = read_material(*material, path + ".material", diagnostics);
  }
  return body;
}

void read_tool(Scene& scene, const Tree& tree, const SourceLocation& last, const std::vector<std::string>& moving,
               Diagnostics& diagnostics) {
  const Tree* tool = tree.value("tool");
  if (tool == nullptr) {
    if (moving.size() > 1) {
      diagnostics.error(last, "scene.bodies: " + list_of(moving) +
                                  " move; expected scene.tool to say which of them hangs on the device");
    }
    return;
  }
  if (const auto name = read_choice(*tool, "scene.tool", moving, diagnostics)) scene.tool_name = *name;
}

Camera read_camera(const Tree& tree, Diagnostics& diagnostics) {
  Camera camera;
  if (!expect_map(tree, "scene.camera", "a map with from and up", diagnostics)) return camera;
  check_keys(tree, "scene.camera", "key", {"from", "up"}, diagnostics);
  const auto read = [&](const char* key, Vec3& direction) {
    if (const Tree* value = tree.value(key)) {
      direction =
          read_vector(*value, std::string("scene.camera.") + key, {.unit = "1"}, diagnostics).value_or(direction);
    }
  };
  read("from", camera.from_W);
  read("up", camera.up_W);
  if (norm(cross(camera.from_W, camera.up_W)) < 1e-6 * norm(camera.from_W) * norm(camera.up_W) ||
      norm(camera.from_W) == 0 || norm(camera.up_W) == 0) {
    diagnostics.error(tree.place, "scene.camera: expected from and up along different lines");
  }
  return camera;
}

}  // namespace

Scene read_scene(const Tree& tree, const FileFinder& files, Diagnostics& diagnostics) {
  Scene scene;
  if (!expect_map(tree, "scene", "a map with gravity, camera, tool and bodies", diagnostics)) return scene;
  check_keys(tree, "scene", "key", {"gravity", "camera", "tool", "bodies"}, diagnostics);
  if (const Tree* gravity = tree.value("gravity")) {
    scene.gravity_W = read_vector(*gravity, "scene.gravity", {.unit = "m/s^2"}, diagnostics).value_or(scene.gravity_W);
  }
  if (const Tree* camera = tree.value("camera")) scene.camera = read_camera(*camera, diagnostics);
  const Tree* bodies = tree.value("bodies");
  if (bodies == nullptr || !expect_map(*bodies, "scene.bodies", "a map of bodies", diagnostics)) return scene;
  std::vector<std::string> moving;
  SourceLocation last;
  for (const TreeEntry& entry : bodies->entries) {
    const std::string path = "scene.bodies." + entry.key;
    check_name(entry, path, diagnostics);
    scene.bodies.push_back(read_body(entry, path, files, diagnostics));
    if (!scene.bodies.back().moves()) continue;
    moving.push_back(entry.key);
    last = entry.place;
  }
  if (moving.size() > max_moving_bodies) {
    diagnostics.error(last, "scene.bodies: expected at most " + std::to_string(max_moving_bodies) +
                                " moving bodies, found " + list_of(moving));
  }
  read_tool(scene, tree, last, moving, diagnostics);
  return scene;
}

}  // namespace tactor
