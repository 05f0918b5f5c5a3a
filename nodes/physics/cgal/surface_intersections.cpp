#include "nodes/physics/cgal/surface_mesh.hpp"

#include <iterator>

#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/box_intersection_d.h>

#include "framework/core/check.hpp"

namespace tactor {

namespace pmp = CGAL::Polygon_mesh_processing;

namespace {

/// Charges each pair of faces whose boxes overlap, because CGAL looks at all of them.
void charge(const SurfaceMesh& surface, const std::string& file, ReadBudget& budget) {
  using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, Face, CGAL::Box_intersection_d::ID_FROM_BOX_ADDRESS>;
  std::vector<Box> boxes;
  boxes.reserve(surface.number_of_faces());
  for (const Face f : surface.faces()) {
    const auto [a, b, c] = corners_of(surface, f);
    boxes.emplace_back(surface.point(a).bbox() + surface.point(b).bbox() + surface.point(c).bbox(), f);
  }
  CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const Box& /*one*/, const Box& /*other*/) {
    if (budget.holds(ReadBudget::step_cost)) return;
    throw InputError(
        file +
        ": looking for faces that cut each other takes too long: too many are long and thin, or meet at one "
        "vertex; remesh it with fewer or rounder faces");
  });
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
