#include "meshes/implicit_surface.hpp"

#include <cstdio>

#include <CGAL/Complex_2_in_triangulation_3.h>
#include <CGAL/IO/facets_in_complex_2_to_triangle_mesh.h>
#include <CGAL/Implicit_surface_3.h>
#include <CGAL/Surface_mesh_default_triangulation_3.h>
#include <CGAL/make_surface_mesh.h>

#include "meshes/decimate.hpp"
#include "nodes/physics/cgal/surface_mesh.hpp"
#include "nodes/physics/mesh/make_solid.hpp"

namespace tactor {

namespace {

using Triangulation = CGAL::Surface_mesh_default_triangulation_3;
using Traits = Triangulation::Geom_traits;

/// The body as CGAL asks for it.
struct Values {
  ImplicitBody body;
  Traits::FT operator()(const Traits::Point_3& q) const { return body({q.x(), q.y(), q.z()}); }
};

}  // namespace

TriangleMesh mesh_implicit(ImplicitBody body, const ImplicitFineness& fineness, std::size_t faces,
                           const std::string& name) {
  // The mesher draws from it; the same seed makes the same mesh.
  CGAL::get_default_random() = CGAL::Random(1);
  Triangulation triangulation;
  CGAL::Complex_2_in_triangulation_3<Triangulation> complex(triangulation);
  const CGAL::Implicit_surface_3<Traits, Values> implicit(
      Values{body}, Traits::Sphere_3(CGAL::ORIGIN, fineness.within * fineness.within), 1e-6);
  constexpr double smallest_angle = 30;  // degrees, of a facet
  const CGAL::Surface_mesh_default_criteria_3<Triangulation> criteria(smallest_angle, fineness.facets,
                                                                      fineness.surface);
  CGAL::make_surface_mesh(complex, implicit, criteria, CGAL::Manifold_tag());
  SurfaceMesh surface;
  CGAL::facets_in_complex_2_to_triangle_mesh(complex, surface);
  MeshReport report;
  const TriangleMesh meshed = make_solid(soup_of(surface), name, report);
  for (const std::string& repair : report.repairs) std::printf("%s: %s\n", name.c_str(), repair.c_str());
  std::printf("%s: %zu faces, from %zu\n", name.c_str(), faces, meshed.faces.size());
  return decimate(meshed, faces, name);
}

}  // namespace tactor
