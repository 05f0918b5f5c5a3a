// Closed meshes with flat faces, the same bodies in many triangulations, and scenes in which they lie on each other.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "nodes/physics/mesh/mesh.hpp"
#include "tests/nodes/physics/contact/scenes.hpp"
#include "tests/support/dice.hpp"

namespace tactor::test {

/// A surface of flat faces whose triangulation can be changed, and which stays closed and where it is.
class FlatMesh {
 public:
  explicit FlatMesh(TriangleMesh mesh) : mesh_(std::move(mesh)) {}
  [[nodiscard]] const TriangleMesh& mesh() const { return mesh_; }

  /// Other diagonals between two faces of one plane, `count` tries.
  void flip_some(Dice& dice, int count) {
    for (int i = 0; i < count; ++i) flip(pick(dice), static_cast<std::size_t>(dice(0, 3)));
  }
  /// A point inside a face picked at random, which becomes three. `sliver`: how near to an edge it may lie, as a share.
  void split_faces(Dice& dice, int count, double sliver) {
    for (int i = 0; i < count; ++i) {
      std::array<double, 3> share{dice(sliver, 1), dice(sliver, 1), dice(sliver, 1)};
      if (dice(0, 1) < 0.5) share[static_cast<std::size_t>(dice(0, 3))] = sliver;
      split(pick(dice), share);
    }
  }
  /// A point on an edge picked at random, which parts both of its faces.
  void split_edges(Dice& dice, int count, double least) {
    for (int i = 0; i < count; ++i) {
      split_edge(pick(dice), static_cast<std::size_t>(dice(0, 3)), dice(least, 1 - least));
    }
  }
  /// A point inside one of the faces that the last one made.
  void split_last(Dice& dice) {
    const std::size_t f = mesh_.faces.size() - 1 - static_cast<std::size_t>(dice(0, 2));
    split(f, {dice(0.1, 1), dice(0.1, 1), dice(0.1, 1)});
  }
  /// Each face becomes four.
  void subdivide() {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [entry, added] = middles.try_emplace(std::minmax(a, b), 0);
      if (added) entry->second = add(0.5 * (at(a) + at(b)));
      return entry->second;
    };
    std::vector<std::array<int, 3>> faces;
    for (const auto& v : mesh_.faces) {
      const int a = middle(v[0], v[1]), b = middle(v[1], v[2]), c = middle(v[2], v[0]);
      faces.insert(faces.end(), {{v[0], a, c}, {v[1], b, a}, {v[2], c, b}, {a, b, c}});
    }
    mesh_.faces = faces;
  }

 private:
  [[nodiscard]] const Vec3& at(int i) const { return mesh_.vertices[static_cast<std::size_t>(i)]; }
  int add(const Vec3& p) {
    mesh_.vertices.push_back(p);
    return static_cast<int>(mesh_.vertices.size()) - 1;
  }
  [[nodiscard]] std::size_t pick(Dice& dice) const {
    return static_cast<std::size_t>(dice(0, static_cast<double>(mesh_.faces.size())));
  }
  /// The face that has the edge from b to a, and which of its corners is a.
  [[nodiscard]] std::pair<std::size_t, std::size_t> beyond(int a, int b) const {
    for (std::size_t f = 0; f < mesh_.faces.size(); ++f) {
      for (std::size_t i = 0; i < 3; ++i) {
        if (mesh_.faces[f][i] == b && mesh_.faces[f][(i + 1) % 3] == a) return {f, (i + 1) % 3};
      }
    }
    return {mesh_.faces.size(), 0};
  }
  void split(std::size_t f, const std::array<double, 3>& share) {
    const std::array<int, 3> v = mesh_.faces[f];
    const double sum = share[0] + share[1] + share[2];
    const int m = add((share[0] * at(v[0]) + share[1] * at(v[1]) + share[2] * at(v[2])) / sum);
    mesh_.faces[f] = {v[0], v[1], m};
    mesh_.faces.push_back({v[1], v[2], m});
    mesh_.faces.push_back({v[2], v[0], m});
  }
  void split_edge(std::size_t f, std::size_t i, double share) {
    const std::array<int, 3> v = mesh_.faces[f];
    const int a = v[i], b = v[(i + 1) % 3], c = v[(i + 2) % 3];
    const auto [g, j] = beyond(a, b);
    const int d = mesh_.faces[g][(j + 1) % 3], m = add(at(a) + share * (at(b) - at(a)));
    mesh_.faces[f] = {a, m, c};
    mesh_.faces[g] = {b, m, d};
    mesh_.faces.push_back({m, b, c});
    mesh_.faces.push_back({m, a, d});
  }
  void flip(std::size_t f, std::size_t i) {
    const std::array<int, 3> v = mesh_.faces[f];
    const int a = v[i], b = v[(i + 1) % 3], c = v[(i + 2) % 3];
    const auto [g, j] = beyond(a, b);
    const int d = mesh_.faces[g][(j + 1) % 3];
    const auto normal = [&](int p, int q, int r) { return cross(at(q) - at(p), at(r) - at(p)); };
    const Vec3 n = normal(a, b, c), other = normal(a, d, c), last = normal(d, b, c);
    const double flat = 1 - 1e-12;
    const auto alike = [&](const Vec3& m) { return dot(m, n) > flat * norm(m) * norm(n) && norm(m) > 1e-3 * norm(n); };
    const Vec3 beyond_edge = normal(b, a, d);
    if (!(dot(beyond_edge, n) > flat * norm(beyond_edge) * norm(n)) || !alike(other) || !alike(last)) return;
    mesh_.faces[f] = {a, d, c};
    mesh_.faces[g] = {d, b, c};
  }

