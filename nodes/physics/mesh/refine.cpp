#include "nodes/physics/mesh/refine.hpp"

#include <algorithm>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <utility>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

// About a gigabyte for who works with them.
constexpr std::size_t most_vertices = 4'000'000;

class Refinement {
 public:
  Refinement(const TriangleMesh& mesh, double longest_edge) : longest_edge_(longest_edge) {
    refined_.mesh.vertices = mesh.vertices;
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) split(mesh.faces[f], static_cast<int>(f));
  }
  RefinedMesh take() { return std::move(refined_); }

 private:
  const Vec3& at(int i) const { return refined_.mesh.vertices[static_cast<std::size_t>(i)]; }

  void split(const std::array<int, 3>& face, int parent) {
    std::size_t longest = 0;
    double longest_length = -1;
    for (std::size_t i = 0; i < 3; ++i) {
      const double length = norm(at(face[(i + 1) % 3]) - at(face[i]));
      if (length > longest_length) longest = i, longest_length = length;
    }
    if (longest_length <= longest_edge_) {
      refined_.mesh.faces.push_back(face);
      refined_.parent_face.push_back(parent);
      return;
    }
    const int a = face[longest], b = face[(longest + 1) % 3], c = face[(longest + 2) % 3];
    const int m = midpoint(a, b);
    split({a, m, c}, parent);
    split({m, b, c}, parent);
  }

  /// Both faces of an edge share its midpoint.
  int midpoint(int a, int b) {
    const auto [low, high] = std::minmax(a, b);
    const std::uint64_t edge = static_cast<std::uint64_t>(low) << 32 | static_cast<std::uint32_t>(high);
    std::vector<Vec3>& vertices = refined_.mesh.vertices;
    const auto [entry, added] = midpoints_.try_emplace(edge, static_cast<int>(vertices.size()));
    const int vertex = entry->second;
    if (!added) {
      midpoints_.erase(entry);  // nothing asks a third time, and a small table is fast
    } else {
      if (vertices.size() >= most_vertices) {
        throw InputError("edges no longer than " + std::to_string(1e3 * longest_edge_) +
                         " mm divide this mesh by more than " + std::to_string(most_vertices) + " points");
      }
      vertices.push_back(0.5 * (at(low) + at(high)));
    }
    return vertex;
  }

  double longest_edge_;
  RefinedMesh refined_;
  std::unordered_map<std::uint64_t, int> midpoints_;
};

}  // namespace

RefinedMesh refine(const TriangleMesh& mesh, double longest_edge) {
  return Refinement(mesh, longest_edge).take();
}

}  // namespace tactor
