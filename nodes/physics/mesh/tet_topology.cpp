#include "nodes/physics/mesh/tet_topology.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/mesh/disjoint_sets.hpp"

namespace tactor {

namespace {

std::array<int, 3> sorted(std::array<int, 3> face) {
  std::sort(face.begin(), face.end());
  return face;
}

/// A face of a tetrahedron: its nodes in ascending order tell which faces are one.
struct TetFace {
  std::array<int, 3> nodes;
  std::size_t tet, opposite;
  auto operator<=>(const TetFace&) const = default;
};

/// All faces; those at one place follow each other.
std::vector<TetFace> tet_faces(const std::vector<std::array<int, 4>>& tets) {
  std::vector<TetFace> faces;
  faces.reserve(4 * tets.size());
  for (std::size_t t = 0; t < tets.size(); ++t) {
    for (std::size_t k = 0; k < 4; ++k) faces.push_back({sorted(face_opposite(tets[t], k)), t, k});
  }
  std::sort(faces.begin(), faces.end());
  return faces;
}

/// Whether the nodes go the same way round.
bool same_turn(const std::array<int, 3>& a, const std::array<int, 3>& b) {
  return a == b || a == std::array{b[1], b[2], b[0]} || a == std::array{b[2], b[0], b[1]};
}

/// Takes from `mesh` the nodes that are not marked, and numbers the others anew by `number`, -1 where gone.
void renumber(TetMesh& mesh, const std::vector<int>& number, std::size_t count) {
  std::vector<Vec3> nodes(count);
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] >= 0) nodes[static_cast<std::size_t>(number[i])] = mesh.nodes[i];
  }
  mesh.nodes = std::move(nodes);
  for (auto& tet : mesh.tets) {
    for (int& i : tet) i = number[static_cast<std::size_t>(i)];
  }
  for (FaceGroup& group : mesh.groups) {
    std::erase_if(group.faces, [&](const std::array<int, 3>& face) {
      return std::any_of(face.begin(), face.end(), [&](int i) { return number[static_cast<std::size_t>(i)] < 0; });
    });
    for (auto& face : group.faces) {
      for (int& i : face) i = number[static_cast<std::size_t>(i)];
    }
  }
  std::erase_if(mesh.groups, [](const FaceGroup& group) { return group.faces.empty(); });
}

void drop_unused_nodes(TetMesh& mesh) {
  std::vector<int> number(mesh.nodes.size(), -1);
  for (const auto& tet : mesh.tets) {
    for (const int i : tet) number[static_cast<std::size_t>(i)] = 0;
  }
  int count = 0;
  for (int& n : number) {
    if (n == 0) n = count++;
  }
  renumber(mesh, number, static_cast<std::size_t>(count));
}

/// Every third bit of the result is one of the lowest 20 of `n`.
std::uint64_t spread_bits(std::uint64_t n) {
  std::uint64_t spread = 0;
  for (unsigned bit = 0; bit < 20; ++bit) spread |= (n >> bit & 1U) << 3 * bit;
  return spread;
}

}  // namespace

std::string find_overlap(const TetMesh& mesh) {
  const std::vector<TetFace> faces = tet_faces(mesh.tets);
  for (std::size_t i = 1; i < faces.size(); ++i) {
    const TetFace &a = faces[i - 1], &b = faces[i];
    if (a.nodes != b.nodes) continue;
    const std::string both = "tetrahedra " + std::to_string(a.tet) + " and " + std::to_string(b.tet);
    if (i + 1 < faces.size() && faces[i + 1].nodes == a.nodes) {
      return both + " share a face with tetrahedron " + std::to_string(faces[i + 1].tet);
    }
    if (same_turn(face_opposite(mesh.tets[a.tet], a.opposite), face_opposite(mesh.tets[b.tet], b.opposite))) {
      return both + " overlap: they lie on the same side of the face that they share";
    }
  }
  return {};
}

