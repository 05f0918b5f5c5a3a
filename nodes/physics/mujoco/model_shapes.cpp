#include "nodes/physics/mujoco/model_shapes.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "nodes/physics/mujoco/conversions.hpp"

namespace tactor {

namespace {

constexpr int last_shown_group = 2;

using SharedTriangles = std::shared_ptr<const Triangles>;

SharedTriangles triangles_of_mesh(const mjModel& m, int mesh) {
  Triangles triangles;
  const float* p = m.mesh_vert + 3 * m.mesh_vertadr[mesh];
  for (int i = 0; i < m.mesh_vertnum[mesh]; ++i, p += 3) triangles.vertices.push_back({p[0], p[1], p[2]});
  const int* face = m.mesh_face + 3 * m.mesh_faceadr[mesh];
  for (int i = 0; i < m.mesh_facenum[mesh]; ++i, face += 3) triangles.faces.push_back({face[0], face[1], face[2]});
  return std::make_shared<const Triangles>(std::move(triangles));
}

/// The upper side of a height field.
SharedTriangles triangles_of_field(const mjModel& m, int field) {
  const int rows = m.hfield_nrow[field], columns = m.hfield_ncol[field];
  const double* size = m.hfield_size + 4 * field;
  const float* height = m.hfield_data + m.hfield_adr[field];
  const auto along = [](int i, int count, double radius) { return radius * (2.0 * i / std::max(count - 1, 1) - 1); };
  Triangles triangles;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      triangles.vertices.push_back(
          {along(c, columns, size[0]), along(r, rows, size[1]), size[2] * height[r * columns + c]});
    }
  }
  for (int r = 0; r + 1 < rows; ++r) {
    for (int c = 0; c + 1 < columns; ++c) {
      const int at = r * columns + c;
      triangles.faces.push_back({at, at + 1, at + columns + 1});
      triangles.faces.push_back({at, at + columns + 1, at + columns});
    }
  }
  return std::make_shared<const Triangles>(std::move(triangles));
}

bool is_transparent(const mjModel& m, int geom) {
  const int material = m.geom_matid[geom];
  return (material >= 0 ? m.mat_rgba[4 * material + 3] : m.geom_rgba[4 * geom + 3]) <= 0;
}

/// Makes the shapes of a model, one after another.
class ShapeMaker {
 public:
  ShapeMaker(const mjModel& m, const mjData& d) : m_(m), d_(d) {}

  /// Nothing where it is of a kind that has no surface.
  void add(int geom, const std::vector<int>& bodies, OwnScene& scene) {
    OwnShape shape;
    if (!set_form(geom, shape)) return;
    Pose X_WS{vec3_at(d_.geom_xpos + 3 * geom), {}};
    double q[4];
    mju_mat2Quat(q, d_.geom_xmat + 9 * geom);
    X_WS.R = {q[0], q[1], q[2], q[3]};
    shape.X_BS = X_WS;
    const auto moving = std::find(bodies.begin(), bodies.end(), m_.body_weldid[m_.geom_bodyid[geom]]);
    if (moving != bodies.end()) {
      shape.body = static_cast<std::size_t>(moving - bodies.begin());
      shape.X_BS = inverse(centre_pose(d_, *moving)) * X_WS;
    }
    shape.name = name_for(geom);
    scene.shapes.push_back(std::move(shape));
  }

 private:
  bool set_form(int geom, OwnShape& shape) {
    const double* size = m_.geom_size + 3 * geom;
    const int data = m_.geom_dataid[geom];
    switch (m_.geom_type[geom]) {
      case mjGEOM_PLANE:
        shape.form = PlaneShape{};
        return true;
      case mjGEOM_SPHERE:
        shape.form = SphereShape{size[0]};
        return true;
      case mjGEOM_CAPSULE:
        shape.form = CapsuleShape{size[0], 2 * size[1]};
        return true;
      case mjGEOM_CYLINDER:
        shape.form = CylinderShape{size[0], 2 * size[1]};
        return true;
      case mjGEOM_ELLIPSOID:
        shape.form = EllipsoidShape{vec3_at(size)};
        return true;
      case mjGEOM_BOX:
        shape.form = BoxShape{2 * vec3_at(size)};
        return true;
      case mjGEOM_MESH:
        shape.form = TrianglesShape{kept(meshes_, data, triangles_of_mesh)};
        return true;
      case mjGEOM_HFIELD:
        shape.form = TrianglesShape{kept(fields_, data, triangles_of_field)};
        return true;
      default:
        return false;
    }
  }

  /// Many geoms may have one mesh.
  SharedTriangles kept(std::map<int, SharedTriangles>& made, int number, SharedTriangles (*make)(const mjModel&, int)) {
    SharedTriangles& triangles = made[number];
    if (triangles == nullptr) triangles = make(m_, number);
    return triangles;
  }

  std::string name_for(int geom) {
    const char* name = mj_id2name(&m_, mjOBJ_GEOM, geom);
    if (name == nullptr || *name == '\0') name = mj_id2name(&m_, mjOBJ_BODY, m_.geom_bodyid[geom]);
    const std::string base = name == nullptr || *name == '\0' ? "geom" : name;
    std::string unique = base;
    for (int n = 2; !names_.insert(unique).second; ++n) unique = base + " " + std::to_string(n);
    return unique;
  }

  const mjModel& m_;
  const mjData& d_;
  std::map<int, SharedTriangles> meshes_, fields_;
  std::set<std::string> names_;
};

}  // namespace

OwnScene scene_of_model(const mjModel& m, const mjData& d, const std::vector<int>& bodies) {
  OwnScene scene;
  for (const int body : bodies) {
    const char* name = mj_id2name(&m, mjOBJ_BODY, body);
    scene.bodies.push_back({name != nullptr ? name : "", centre_pose(d, body)});
  }
  for (const bool all : {false, true}) {
    ShapeMaker maker(m, d);
    for (int geom = 0; geom < m.ngeom; ++geom) {
      if (all || (m.geom_group[geom] <= last_shown_group && !is_transparent(m, geom))) maker.add(geom, bodies, scene);
    }
    if (!scene.shapes.empty()) break;
  }
  return scene;
}

}  // namespace tactor
