#include "nodes/physics/meshing/mesh_rework.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "framework/core/check.hpp"
#include "nodes/physics/cgal/mesh_repair.hpp"
#include "nodes/physics/cgal/surface_mesh.hpp"
#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/mesh/mass_properties.hpp"
#include "nodes/physics/meshing/mesh_parts.hpp"
#include "nodes/physics/meshing/rework_measures.hpp"
#include "nodes/physics/meshing/soup_rework.hpp"
#include "nodes/physics/meshing/surface_rework.hpp"

namespace tactor {

namespace {

TriangleMesh without_flat_faces(const TriangleMesh& mesh) {
  SurfaceMesh surface = surface_of(mesh);
  remove_flat_faces(surface);
  remove_isolated_vertices(surface);
  return triangles_of(surface);
}

TriangleMesh outward(const TriangleMesh& mesh) {
  SurfaceMesh surface = surface_of(mesh);
  if (!is_outward_oriented(surface)) orient_outwards(surface);
  return triangles_of(surface);
}

/// One mesh on its way from a soup to a solid that it was not.
class Rework {
 public:
  Rework(const std::string& file, const RepairOptions& options) : file_(file), options_(options) {}

  MeshChange run(PolygonSoup polygons) {
    if (polygons.polygons.empty()) throw InputError(file_ + ": the file has no faces; export the surface as polygons");
    MeshReport told;
    soup_ = tidy(polygons, told);
    file_polygons_ = std::move(polygons);
    change_.changes = told.repairs;
    ReadBudget budget = budget_for_checks(file_, file_polygons_);
    cut_polygons(budget);
    keep_original();
    if (options_.wrap) {
      orient();
      wrap();
    } else {
      join_rims();
      orient();
      drop_loose_pieces();
      fill();
      part_what_touches();
      mesh_ = without_flat_faces(mesh_);
      untangle(budget);
    }
    check();
    measure();
    return std::move(change_);
  }

 private:
  void tell(std::string change) { change_.changes.push_back(std::move(change)); }
  std::string share(double length) const { return short_text(100 * length / diagonal_) + " % of the diagonal"; }

  void cut_polygons(ReadBudget& budget) {
    NumberedSoup cut{std::move(soup_.points), {}, {}};
    std::size_t polygons = 0;
    for (std::size_t i = 0; i < soup_.polygons.size(); ++i) {
      const auto& p = soup_.polygons[i];
      polygons += p.size() > 3 ? 1 : 0;
      for (const auto& t : triangles_of_polygon(cut.points, p, soup_.numbers[i], budget)) {
        cut.polygons.push_back(t);
        cut.numbers.push_back(soup_.numbers[i]);
      }
    }
    soup_ = std::move(cut);
    if (polygons > 0) tell(counted(polygons, "polygon") + were(polygons) + "cut into triangles");
  }

  std::vector<std::vector<std::size_t>> triangles_of_polygon(const std::vector<Vec3>& points,
                                                             const std::vector<std::size_t>& polygon,
                                                             std::size_t number, ReadBudget& budget) const {
    if (polygon.size() == 3) return {polygon};
    SurfaceMesh surface;
    std::vector<SurfaceMesh::Vertex_index> corners;
    for (const std::size_t c : polygon) corners.push_back(surface.add_vertex({points[c].x, points[c].y, points[c].z}));
    surface.add_face(corners);
    const FaceNumbers numbers = surface.add_property_map<Face, std::size_t>("f:number", number).first;
    std::vector<std::vector<std::size_t>> triangles;
    if (surface.number_of_faces() == 1 && cut_into_triangles(surface, numbers, file_, budget)) {
      for (const auto& f : triangles_of(surface).faces) {
        triangles.emplace_back();
        for (const int corner : f) triangles.back().push_back(polygon[static_cast<std::size_t>(corner)]);
      }
      return triangles;
    }
    for (std::size_t k = 2; k < polygon.size(); ++k) triangles.push_back({polygon[0], polygon[k - 1], polygon[k]});
    return triangles;
  }

