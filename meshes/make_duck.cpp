// Makes duck.off: a smooth union of ellipsoids shaped like a bath duck, meshed and brought to an exact face count.
#include <cmath>
#include <cstdio>

#include <CGAL/Complex_2_in_triangulation_3.h>
#include <CGAL/IO/facets_in_complex_2_to_triangle_mesh.h>
#include <CGAL/Implicit_surface_3.h>
#include <CGAL/Surface_mesh_default_triangulation_3.h>
#include <CGAL/make_surface_mesh.h>

#include "framework/core/check.hpp"
#include "meshes/decimate.hpp"
#include "meshes/write_off.hpp"
#include "nodes/physics/cgal/surface_mesh.hpp"
#include "nodes/physics/mesh/make_solid.hpp"

using namespace tactor;

namespace {

using Triangulation = CGAL::Surface_mesh_default_triangulation_3;
using Traits = Triangulation::Geom_traits;

constexpr std::size_t face_count = 13926;

/// The smooth minimum of a and b: rounds the seam over about `blend`. From I. Quilez, "Smooth minimum" (polynomial).
double smooth_min(double a, double b, double blend) {
  const double t = std::max(blend - std::abs(a - b), 0.0) / blend;
  return std::min(a, b) - t * t * blend / 4;
}

/// About the signed distance to an ellipsoid with these half axes, m.
double ellipsoid(const Vec3& p, const Vec3& center, const Vec3& half) {
  const Vec3 d = p - center;
  const double k0 = norm({d.x / half.x, d.y / half.y, d.z / half.z});
  const double k1 = norm({d.x / (half.x * half.x), d.y / (half.y * half.y), d.z / (half.z * half.z)});
  return k1 > 0 ? k0 * (k0 - 1) / k1 : -std::min({half.x, half.y, half.z});
}

/// Negative inside. The duck looks along x and stands along z; lengths in m.
Traits::FT duck(const Traits::Point_3& q) {
  const Vec3 p{q.x(), q.y(), q.z()};
  const double body = ellipsoid(p, {0, 0, 0}, {0.042, 0.030, 0.025});
  const double tail = ellipsoid(p, {-0.043, 0, 0.014}, {0.014, 0.011, 0.007});
  const double head = ellipsoid(p, {0.025, 0, 0.038}, {0.019, 0.018, 0.018});
  const double beak = ellipsoid(p, {0.046, 0, 0.035}, {0.010, 0.009, 0.004});
  double f = smooth_min(body, tail, 0.014);
  for (const double side : {-1.0, 1.0}) {
    const double wing = ellipsoid(p, {-0.006, side * 0.027, 0.006}, {0.021, 0.007, 0.012});
    f = smooth_min(f, wing, 0.005);
  }
  return smooth_min(smooth_min(f, head, 0.012), beak, 0.004);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) throw InputError("usage: make_duck OUTPUT.off");
  // The mesher draws from it; the same seed makes the same duck.
  CGAL::get_default_random() = CGAL::Random(1);
  Triangulation triangulation;
  CGAL::Complex_2_in_triangulation_3<Triangulation> complex(triangulation);
  const CGAL::Implicit_surface_3<Traits, Traits::FT (*)(const Traits::Point_3&)> implicit(
      duck, Traits::Sphere_3(CGAL::ORIGIN, 0.1 * 0.1), 1e-6);
  // Facets of at least 30 degrees, with circumscribed circles of at most 0.9 mm, within 0.05 mm of the surface.
  const CGAL::Surface_mesh_default_criteria_3<Triangulation> criteria(30.0, 0.0009, 0.00005);
  CGAL::make_surface_mesh(complex, implicit, criteria, CGAL::Manifold_tag());
  SurfaceMesh surface;
  CGAL::facets_in_complex_2_to_triangle_mesh(complex, surface);
  MeshReport report;
  const TriangleMesh meshed = make_solid(soup_of(surface), "duck", report);
  for (const std::string& repair : report.repairs) std::printf("duck: %s\n", repair.c_str());
  write_off(argv[1], decimate(meshed, face_count, "duck"), "a duck of smoothly joined ellipsoids; metres");
  std::printf("duck: %zu faces, from %zu\n", face_count, meshed.faces.size());
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "make_duck: %s\n", e.what());
  return 1;
}