std::vector<std::array<int, 3>> boundary_faces(const std::vector<std::array<int, 4>>& tets) {
  const std::vector<TetFace> faces = tet_faces(tets);
  std::vector<std::pair<std::size_t, std::size_t>> open;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const bool as_before = i > 0 && faces[i - 1].nodes == faces[i].nodes;
    const bool as_after = i + 1 < faces.size() && faces[i + 1].nodes == faces[i].nodes;
    if (!as_before && !as_after) open.emplace_back(faces[i].tet, faces[i].opposite);
  }
  std::sort(open.begin(), open.end());
  std::vector<std::array<int, 3>> boundary;
  boundary.reserve(open.size());
  for (const auto& [tet, k] : open) boundary.push_back(face_opposite(tets[tet], k));
  return boundary;
}

void finish_mesh(TetMesh& mesh) {
  drop_unused_nodes(mesh);
  mesh.faces = boundary_faces(mesh.tets);
  if (mesh.groups.empty()) return;
  using Keyed = std::pair<std::array<int, 3>, std::size_t>;
  std::vector<Keyed> by_nodes;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) by_nodes.emplace_back(sorted(mesh.faces[f]), f);
  std::sort(by_nodes.begin(), by_nodes.end());
  for (FaceGroup& group : mesh.groups) {
    for (auto& face : group.faces) {
      const auto at = std::lower_bound(by_nodes.begin(), by_nodes.end(), Keyed{sorted(face), 0});
      if (at != by_nodes.end() && at->first == sorted(face)) face = mesh.faces[at->second];
    }
  }
}

void order_by_place(TetMesh& mesh) {
  Bounds bounds;
  for (const Vec3& p : mesh.nodes) bounds.add(p);
  constexpr double steps = (1U << 20U) - 1;
  const double length = bounds.longest();
  std::vector<std::pair<std::uint64_t, std::size_t>> order;
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double along = (mesh.nodes[i][axis] - bounds.low[axis]) / length;
      key |= spread_bits(static_cast<std::uint64_t>(steps * along)) << static_cast<unsigned>(axis);
    }
    order.emplace_back(key, i);
  }
  std::sort(order.begin(), order.end());
  std::vector<int> number(mesh.nodes.size());
  for (std::size_t i = 0; i < order.size(); ++i) number[order[i].second] = static_cast<int>(i);
  renumber(mesh, number, mesh.nodes.size());
  for (auto& tet : mesh.tets) {
    // The lowest node first, the others so that the volume stays positive.
    const auto lowest = static_cast<std::size_t>(std::min_element(tet.begin(), tet.end()) - tet.begin());
    if (lowest == 0) continue;
    const std::size_t a = lowest == 1 ? 2 : 1, b = lowest == 3 ? 2 : 3;
    std::swap(tet[0], tet[lowest]);
    std::swap(tet[a], tet[b]);
  }
  std::sort(mesh.tets.begin(), mesh.tets.end());
}

std::size_t pieces_of(const TetMesh& mesh) {
  DisjointSets sets(mesh.nodes.size());
  for (const auto& tet : mesh.tets) {
    for (const int i : tet) sets.unite(static_cast<std::size_t>(i), static_cast<std::size_t>(tet[0]));
  }
  std::size_t pieces = 0;
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) pieces += sets.root(i) == i ? 1 : 0;
  return pieces;
}

std::vector<int> surface_nodes(const TetMesh& mesh) {
  std::vector<int> nodes;
  for (const auto& face : mesh.faces) nodes.insert(nodes.end(), face.begin(), face.end());
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

TriangleMesh surface_of(const TetMesh& mesh) {
  const std::vector<int> nodes = surface_nodes(mesh);
  std::vector<int> number(mesh.nodes.size(), -1);
  TriangleMesh surface;
  for (const int i : nodes) {
    number[static_cast<std::size_t>(i)] = static_cast<int>(surface.vertices.size());
    surface.vertices.push_back(mesh.nodes[static_cast<std::size_t>(i)]);
  }
  for (const auto& face : mesh.faces) {
    const auto vertex = [&](std::size_t k) { return number[static_cast<std::size_t>(face[k])]; };
    surface.faces.push_back({vertex(0), vertex(1), vertex(2)});
  }
  return surface;
}

}  // namespace tactor