  void keep_original() {
    Bounds bounds;
    for (const Vec3& p : soup_.points) bounds.add(p);
    diagonal_ = norm(bounds.size());
    for (const auto& t : soup_.polygons) old_.push_back({soup_.points[t[0]], soup_.points[t[1]], soup_.points[t[2]]});
    old_numbers_ = soup_.numbers;
    double area = 0;
    for (const Corners& t : old_) area += area_of(t);
    if (!(area > 0)) throw InputError(file_ + ": no face has an area; export the surface as polygons");
    old_area_ = area;
    for (const Corners& t : old_) {
      const Vec3 m = bounds.middle();
      change_.old_volume += dot(t[0] - m, cross(t[1] - m, t[2] - m)) / 6;
    }
  }

  /// Vertices that nearly coincide, edges that have a vertex more on one side, and faces too many at an edge.
  void join_rims() {
    if (options_.merge > 0) {
      const std::size_t merged = merge_rims(soup_, options_.merge);
      if (merged > 0) {
        tell(counted(merged, "vertex") + " of open edges" + were(merged) + "merged with one nearer than " +
             short_text(options_.merge));
      }
    }
    std::size_t cuts = 0;
    for (int round = 0; round < 20; ++round) {
      const std::size_t more = cut_at_rims(soup_, options_.merge);
      cuts += more;
      if (more == 0) break;
    }
    if (cuts > 0) tell(counted(cuts, "edge") + were(cuts) + "cut at a vertex that lay on it");
    const std::size_t fins = remove_fins(soup_, change_.removed);
    if (fins > 0)
      tell(counted(fins, "face") + were(fins) + "removed that stuck out of the surface or divided its inside");
  }

  void orient() {
    const bool turned = find_edge_faults(soup_, std::vector<bool>(soup_.polygons.size(), false)).against > 0;
    std::vector<Point> points;
    for (const Vec3& p : soup_.points) points.emplace_back(p.x, p.y, p.z);
    orient_polygons(points, soup_.polygons);
    mesh_ = stitched(points, soup_.polygons);
    TACTOR_DEMAND(mesh_.faces.size() == soup_.numbers.size());
    if (turned) {
      tell("faces were turned to look to the same side as their neighbours");
      const Vec3 m = bounds_of(mesh_).middle();
      change_.old_volume = 0;
      for (const Corners& t : triangle_list(mesh_)) {
        change_.old_volume += dot(t[0] - m, cross(t[1] - m, t[2] - m)) / 6;
      }
    }
    change_.old_volume = std::abs(change_.old_volume);
  }

  /// For each body whether all of it lies in one plane, as nothing that has an inside does.
  std::vector<bool> flat_bodies(const std::vector<std::size_t>& body, std::size_t count) const {
    std::vector<Vec3> normal(count), place(count);
    std::vector<double> largest(count, 0);
    for (std::size_t f = 0; f < body.size(); ++f) {
      const Corners t = corners_at(mesh_, f);
      if (area_of(t) <= largest[body[f]]) continue;
      largest[body[f]] = area_of(t);
      normal[body[f]] = cross(t[1] - t[0], t[2] - t[0]) / (2 * area_of(t));
      place[body[f]] = t[0];
    }
    std::vector<bool> flat(count, true);
    for (std::size_t f = 0; f < body.size(); ++f) {
      for (const Vec3& p : corners_at(mesh_, f)) {
        if (std::abs(dot(p - place[body[f]], normal[body[f]])) > 1e-6 * diagonal_) flat[body[f]] = false;
      }
    }
    return flat;
  }

