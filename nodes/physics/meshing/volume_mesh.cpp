#include "nodes/physics/meshing/volume_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <vector>

#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_domain_with_polyline_features_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Polyhedral_mesh_domain_3.h>
#include <CGAL/make_mesh_3.h>

#include "framework/core/check.hpp"
#include "nodes/physics/cgal/surface_mesh.hpp"
#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/mesh/mass_properties.hpp"
#include "nodes/physics/mesh/sharp_lines.hpp"

namespace tactor {

namespace {

using Domain = CGAL::Mesh_domain_with_polyline_features_3<CGAL::Polyhedral_mesh_domain_3<SurfaceMesh, Kernel>>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain, CGAL::Default, CGAL::Sequential_tag>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation, Domain::Corner_index, Domain::Curve_index>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

/// The longest edge on a kept line over the largest radius of a circumscribed ball.
constexpr double edge_to_radius = 1.4;

/// The solid of length 1 about the origin, for which CGAL's tolerances are made.
struct UnitSolid {
  explicit UnitSolid(const TriangleMesh& solid)
      : mesh(solid), middle(bounds_of(solid).middle()), length(bounds_of(solid).longest()) {
    for (Vec3& v : mesh.vertices) v = (v - middle) / length;
  }
  TriangleMesh mesh;
  Vec3 middle;
  double length;
};

/// Fills one solid with tetrahedra of any size.
class Filler {
 public:
  /// `kept`: lines of the mesh, by its vertices, that become edges of tetrahedra.
  Filler(const TriangleMesh& mesh, const std::vector<std::vector<int>>& kept)
      : surface_(surface_of(mesh)), domain_(surface_, &CGAL::get_default_random()) {
    std::vector<std::vector<Point>> lines;
    for (const std::vector<int>& line : kept) {
      lines.emplace_back();
      for (const int v : line) {
        const Vec3& p = mesh.vertices[static_cast<std::size_t>(v)];
        lines.back().emplace_back(p.x, p.y, p.z);
      }
    }
    domain_.add_features(lines.begin(), lines.end());
  }

  /// Tetrahedra whose circumscribed balls have radii of at most `radius`.
  Complex filled(double radius, std::size_t most_vertices) {
    namespace parameters = CGAL::parameters;
    // The surface may lie off by this much of the radius.
    constexpr double off_surface = 0.12, smallest_angle = 25, radius_to_edge = 2.5;
    // The domain and the mesher draw from it.
    CGAL::get_default_random() = CGAL::Random(1);
    const Criteria criteria(parameters::edge_size = edge_to_radius * radius, parameters::facet_angle = smallest_angle,
                            parameters::facet_size = radius, parameters::facet_distance = off_surface * radius,
                            parameters::cell_radius_edge_ratio = radius_to_edge, parameters::cell_size = radius);
    return CGAL::make_mesh_3<Complex>(
        domain_, criteria, parameters::no_exude(), parameters::no_perturb(), parameters::manifold(),
        parameters::mesh_3_options(parameters::maximal_number_of_vertices = most_vertices));
  }

  /// Takes out slivers. There is no limit of time, so that the same mesh comes about on every machine; a bound of the
  /// angle (in degrees) keeps the time short.
  void improve(Complex& complex) {
    namespace parameters = CGAL::parameters;
    constexpr double enough = 12;
    CGAL::get_default_random() = CGAL::Random(1);
    CGAL::perturb_mesh_3(complex, domain_, parameters::sliver_bound = enough);
    CGAL::exude_mesh_3(complex, parameters::sliver_bound = enough);
  }

 private:
  // The domain refers to its surface.
  SurfaceMesh surface_;
  Domain domain_;
};

double mean_edge(const Complex& complex) {
  const Triangulation& triangulation = complex.triangulation();
  double sum = 0;
  for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell) {
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) {
        sum += std::sqrt(
            CGAL::squared_distance(triangulation.point(cell, i).point(), triangulation.point(cell, j).point()));
      }
    }
  }
  return sum / (6 * static_cast<double>(complex.number_of_cells_in_complex()));
}

