// Makes liver.off: an organ of two lobes, by smoothly joined ellipsoids, meshed and brought to an exact face count.
#include <cstdio>

#include "framework/core/check.hpp"
#include "meshes/implicit_surface.hpp"
#include "meshes/write_off.hpp"

using namespace tactor;

namespace {

constexpr std::size_t face_count = 2600;

/// Negative inside. The organ lies on its hollow side with the dome along +z; the large lobe is at -x, the edge with
/// the notch between the lobes at -y. No part is thinner than about 10 mm. Lengths in m.
double liver(const Vec3& p) {
  const double dome = ellipsoid(p, {-0.027, 0.010, 0.000}, {0.042, 0.041, 0.029});
  const double lower = ellipsoid(p, {-0.034, -0.019, -0.005}, {0.030, 0.033, 0.020});
  const double middle = ellipsoid(p, {0.020, 0.014, -0.001}, {0.032, 0.033, 0.021});
  const double tip = ellipsoid(p, {0.046, 0.019, -0.006}, {0.027, 0.021, 0.012});
  const double lobes = smooth_min(smooth_min(dome, lower, 0.020), smooth_min(middle, tip, 0.020), 0.012);
  // The organs below press a hollow into it.
  const double hollow = ellipsoid(p, {0.008, -0.022, -0.062}, {0.072, 0.062, 0.047});
  // A ligament runs in the notch between the lobes.
  const double notch = ellipsoid(p, {0.010, -0.038, 0.004}, {0.007, 0.026, 0.050});
  const double body = smooth_max(smooth_max(lobes, -hollow, 0.012), -notch, 0.010);
  const double gallbladder = ellipsoid(p, {-0.014, -0.036, -0.015}, {0.0085, 0.018, 0.0085});
  return smooth_min(body, gallbladder, 0.007);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) throw InputError("usage: make_liver OUTPUT.off");
  // Facets with circumscribed circles of at most 2 mm, within 0.1 mm of the surface.
  const TriangleMesh mesh =
      mesh_implicit(liver, {.within = 0.12, .facets = 0.002, .surface = 0.0001}, face_count, "liver");
  write_off(argv[1], mesh, "an organ of two lobes; metres");
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "make_liver: %s\n", e.what());
  return 1;
}