  /// Pieces that are open and small or flat, beside which there is more.
  void drop_loose_pieces() {
    constexpr double small = 0.01;  // of the area
    const auto [body, count] = bodies_of(mesh_);
    const auto edges = directed_edges(mesh_);
    std::vector<double> area(count, 0);
    std::vector<bool> open(count, false);
    for (std::size_t f = 0; f < mesh_.faces.size(); ++f) {
      area[body[f]] += area_of(corners_at(mesh_, f));
      for (std::size_t k = 0; k < 3; ++k) {
        if (!edges.contains({mesh_.faces[f][(k + 1) % 3], mesh_.faces[f][k]})) open[body[f]] = true;
      }
    }
    const std::vector<bool> flat = flat_bodies(body, count);
    std::vector<bool> drop(count, false);
    std::size_t pieces = 0;
    double dropped = 0;
    for (std::size_t b = 0; b < count; ++b) {
      if (!open[b] || (area[b] > small * old_area_ && !flat[b])) continue;
      drop[b] = true;
      ++pieces;
      dropped += area[b];
    }
    if (pieces == 0 || pieces == count) return;
    for (std::size_t f = 0; f < mesh_.faces.size(); ++f) {
      if (drop[body[f]]) change_.removed.push_back(soup_.numbers[f]);
    }
    mesh_ = part_of(mesh_, [&, of = body](std::size_t f) { return !drop[of[f]]; });
    tell(counted(pieces, "loose piece") + were(pieces) + "removed, with " + short_text(100 * dropped / old_area_) +
         " % of the area");
  }

  void fill() {
    if (is_closed(mesh_)) return;
    FilledHoles result = fill_holes(mesh_);
    const auto widest = [](const std::vector<Hole>& holes) {
      return *std::max_element(holes.begin(), holes.end(),
                               [](const Hole& a, const Hole& b) { return a.width < b.width; });
    };
    if (!result.failed.empty()) {
      const Hole& hole = result.failed.front();
      throw InputError(file_ + ": the hole about " + place_text(hole.place) + " with " + counted(hole.edges, "edge") +
                       " cannot be filled: its rim cuts itself or is not a ring" + wrap_hint);
    }
    const Hole hole = widest(result.filled);
    const auto too_wide = static_cast<std::size_t>(std::count_if(
        result.filled.begin(), result.filled.end(), [&](const Hole& h) { return h.width > options_.max_hole; }));
    const std::string where =
        short_text(hole.width) + " wide (" + share(hole.width) + ") about " + place_text(hole.place);
    if (too_wide > 0) {
      throw InputError(file_ + ": " + counted(too_wide, "hole") + (too_wide == 1 ? " is" : " are") +
                       " wider than --max-hole " + short_text(options_.max_hole) + ", the widest " + where + ", with " +
                       counted(hole.edges, "edge") + "; --max-hole " + short_text(1.01 * hole.width) +
                       " fills it, where the mesh is to be a solid there");
    }
    double filling = 0;
    for (const Corners& t : result.patches) filling += area_of(t);
    if (!options_.sheets && filling > 0.5 * old_area_) {
      throw InputError(file_ +
                       ": the mesh is an open sheet rather than a body with a hole: the patch to close it has " +
                       short_text(100 * filling / old_area_) + " % of its area; --max-hole " +
                       short_text(1.01 * hole.width) + " closes it nevertheless");
    }
    mesh_ = std::move(result.mesh);
    patches_ = std::move(result.patches);
    tell(counted(result.filled.size(), "hole") + were(result.filled.size()) + "filled, the widest " + where);
  }

