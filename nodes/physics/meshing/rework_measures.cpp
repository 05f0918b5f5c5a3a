#include "nodes/physics/meshing/rework_measures.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "nodes/physics/mesh/mass_properties.hpp"
#include "nodes/physics/meshing/mesh_parts.hpp"

namespace tactor {

namespace {

double area_of(const std::vector<Corners>& triangles) {
  double area = 0;
  for (const Corners& t : triangles) area += area_of(t);
  return area;
}

double longest_side(const Corners& t) {
  return std::max({norm(t[1] - t[0]), norm(t[2] - t[1]), norm(t[0] - t[2])});
}

/// A piece of a face of the file that is so small that it counts as a whole.
struct Piece {
  Corners corners;
  std::size_t triangle;
};

/// Cuts triangles in four until no side is longer than `longest`.
std::vector<Piece> pieces_of(const std::vector<Corners>& triangles, double longest) {
  std::vector<Piece> pieces, open;
  for (std::size_t i = 0; i < triangles.size(); ++i) open.push_back({triangles[i], i});
  while (!open.empty()) {
    const Piece piece = open.back();
    open.pop_back();
    const Corners& t = piece.corners;
    if (longest_side(t) <= longest) {
      pieces.push_back(piece);
      continue;
    }
    const Corners m{0.5 * (t[0] + t[1]), 0.5 * (t[1] + t[2]), 0.5 * (t[2] + t[0])};
    open.push_back({{t[0], m[0], m[2]}, piece.triangle});
    open.push_back({{m[0], t[1], m[1]}, piece.triangle});
    open.push_back({{m[2], m[1], t[2]}, piece.triangle});
    open.push_back({m, piece.triangle});
  }
  return pieces;
}

/// What of the file's faces does not lie inside the new body.
struct Outside {
  std::vector<Corners> whole;       // faces, or pieces of them
  double of_pieces_across = 0;      // the farthest sample outside of pieces of which a part lies inside
  double area_inside = 0;           // of the file's faces
  std::set<std::size_t> swallowed;  // triangles of which a part lies inside
};

Outside outside_of(const std::vector<Corners>& triangles, const TriangleMesh& mesh, double diagonal) {
  constexpr std::size_t samples = 7;
  const std::vector<Piece> pieces = pieces_of(triangles, diagonal / 32);
  std::vector<Vec3> points;
  for (const Piece& piece : pieces) {
    // Not at the corners themselves, which neighbours have in common.
    const Corners& t = piece.corners;
    const Vec3 m = middle_of(t);
    for (std::size_t k = 0; k < 3; ++k) {
      points.push_back(0.9 * t[k] + 0.1 * m);
      points.push_back(0.45 * (t[k] + t[(k + 1) % 3]) + 0.1 * m);
    }
    points.push_back(m);
  }
  const std::vector<bool> inside = inside_of(points, mesh);
  const std::vector<double> gaps = gaps_of(points, triangle_list(mesh));
  const auto is_inside = [&](std::size_t i) { return inside[i] && gaps[i] > 1e-6 * diagonal; };
  Outside result;
  std::vector<std::size_t> inner(pieces.size(), 0);
  for (std::size_t n = 0; n < pieces.size(); ++n) {
    for (std::size_t i = samples * n; i < samples * (n + 1); ++i) inner[n] += is_inside(i) ? 1 : 0;
    if (inner[n] > 0) result.swallowed.insert(pieces[n].triangle);
    result.area_inside += area_of(pieces[n].corners) * static_cast<double>(inner[n]) / samples;
  }
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    if (!result.swallowed.contains(i)) result.whole.push_back(triangles[i]);
  }
  for (std::size_t n = 0; n < pieces.size(); ++n) {
    if (inner[n] == 0 && result.swallowed.contains(pieces[n].triangle)) result.whole.push_back(pieces[n].corners);
    if (inner[n] == 0 || inner[n] == samples) continue;
    for (std::size_t i = samples * n; i < samples * (n + 1); ++i) {
      if (!is_inside(i)) result.of_pieces_across = std::max(result.of_pieces_across, gaps[i]);
    }
  }
  return result;
}

/// Faces of the new mesh that fill holes: nearer to the filling than to the file's surface.
std::vector<std::size_t> filled_faces(const ReworkedSurface& old, const std::vector<Corners>& now) {
  std::vector<std::size_t> filled;
  if (old.patches.empty()) return filled;
  std::vector<Vec3> middles;
  for (const Corners& t : now) middles.push_back(middle_of(t));
  const std::vector<double> from_old = gaps_of(middles, old.triangles), from_patch = gaps_of(middles, old.patches);
  for (std::size_t f = 0; f < now.size(); ++f) {
    if (from_old[f] > 1e-9 * old.diagonal && from_patch[f] < from_old[f]) filled.push_back(f);
  }
  return filled;
}

}  // namespace

void measure_change(const ReworkedSurface& old, MeshChange& change) {
  const std::vector<Corners> now = triangle_list(change.mesh);
  std::sort(change.removed.begin(), change.removed.end());
  change.removed.erase(std::unique(change.removed.begin(), change.removed.end()), change.removed.end());
  change.moved_error = 1e-4 * old.diagonal;

  std::vector<Corners> kept;
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < old.triangles.size(); ++i) {
    if (std::binary_search(change.removed.begin(), change.removed.end(), old.numbers[i])) continue;
    kept.push_back(old.triangles[i]);
    numbers.push_back(old.numbers[i]);
  }
  double across = 0;
  if (old.united) {
    Outside outside = outside_of(kept, change.mesh, old.diagonal);
    std::set<std::size_t> inside;
    for (const std::size_t i : outside.swallowed) inside.insert(numbers[i]);
    change.inside.assign(inside.begin(), inside.end());
    change.inside_share = outside.area_inside / area_of(old.triangles);
    across = outside.of_pieces_across;
    kept = std::move(outside.whole);
  }
  change.old_to_new = std::max(across, largest_gap(kept, now, change.moved_error));

  change.filled = filled_faces(old, now);
  std::vector<Corners> surface, filling;
  for (std::size_t f = 0; f < now.size(); ++f) {
    (std::binary_search(change.filled.begin(), change.filled.end(), f) ? filling : surface).push_back(now[f]);
  }
  change.filled_share = area_of(filling) / area_of(now);
  change.new_to_old = largest_gap(surface, old.triangles, change.moved_error);
  change.new_volume = mass_properties(change.mesh).volume;
}

}  // namespace tactor
