#include "nodes/physics/cgal/surface_mesh.hpp"

#include <array>
#include <cstdio>
#include <iterator>

#include <CGAL/Polygon_mesh_processing/self_intersections.h>

#include "framework/core/check.hpp"

namespace tactor {

namespace pmp = CGAL::Polygon_mesh_processing;

namespace {

/// Charges the pairs of faces that share a vertex, which are all looked at.
void charge(const SurfaceMesh& surface, const std::string& file, ReadBudget& budget) {
  for (const auto v : surface.vertices()) {
    const std::uint64_t faces = surface.degree(v);
    if (budget.holds(faces * faces * ReadBudget::step_cost)) continue;
    const Point& p = surface.point(v);
    std::array<char, 100> place{};
    std::snprintf(place.data(), place.size(), "(%.6g, %.6g, %.6g)", p.x(), p.y(), p.z());
    throw InputError(file + ": " + std::to_string(faces) + " faces meet at " + place.data() +
                     ", so that looking for faces that cut each other takes too long; use fewer and wider faces there");
  }
}

}  // namespace

std::vector<std::pair<Face, Face>> self_intersections(const SurfaceMesh& surface, unsigned most,
                                                      const std::string& file, ReadBudget& budget) {
  charge(surface, file, budget);
  std::vector<std::pair<Face, Face>> pairs;
  pmp::self_intersections(surface, std::back_inserter(pairs), CGAL::parameters::maximum_number(most));
  return pairs;
}

}  // namespace tactor