  /// Moves vertices at one place apart, each towards its own neighbours: parts of a solid may not touch.
  void part_what_touches() {
    std::map<std::array<double, 3>, std::vector<std::size_t>> places;
    for (std::size_t i = 0; i < mesh_.vertices.size(); ++i) {
      const Vec3& p = mesh_.vertices[i];
      places[{p.x, p.y, p.z}].push_back(i);
    }
    std::vector<bool> moves(mesh_.vertices.size(), false);
    std::size_t count = 0;
    for (const auto& [place, vertices] : places) {
      if (vertices.size() < 2) continue;
      ++count;
      for (const std::size_t i : vertices) moves[i] = true;
    }
    if (count == 0) return;
    std::vector<Vec3> sum(mesh_.vertices.size());
    std::vector<double> corners(mesh_.vertices.size(), 0), shortest(mesh_.vertices.size(), diagonal_);
    for (const auto& f : mesh_.faces) {
      for (std::size_t k = 0; k < 3; ++k) {
        const auto i = static_cast<std::size_t>(f[k]);
        for (const std::size_t other : {(k + 1) % 3, (k + 2) % 3}) {
          const Vec3 way = mesh_.vertices[static_cast<std::size_t>(f[other])] - mesh_.vertices[i];
          sum[i] += way;
          corners[i] += 1;
          shortest[i] = std::min(shortest[i], norm(way));
        }
      }
    }
    double farthest = 0;
    for (std::size_t i = 0; i < mesh_.vertices.size(); ++i) {
      if (!moves[i] || !(corners[i] > 0)) continue;
      const Vec3 way = limited(sum[i] / corners[i], std::min(1e-4 * diagonal_, 0.1 * shortest[i]));
      mesh_.vertices[i] += way;
      farthest = std::max(farthest, norm(way));
    }
    tell("parts that touched in " + counted(count, "place") + " were moved apart there, by " + short_text(farthest) +
         " at most");
  }

  /// Bodies that cut themselves are smoothed there, bodies that overlap are united.
  void untangle(ReadBudget& budget) {
    for (int round = 0; round < 3; ++round) {
      constexpr unsigned most = 1'000'000;
      const std::vector<std::pair<Face, Face>> pairs = self_intersections(surface_of(mesh_), most, file_, budget);
      if (pairs.empty()) return;
      const auto [body, count] = bodies_of(mesh_);
      std::vector<std::size_t> inner(count, 0);
      std::set<std::pair<std::size_t, std::size_t>> crossing;
      for (const auto& [f, g] : pairs) {
        const std::size_t a = body[f], b = body[g];
        if (a == b) {
          ++inner[a];
        } else {
          crossing.emplace(std::min(a, b), std::max(a, b));
        }
      }
      std::vector<TriangleMesh> parts;
      std::size_t cut = 0, inside = 0;
      for (std::size_t b = 0; b < count; ++b) {
        parts.push_back(part_of(mesh_, [&, of = body](std::size_t f) { return of[f] == b; }));
        constexpr std::size_t most_tangled = 500;  // beyond, CGAL works for minutes and seldom ends well
        if (inner[b] == 0 || inner[b] > most_tangled) continue;
        if (std::optional<TriangleMesh> outer = without_inner_parts(parts[b])) {
          parts[b] = std::move(*outer);
          inside += inner[b];
          continue;
        }
        parts[b] = mended(untangled(parts[b]));
        cut += inner[b];
      }
      if (cut > 0) tell(counted(cut, "pair") + " of faces that cut each other" + were(cut) + "smoothed or filled anew");
      if (inside > 0) {
        tell("where " + counted(inside, "pair") + " of faces cut each other, what lay inside was taken out");
        swallowing_ = true;
      }
      unite(parts, crossing);
      mesh_ = {};
      for (const TriangleMesh& part : parts) append(mesh_, part);
    }
  }

  /// What of a body that cuts itself is its outside, if that is a solid.
  std::optional<TriangleMesh> without_inner_parts(const TriangleMesh& part) const {
    TriangleMesh outer = outermost(outward(part));
    if (outer.faces.empty()) return std::nullopt;
    MeshReport ignored;
    try {
      return repaired_solid(soup_of(outer), file_, ignored);
    } catch (const InputError&) {
      return std::nullopt;
    }
  }

