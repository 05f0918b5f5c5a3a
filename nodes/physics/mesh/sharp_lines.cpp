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

/// The distance of a point from the segment between a and b.
double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double square = dot(d, d);
  const double s = square > 0 ? std::clamp(dot(p - a, d) / square, 0.0, 1.0) : 0;
  return norm(p - a - s * d);
}

bool share_an_end(const std::vector<int>& a, const std::vector<int>& b) {
  return a.front() == b.front() || a.front() == b.back() || a.back() == b.front() || a.back() == b.back();
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

double nodes_on_lines(const TriangleMesh& mesh, const std::vector<std::vector<int>>& lines, double longest) {
  const auto vertex = [&](int v) { return mesh.vertices[static_cast<std::size_t>(v)]; };
  const auto distance_to = [&](const Vec3& p, const std::vector<int>& line) {
    double least = 2 * longest;
    for (std::size_t k = 1; k < line.size(); ++k) {
      least = std::min(least, distance_to_segment(p, vertex(line[k - 1]), vertex(line[k])));
    }
    return least;
  };
  // No node is nearer to the next than this part of the longest distance: lines that touch are counted, not for ever.
  constexpr double least_part = 1e-3;
  double nodes = 0;
  for (const std::vector<int>& line : lines) {
    for (std::size_t k = 1; k < line.size(); ++k) {
      const Vec3 a = vertex(line[k - 1]), b = vertex(line[k]);
      const double pieces = std::ceil(norm(b - a) / longest);
      for (double piece = 0; piece < pieces; ++piece) {
        const Vec3 p = a + (piece + 0.5) / pieces * (b - a);
        double gap = longest;
        for (const std::vector<int>& other : lines) {
          if (!share_an_end(line, other)) gap = std::min(gap, distance_to(p, other) / 2);
        }
        nodes += norm(b - a) / pieces / std::max(gap, least_part * longest);
      }
    }
  }
  return nodes;
}

}  // namespace tactor