  TriangleMesh mesh_;
};

/// A box about the origin whose edges are cut at the same places on all sides, each rectangle by a diagonal at random.
/// `cut[axis]`: where, from 0 to 1, without both ends.
inline TriangleMesh cut_box(const Vec3& size, const std::array<std::vector<double>, 3>& cut, Dice& dice) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, int> known;
  std::array<std::vector<double>, 3> place;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    place[axis] = {0};
    place[axis].insert(place[axis].end(), cut[axis].begin(), cut[axis].end());
    place[axis].push_back(1);
  }
  const auto vertex = [&](const std::array<int, 3>& i) {
    const auto [entry, added] = known.try_emplace(i, static_cast<int>(mesh.vertices.size()));
    if (added) {
      Vec3 p;
      for (int axis = 0; axis < 3; ++axis) {
        p[axis] =
            size[axis] *
            (place[static_cast<std::size_t>(axis)][static_cast<std::size_t>(i[static_cast<std::size_t>(axis)])] - 0.5);
      }
      mesh.vertices.push_back(p);
    }
    return entry->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto last = [&](std::size_t along) { return static_cast<int>(place[along].size()) - 1; };
    for (const int side : {0, last(axis)}) {
      for (int j = 0; j < last(u); ++j) {
        for (int k = 0; k < last(v); ++k) {
          const auto corner = [&](int dj, int dk) {
            std::array<int, 3> i{};
            i[axis] = side, i[u] = j + dj, i[v] = k + dk;
            return vertex(i);
          };
          std::array<int, 4> q{corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
          if (side == 0) std::swap(q[1], q[3]);
          const std::size_t s = dice(0, 1) < 0.5 ? 0 : 1;
          mesh.faces.push_back({q[s], q[s + 1], q[s + 2]});
          mesh.faces.push_back({q[s], q[s + 2], q[(s + 3) % 4]});
        }
      }
    }
  }
  return mesh;
}

/// The kinds of triangulation that boxes have here.
constexpr int triangulations = 10;
inline const char* triangulation_name(int kind) {
  static constexpr const char* names[triangulations] = {"12 triangles", "fans",           "slivers", "cut edges",
                                                        "long strips",  "a lattice",      "mixed",   "four as finely",
                                                        "very fine",    "fine at a place"};
  return names[kind];
}