  /// What untangling left open.
  TriangleMesh mended(const TriangleMesh& mesh) const {
    if (mesh.faces.empty()) {
      throw InputError(file_ + ": the surface cuts itself so often that a repair would leave nothing of it" +
                       wrap_hint);
    }
    if (is_closed(mesh)) return mesh;
    return fill_holes(mesh).mesh;
  }

  void unite(std::vector<TriangleMesh>& parts, const std::set<std::pair<std::size_t, std::size_t>>& crossing) {
    std::vector<std::size_t> now(parts.size()), bodies(parts.size(), 1);
    std::iota(now.begin(), now.end(), std::size_t{0});
    for (const auto& [a, b] : crossing) {
      const std::size_t first = now[a], second = now[b];
      if (first == second || !is_closed(parts[first]) || !is_closed(parts[second])) continue;
      TriangleMesh both = united(outward(parts[first]), outward(parts[second]));
      if (both.faces.empty()) continue;  // the check tells
      parts[first] = std::move(both);
      parts[second] = {};
      bodies[first] += std::exchange(bodies[second], 0);
      std::replace(now.begin(), now.end(), second, first);
    }
    std::size_t before = 0, after = 0;
    for (const std::size_t n : bodies) {
      if (n < 2) continue;
      before += n;
      ++after;
    }
    if (after == 0) return;
    tell(std::to_string(before) + " bodies that overlapped were united" +
         (after > 1 ? " to " + std::to_string(after) : ""));
    swallowing_ = true;
  }

  void wrap() {
    const double alpha = diagonal_ / 100, offset = diagonal_ / 1000;
    mesh_ = wrapped_around(old_, alpha, offset);
    tell("a new surface was made around everything, " + short_text(offset) +
         " away, into which no ball of the radius " + short_text(alpha) + " enters from outside");
  }

  void check() {
    MeshReport report;
    try {
      change_.mesh = repaired_solid(soup_of(mesh_), file_, report);
    } catch (const InputError& error) {
      throw InputError(std::string(error.what()) + "; this is what is left after the repair" +
                       (options_.wrap ? "" : wrap_hint));
    }
    change_.report.warnings = report.warnings;
    for (const std::string& repair : report.repairs) tell(repair);
  }

  void measure() {
    measure_change({old_, old_numbers_, patches_, swallowing_, diagonal_}, change_);
    add_doubles(change_.removed);
    add_doubles(change_.inside);
  }

  /// Of faces at the same place one was kept; what became of it became of all of them.
  void add_doubles(std::vector<std::size_t>& numbers) const {
    if (numbers.empty()) return;
    const auto key = [&](std::size_t number) {
      std::vector<std::array<double, 3>> corners;
      for (const std::size_t c : file_polygons_.polygons[number]) {
        const Vec3& p = file_polygons_.points[c];
        corners.push_back({p.x, p.y, p.z});
      }
      std::sort(corners.begin(), corners.end());
      return corners;
    };
    std::set<std::vector<std::array<double, 3>>> told;
    for (const std::size_t number : numbers) told.insert(key(number));
    numbers.clear();
    for (std::size_t number = 0; number < file_polygons_.polygons.size(); ++number) {
      if (told.contains(key(number))) numbers.push_back(number);
    }
  }

  static constexpr const char* wrap_hint = "; as a last resort --wrap makes a new surface around everything";

  const std::string& file_;
  const RepairOptions options_;
  MeshChange change_;
  PolygonSoup file_polygons_;
  NumberedSoup soup_;  // triangles
  TriangleMesh mesh_;
  double diagonal_ = 0, old_area_ = 0;
  std::vector<Corners> old_;
  std::vector<std::size_t> old_numbers_;
  std::vector<Corners> patches_;
  bool swallowing_ = false;
};

}  // namespace

MeshChange reworked_solid(PolygonSoup soup, const std::string& file, const RepairOptions& options) {
  return Rework(file, options).run(std::move(soup));
}

}  // namespace tactor
