// Makes duck.off: a smooth union of ellipsoids shaped like a bath duck, meshed and brought to an exact face count.
#include <cstdio>

#include "framework/core/check.hpp"
#include "meshes/implicit_surface.hpp"
#include "meshes/write_off.hpp"

using namespace tactor;

namespace {

constexpr std::size_t face_count = 13926;

/// Negative inside. The duck looks along x and stands along z; lengths in m.
double duck(const Vec3& p) {
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
  // Facets with circumscribed circles of at most 0.9 mm, within 0.05 mm of the surface.
  const TriangleMesh mesh =
      mesh_implicit(duck, {.within = 0.1, .facets = 0.0009, .surface = 0.00005}, face_count, "duck");
  write_off(argv[1], mesh, "a duck of smoothly joined ellipsoids; metres");
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "make_duck: %s\n", e.what());
  return 1;
}