TetMesh tetrahedra_of(const Complex& complex, const UnitSolid& unit) {
  const Triangulation& triangulation = complex.triangulation();
  TetMesh mesh;
  std::map<Triangulation::Vertex_handle, int> numbers;
  for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell) {
    std::array<int, 4> tet{};
    for (int i = 0; i < 4; ++i) {
      const auto [number, is_new] = numbers.try_emplace(cell->vertex(i), static_cast<int>(mesh.nodes.size()));
      if (is_new) {
        const auto p = triangulation.point(cell, i).point();
        mesh.nodes.push_back(unit.middle + unit.length * Vec3{p.x(), p.y(), p.z()});
      }
      tet[static_cast<std::size_t>(i)] = number->second;
    }
    mesh.tets.push_back(tet);
  }
  return mesh;
}

/// What comes nearest to what is asked for.
struct Fitted {
  Complex complex;
  double error =
      std::numeric_limits<double>::infinity();  // of the mean edge, as a logarithm; infinite: nothing came about
};

/// Finds the radius of the balls in a few tries. `too_long`: what is measured of a mesh over what it should be; it
/// grows with the radius as its first power.
template <class TooLong>
Fitted fitted(Filler& filler, double radius, std::size_t most_vertices, const TooLong& too_long) {
  Fitted best;
  constexpr int most_tries = 8;
  // 3 % in length are 10 % in the count; exudation changes that little.
  constexpr double near_enough = 0.02;
  for (int tries = 0; tries < most_tries && best.error > near_enough; ++tries) {
    Complex complex = filler.filled(radius, most_vertices);
    const double ratio = too_long(complex);
    const double error = std::abs(std::log(ratio));
    if (error < best.error) {
      best.error = error;
      best.complex.swap(complex);
    }
    // Where nothing came about, the body was taken for thinner than the balls.
    radius *= std::isfinite(ratio) ? std::clamp(1 / ratio, 0.5, 2.0) : 0.5;
  }
  return best;
}

}  // namespace

TetMesh volume_mesh(const TriangleMesh& solid, const VolumeFineness& fineness, const std::string& file) {
  const UnitSolid unit(solid);
  const double volume = mass_properties(unit.mesh).volume;
  const double wanted_edge = fineness.edge / unit.length;
  const auto too_long = [&](const Complex& complex) {
    if (complex.number_of_cells_in_complex() == 0) return std::numeric_limits<double>::infinity();
    if (wanted_edge > 0) return mean_edge(complex) / wanted_edge;
    return std::cbrt(static_cast<double>(fineness.tetrahedra) /
                     static_cast<double>(complex.number_of_cells_in_complex()));
  };
  const double edge = wanted_edge > 0
                          ? wanted_edge
                          : std::cbrt(6 * std::numbers::sqrt2 * volume / static_cast<double>(fineness.tetrahedra));
  const auto expected = static_cast<std::size_t>(6 * std::numbers::sqrt2 * volume / (edge * edge * edge));
  const double radius = 0.85 * edge;
  constexpr double sharp = std::numbers::pi / 4, long_line = 12, tetrahedra_per_node = 4;
  const std::vector<std::vector<int>> lines = sharp_lines(unit.mesh, sharp, long_line * radius), none;
  // Lines are kept where they do not ask for more nodes than the mesh would have without them, or where nothing comes
  // about without them.
  const bool affordable =
      nodes_on_lines(unit.mesh, lines, edge_to_radius * radius) <= static_cast<double>(expected) / tetrahedra_per_node;
  for (const bool with_lines : {affordable, !affordable}) {
    Filler filler(unit.mesh, with_lines ? lines : none);
    Fitted best = fitted(filler, radius, 2'000 + expected, too_long);
    if (!std::isfinite(best.error)) continue;
    filler.improve(best.complex);
    return tetrahedra_of(best.complex, unit);
  }
  throw InputError(file +
                   ": no tetrahedra fit into the surface, which is too thin or too sharp for so few; ask for more "
                   "tetrahedra (a smaller cell_size)");
}

}  // namespace tactor
