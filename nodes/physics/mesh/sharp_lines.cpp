#include "nodes/physics/mesh/sharp_lines.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "nodes/physics/mesh/disjoint_sets.hpp"

namespace tactor {

namespace {

using SharpEdge = std::pair<int, int>;

std::vector<SharpEdge> sharp_edges(const TriangleMesh& mesh, double angle) {
  std::map<SharpEdge, std::size_t> first_face;
  std::vector<SharpEdge> sharp;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const SharpEdge edge = std::minmax(mesh.faces[f][k], mesh.faces[f][(k + 1) % 3]);
      const auto [other, is_first] = first_face.try_emplace(edge, f);
      if (is_first) continue;
      const Vec3 a = doubled_area_normal(mesh, mesh.faces[f]), b = doubled_area_normal(mesh, mesh.faces[other->second]);
      if (std::atan2(norm(cross(a, b)), dot(a, b)) > angle) sharp.push_back(edge);
    }
  }
  std::sort(sharp.begin(), sharp.end());
  return sharp;
}

double length_of(const TriangleMesh& mesh, const SharpEdge& edge) {
  return norm(mesh.vertices[static_cast<std::size_t>(edge.second)] -
              mesh.vertices[static_cast<std::size_t>(edge.first)]);
}

/// Edges that hang together in chains of at least that length.
std::vector<SharpEdge> without_short_chains(const TriangleMesh& mesh, const std::vector<SharpEdge>& edges,
                                            double shortest) {
  DisjointSets sets(mesh.vertices.size());
  for (const auto& [a, b] : edges) sets.unite(static_cast<std::size_t>(a), static_cast<std::size_t>(b));
  std::map<std::size_t, double> lengths;
  for (const SharpEdge& edge : edges) lengths[sets.root(static_cast<std::size_t>(edge.first))] += length_of(mesh, edge);
  std::vector<SharpEdge> kept;
  std::copy_if(edges.begin(), edges.end(), std::back_inserter(kept), [&](const SharpEdge& edge) {
    return lengths.at(sets.root(static_cast<std::size_t>(edge.first))) >= shortest;
  });
  return kept;
}

}  // namespace

std::vector<std::vector<int>> sharp_lines(const TriangleMesh& mesh, double angle, double shortest) {
  const std::vector<SharpEdge> edges = without_short_chains(mesh, sharp_edges(mesh, angle), shortest);
  std::map<int, std::vector<std::size_t>> edges_at;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    edges_at[edges[i].first].push_back(i);
    edges_at[edges[i].second].push_back(i);
  }
  const auto other_end = [&](std::size_t edge, int v) {
    return edges[edge].first == v ? edges[edge].second : edges[edge].first;
  };
  const auto along = [&](int from, int to) {
    const Vec3 d = mesh.vertices[static_cast<std::size_t>(to)] - mesh.vertices[static_cast<std::size_t>(from)];
    return d / norm(d);
  };
  const auto is_corner = [&](int v) {
    const std::vector<std::size_t>& at = edges_at.at(v);
    if (at.size() != 2) return true;
    return dot(along(other_end(at[0], v), v), along(v, other_end(at[1], v))) < std::numbers::sqrt2 / 2;
  };
  std::vector<bool> taken(edges.size(), false);
  std::vector<std::vector<int>> lines;
  const auto follow = [&](int start, std::size_t edge) {
    std::vector<int> line{start};
    for (int v = start;;) {
      taken[edge] = true;
      v = other_end(edge, v);
      line.push_back(v);
      if (v == start || is_corner(v)) break;
      const std::vector<std::size_t>& at = edges_at.at(v);
      edge = at[0] == edge ? at[1] : at[0];
    }
    lines.push_back(std::move(line));
  };
  for (const auto& [v, at] : edges_at) {
    if (!is_corner(v)) continue;
    for (const std::size_t edge : at) {
      if (!taken[edge]) follow(v, edge);
    }
  }
  // What is left are rings without a corner.
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (!taken[i]) follow(edges[i].first, i);
  }
  return lines;
}

}  // namespace tactor