/// A box about the origin, triangulated in that kind, at random.
inline TriangleMesh triangulated_box(const Vec3& size, int kind, Dice& dice) {
  const auto cuts = [&](int count, double power) {
    std::vector<double> at;
    for (int i = 1; i < count; ++i) at.push_back(std::pow(static_cast<double>(i) / count, power));
    return at;
  };
  const auto whole = [&](double most) { return static_cast<int>(dice(1, most)); };
  FlatMesh mesh(box(size));
  mesh.flip_some(dice, 24);
  switch (kind) {
    case 0:
      break;
    case 1:
      mesh.split_faces(dice, whole(60), 0.05);
      break;
    case 2:
      mesh.split_faces(dice, whole(40), 1e-3);
      mesh.split_edges(dice, whole(20), 0.02);
      break;
    case 3:
      mesh.split_edges(dice, whole(80), 0.1);
      mesh.flip_some(dice, 200);
      break;
    case 4:
      return cut_box(size, {cuts(whole(60), 1), {}, {}}, dice);
    case 5:
      return cut_box(size, {cuts(whole(40), 1), cuts(whole(40), 1), cuts(whole(10), 1)}, dice);
    case 6:
      return cut_box(size, {cuts(30, dice(1, 4)), cuts(30, dice(1, 4)), cuts(4, 1)}, dice);
    case 7:
      mesh.split_faces(dice, whole(10), 0.1);
      mesh.subdivide();
      mesh.subdivide();
      break;
    case 8:
      return cut_box(size, {cuts(100, 1), cuts(100, 1), cuts(10, 1)}, dice);
    default:
      mesh.split_faces(dice, 1, 0.1);
      // Again and again at the last point, down to some micrometres: smaller faces would cut each other by rounding.
      for (int i = 0; i < 8; ++i) mesh.split_last(dice);
      break;
  }
  return mesh.mesh();
}

/// A body with a flat regular foot of `sides` sides and radius `foot` (m) at -height / 2, and a head alike of radius
/// `head` above it.
inline TriangleMesh stamp(int sides, double foot, double head, double height) {
  TriangleMesh mesh;
  for (const double z : {-height / 2, height / 2}) {
    const double r = z < 0 ? foot : head;
    for (int i = 0; i < sides; ++i) {
      const double turn = 2 * std::numbers::pi * i / sides;
      mesh.vertices.push_back({r * std::cos(turn), r * std::sin(turn), z});
    }
  }
  for (int i = 0; i < sides; ++i) {
    const int a = i, b = (i + 1) % sides;
    mesh.faces.push_back({a, b, b + sides});
    mesh.faces.push_back({a, b + sides, a + sides});
    if (i == 0 || i + 1 == sides) continue;
    mesh.faces.push_back({0, b, a});
    mesh.faces.push_back({sides, a + sides, b + sides});
  }
  return mesh;
}

/// A tool with a flat foot at height -half.
struct FlatTool {
  Body body;
  std::string name;
  double half = 0;   // m
  double area = 0;   // m^2, of the foot
  double reach = 0;  // m, of the foot from its middle
};

/// `kind`: 0 a box, 1 a mesh of a box, 2 a stamp.
inline FlatTool flat_tool(int kind, Dice& dice, const std::string& file, double least = 0.004, double most = 0.025) {
  FlatTool tool;
  if (kind == 2) {
    const int sides = static_cast<int>(dice(3, 12));
    const double foot = dice(least / 2, most / 2), head = foot * dice(0.8, 1.6), height = dice(0.004, 0.025);
    FlatMesh mesh(stamp(sides, foot, head, height));
    if (dice(0, 1) < 0.5) mesh.split_faces(dice, 20, 0.05);
    tool.body = mesh_body(file, mesh.mesh(), Motion::rigid);
    tool.name = "stamp of " + std::to_string(sides) + " sides";
    tool.half = height / 2;
    tool.area = sides / 2.0 * foot * foot * std::sin(2 * std::numbers::pi / sides);
    tool.reach = foot;
  } else {
    const Vec3 size{dice(least, most), dice(least, most), dice(least, most)};
    const int how = static_cast<int>(dice(0, triangulations));
    tool.name = kind == 0 ? "box" : std::string("mesh box, ") + triangulation_name(how);
    tool.body = kind == 0 ? shaped("tool", BoxShape{size}, Motion::rigid)
                          : mesh_body(file, triangulated_box(size, how, dice), Motion::rigid);
    tool.half = size.z / 2;
    tool.area = size.x * size.y;
    tool.reach = std::hypot(size.x, size.y) / 2;
  }
  tool.body.name = "tool";
  return tool;
}

}  // namespace tactor::test
