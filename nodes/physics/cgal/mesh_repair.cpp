#include "nodes/physics/cgal/mesh_repair.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <utility>
#include <vector>

#include "framework/core/check.hpp"
#include "nodes/physics/cgal/surface_mesh.hpp"
#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/mesh/mass_properties.hpp"
#include "nodes/physics/mesh/soup_topology.hpp"

namespace tactor {

namespace {

std::string text(double x, double y, double z) {
  std::array<char, 100> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "(%.6g, %.6g, %.6g)", x, y, z);
  return buffer.data();
}
std::string text(const Vec3& p) {
  return text(p.x, p.y, p.z);
}
std::string text(const Point& p) {
  return text(p.x(), p.y(), p.z());
}

/// One mesh on its way from soup to solid.
class Repair {
 public:
  Repair(PolygonSoup soup, const std::string& file, MeshReport& report)
      : file_(file), report_(report), faces_of_file_(soup.polygons.size()), budget_(budget_for_checks(file, soup)) {
    if (soup.polygons.empty()) refuse("the file has no faces; export the surface as polygons");
    soup_ = tidy(std::move(soup), report);
    for (std::size_t i = 0; i < soup_.polygons.size(); ++i) {
      std::vector<std::size_t> sorted = soup_.polygons[i];
      std::sort(sorted.begin(), sorted.end());
      if (const auto twice = std::adjacent_find(sorted.begin(), sorted.end()); twice != sorted.end()) {
        refuse("face " + std::to_string(soup_.numbers[i]) + " touches itself at " + text(soup_.points[*twice]) +
               "; cut it into triangles in a modeller");
      }
    }
  }

