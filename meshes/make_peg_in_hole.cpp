// Makes peg.off and plate.off: a cylinder of 43 sides and a square plate with a hole of 43 sides, 356 triangles in all.
#include <cmath>
#include <cstdio>
#include <numbers>

#include "framework/core/check.hpp"
#include "meshes/write_off.hpp"

using namespace tactor;

namespace {

constexpr int sides = 43;
constexpr double peg_radius = 0.0100, peg_length = 0.050;                             // m
constexpr double hole_radius = 0.0105, plate_width = 0.080, plate_thickness = 0.020;  // m

Vec3 on_circle(double radius, int i, double z) {
  const double angle = 2 * std::numbers::pi * i / sides;
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

/// Corners 0 to 42 at the bottom and 43 to 85 at the top of a polygonal wall about z.
void add_rings(TriangleMesh& mesh, double radius, double length) {
  for (const double z : {-length / 2, length / 2}) {
    for (int i = 0; i < sides; ++i) mesh.vertices.push_back(on_circle(radius, i, z));
  }
}

/// The wall between the rings, facing away from the axis, or towards it.
void add_wall(TriangleMesh& mesh, bool outwards) {
  for (int i = 0; i < sides; ++i) {
    const int a = i, b = (i + 1) % sides;
    if (outwards) {
      mesh.faces.push_back({a, b, b + sides});
      mesh.faces.push_back({a, b + sides, a + sides});
    } else {
      mesh.faces.push_back({b, a, a + sides});
      mesh.faces.push_back({b, a + sides, b + sides});
    }
  }
}

TriangleMesh peg() {
  TriangleMesh mesh;
  add_rings(mesh, peg_radius, peg_length);
  add_wall(mesh, true);
  for (int i = 1; i + 1 < sides; ++i) {
    mesh.faces.push_back({0, i + 1, i});
    mesh.faces.push_back({sides, sides + i, sides + i + 1});
  }
  return mesh;
}

/// The face of the plate between hole and rim at the top; the bottom is its mirror image. Every side of the hole sees
/// the corner of the square it is nearest to in angle, and where that changes a triangle bridges to the next corner.
void add_frame(TriangleMesh& mesh, bool top) {
  const auto hole = [&](int i) { return i % sides + (top ? sides : 0); };
  const auto corner = [&](int k) { return 2 * sides + k % 4 + (top ? 4 : 0); };
  const auto add = [&](int a, int b, int c) {
    if (top) {
      mesh.faces.push_back({a, b, c});
    } else {
      mesh.faces.push_back({b, a, c});
    }
  };
  // Corner k stands at (45 + 90 k) degrees and sees the sides whose middle lies within 45 degrees of it.
  const auto seen = [](int i) { return (4 * (2 * i + 1)) / (2 * sides); };
  for (int i = 0; i < sides; ++i) {
    add(hole(i + 1), hole(i), corner(seen(i)));
    const int next = i + 1 < sides ? seen(i + 1) : 4;
    if (next != seen(i)) add(hole(i + 1), corner(seen(i)), corner(next));
  }
}

TriangleMesh plate() {
  TriangleMesh mesh;
  add_rings(mesh, hole_radius, plate_thickness);
  for (const double z : {-plate_thickness / 2, plate_thickness / 2}) {
    const double w = plate_width / 2;
    for (const Vec3& v : {Vec3{w, w, z}, Vec3{-w, w, z}, Vec3{-w, -w, z}, Vec3{w, -w, z}}) mesh.vertices.push_back(v);
  }
  add_wall(mesh, false);
  add_frame(mesh, true);
  add_frame(mesh, false);
  for (int k = 0; k < 4; ++k) {
    const int a = 2 * sides + k, b = 2 * sides + (k + 1) % 4;
    mesh.faces.push_back({a, b, b + 4});
    mesh.faces.push_back({a, b + 4, a + 4});
  }
  return mesh;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) throw InputError("usage: make_peg_in_hole PEG.off PLATE.off");
  write_off(argv[1], peg(), "cylinder of 43 sides, diameter 20 mm, length 50 mm, axis z; metres");
  write_off(argv[2], plate(), "plate 80 x 80 x 20 mm with a hole of 43 sides, diameter 21 mm, axis z; metres");
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "make_peg_in_hole: %s\n", e.what());
  return 1;
}