  TriangleMesh solid() {
    close();
    orient_soup();
    make_surface();
    repair_flat_faces();
    // Of faces that are gone; CGAL's orientation does not bear them.
    remove_isolated_vertices(surface_);
    check_self_intersection();
    orient_outwards();
    TriangleMesh mesh = triangles_of(surface_);
    check_measures(mesh);
    return mesh;
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const { throw InputError(file_ + ": " + what); }
  /// For faults that mesh_rework.hpp is made for.
  [[noreturn]] void refuse_repairable(const std::string& what) const {
    report_.repairable = true;
    refuse(what);
  }

  std::string number_list(const std::vector<std::size_t>& polygons) const {
    constexpr std::size_t most = 6;
    std::string list;
    for (std::size_t i = 0; i < std::min(polygons.size(), most); ++i) {
      list += (i == 0 ? "" : ", ") + std::to_string(soup_.numbers[polygons[i]]);
    }
    return list + (polygons.size() > most ? ", ..." : "");
  }

  /// Refuses what is not closed or not manifold. Faces without area that hang on to a closed rest go first.
  void close() {
    std::vector<bool> flat(soup_.polygons.size(), false);
    for (std::size_t i = 0; i < flat.size(); ++i) flat[i] = is_flat(soup_.polygons[i]);
    const std::vector<bool> nothing(flat.size(), false);
    EdgeFaults faults = find_edge_faults(soup_, nothing);
    if (!faults.closed_and_manifold() && find_edge_faults(soup_, flat).closed_and_manifold()) {
      const auto n = static_cast<std::size_t>(std::count(flat.begin(), flat.end(), true));
      report_.repairs.push_back(counted(n, "face without area") + were(n) + "removed");
      remove_polygons(soup_, flat);
      faults = find_edge_faults(soup_, std::vector<bool>(soup_.polygons.size(), false));
    }
    if (soup_.polygons.empty()) refuse("no face has an area; export the surface as polygons");
    if (faults.first) {
      const std::string edge = text(soup_.points[faults.first->a]) + " to " + text(soup_.points[faults.first->b]);
      if (faults.branches > 0) {
        refuse_repairable("the surface is not manifold: " + counted(faults.branches, "edge") +
                          (faults.branches == 1 ? " belongs" : " belong") + " to more than two faces, the first from " +
                          edge + " to the faces " + number_list(faults.first->polygons) +
                          "; take out inner walls, or keep bodies that touch apart, in a modeller");
      }
      refuse_repairable("the surface is not closed: " + counted(faults.borders, "edge") +
                        (faults.borders == 1 ? " has" : " have") + " a face on one side only, the first from " + edge +
                        " at face " + number_list(faults.first->polygons) +
                        "; fill the holes in a modeller, and merge vertices that nearly coincide");
    }
    if (const std::vector<std::size_t> ties = find_bow_ties(soup_); !ties.empty()) {
      refuse_repairable("the surface is not manifold: parts of it touch in " + counted(ties.size(), "vertex") +
                        ", the first at " + text(soup_.points[ties.front()]) +
                        "; keep the parts apart, or join them along a face, in a modeller");
    }
    turned_.assign(faces_of_file_, false);
    inconsistent_ = faults.against > 0;
  }

  bool is_flat(const std::vector<std::size_t>& polygon) const {
    const auto point = [&](std::size_t i) {
      const Vec3& p = soup_.points[polygon[i]];
      return Point(p.x, p.y, p.z);
    };
    for (std::size_t i = 2; i < polygon.size(); ++i) {
      if (!CGAL::collinear(point(0), point(1), point(i))) return false;
    }
    return true;
  }

  /// Lets neighbours go through their edges in opposite directions.
  void orient_soup() {
    for (const Vec3& p : soup_.points) points_.emplace_back(p.x, p.y, p.z);
    if (!inconsistent_) return;
    const std::vector<std::vector<std::size_t>> before = soup_.polygons;
    if (!orient_polygons(points_, soup_.polygons)) {
      refuse("the surface has only one side (as a Moebius band), so it has no inside; rebuild it in a modeller");
    }
    for (std::size_t i = 0; i < before.size(); ++i) {
      if (before[i] != soup_.polygons[i]) turned_[soup_.numbers[i]] = true;
    }
  }

  void make_surface() {
    surface_ = surface_of(points_, soup_.polygons);
    numbers_ = surface_.add_property_map<Face, std::size_t>("f:number", 0).first;
    TACTOR_DEMAND(surface_.number_of_faces() == soup_.numbers.size());
    std::size_t polygons = 0, i = 0;
    for (const Face f : surface_.faces()) {
      polygons += soup_.polygons[i].size() > 3 ? 1 : 0;
      numbers_[f] = soup_.numbers[i++];
    }
    if (polygons == 0) return;
    if (const std::optional<Face> face = tangled_face(surface_)) {
      refuse("face " + std::to_string(numbers_[*face]) + " (counted from 0) has " +
             std::to_string(surface_.degree(*face)) +
             " corners and crosses itself, so that it cannot be cut into triangles; do that in a modeller");
    }
    if (!cut_into_triangles(surface_, numbers_, file_, budget_)) {
      refuse("a face of more than three corners cannot be cut into triangles; do that in a modeller");
    }
    report_.repairs.push_back(counted(polygons, "polygon") + were(polygons) + "cut into triangles");
  }

  bool is_flat(Face f) const {
    const auto corners = corners_of(surface_, f);
    return CGAL::collinear(surface_.point(corners[0]), surface_.point(corners[1]), surface_.point(corners[2]));
  }

  /// Flips and collapses edges where that takes away faces without area and leaves the rest as it is.
  void repair_flat_faces() {
    std::size_t flat = 0;
    for (const Face f : surface_.faces()) flat += is_flat(f) ? 1 : 0;
    if (flat == 0) return;
    remove_flat_faces(surface_);
    for (const Face f : surface_.faces()) {
      if (is_flat(f)) {
        refuse_repairable("face " + std::to_string(numbers_[f]) + " at " +
                          text(surface_.point(corners_of(surface_, f)[0])) +
                          " has no area and cannot be removed automatically; remove it in a modeller");
      }
    }
    if (surface_.number_of_faces() == 0) refuse("no face has an area; export the surface as polygons");
    report_.repairs.push_back(counted(flat, "face without area") + were(flat) + "removed");
  }

  void check_self_intersection() {
    constexpr unsigned most = 1000;
    const std::vector<std::pair<Face, Face>> pairs = self_intersections(surface_, most, file_, budget_);
    if (pairs.empty()) return;
    std::pair<std::size_t, std::size_t> first{std::numeric_limits<std::size_t>::max(), 0};
    Face place;
    for (const auto& [f, g] : pairs) {
      const std::pair<std::size_t, std::size_t> numbers = std::minmax(numbers_[f], numbers_[g]);
      if (numbers < first) first = numbers, place = numbers_[f] == numbers.first ? f : g;
    }
    const std::string count =
        pairs.size() >= most ? std::to_string(most) + " or more pairs" : counted(pairs.size(), "pair");
    refuse_repairable("the surface cuts itself: " + count +
                      " of faces meet where they are not neighbours, the first faces " + std::to_string(first.first) +
                      " and " + std::to_string(first.second) + " near " +
                      text(surface_.point(corners_of(surface_, place)[0])) +
                      "; unite overlapping parts (a Boolean union) in a modeller");
  }

  /// Outer shells look outwards, cavities into themselves.
  void orient_outwards() {
    if (!is_outward_oriented(surface_)) {
      std::vector<std::array<SurfaceMesh::Vertex_index, 3>> before;
      for (const Face f : surface_.faces()) before.push_back(corners_of(surface_, f));
      tactor::orient_outwards(surface_);
      std::vector<bool> changed(faces_of_file_, false);
      std::size_t i = 0;
      for (const Face f : surface_.faces()) {
        std::array<SurfaceMesh::Vertex_index, 3> after = corners_of(surface_, f);
        std::rotate(after.begin(), std::find(after.begin(), after.end(), before[i][0]), after.end());
        if (after != before[i++]) changed[numbers_[f]] = true;
      }
      for (std::size_t n = 0; n < changed.size(); ++n) turned_[n] = turned_[n] != changed[n];
    }
    const auto n = static_cast<std::size_t>(std::count(turned_.begin(), turned_.end(), true));
    if (n > 0) report_.repairs.push_back(counted(n, "face") + were(n) + "turned round to look out of the material");
  }

  /// What exact predicates accept and floating-point forces do not bear.
  void check_measures(const TriangleMesh& mesh) const {
    const double volume = mass_properties(mesh).volume, area = surface_area(mesh);
    constexpr double least_thickness = 1e-9;
    if (!(volume > least_thickness * norm(bounds_of(mesh).size()) * area)) {
      refuse("the surface encloses almost no volume (" + std::to_string(volume) +
             " cubic units of the file); contact needs a body with a thickness");
    }
    constexpr double least_height = 1e-12, thin_height = 1e-4;
    std::size_t thin = 0, first_thin = 0;
    auto face = surface_.faces().begin();
    for (const auto& f : mesh.faces) {
      const auto corner = [&](std::size_t i) { return mesh.vertices[static_cast<std::size_t>(f[i])]; };
      double longest = 0;
      for (std::size_t i = 0; i < 3; ++i) longest = std::max(longest, norm(corner((i + 1) % 3) - corner(i)));
      const double height = norm(doubled_area_normal(mesh, f)) / longest;
      const std::size_t number = numbers_[*face++];
      if (!(height > least_height * longest) || !(height > std::numeric_limits<double>::min())) {
        refuse("face " + std::to_string(number) + " at " + text(corner(0)) +
               " is so thin that its direction is lost in rounding; remove it in a modeller");
      }
      if (height < thin_height * longest && thin++ == 0) first_thin = number;
    }
    if (thin > 0) {
      report_.warnings.push_back(counted(thin, "face") + (thin == 1 ? " is" : " are") +
                                 " more than 10,000 times as long as high, the first face " +
                                 std::to_string(first_thin) +
                                 "; contact is smoother and faster on a finer or remeshed surface");
    }
    constexpr std::size_t many_faces = 250'000;
    if (mesh.faces.size() > many_faces) {
      report_.warnings.push_back("it has " + std::to_string(mesh.faces.size()) +
                                 " faces; contact is as smooth and much faster on fewer than " +
                                 std::to_string(many_faces) + ", decimate it in a modeller");
    }
  }

  const std::string& file_;
  MeshReport& report_;
  const std::size_t faces_of_file_;
  ReadBudget budget_;
  NumberedSoup soup_;
  bool inconsistent_ = false;
  std::vector<bool> turned_;  // by the number of a face in the file: it goes round the other way now
  std::vector<Point> points_;
  SurfaceMesh surface_;
  FaceNumbers numbers_;
};

}  // namespace

TriangleMesh repaired_solid(PolygonSoup soup, const std::string& file, MeshReport& report) {
  return Repair(std::move(soup), file, report).solid();
}

}  // namespace tactor
