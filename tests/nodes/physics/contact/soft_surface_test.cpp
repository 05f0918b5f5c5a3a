// The tree of a surface that deforms: what it finds is what a look at all faces finds.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include "nodes/physics/geometry/tree_distance.hpp"
#include "tests/nodes/physics/contact/soft_scenes.hpp"

BOOST_AUTO_TEST_SUITE(soft_surface_test)

using namespace tactor;
using namespace tactor::test;

namespace {

/// m^2, of x to a triangle, by the plane and the three segments.
double plain_squared(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& x) {
  const auto to_segment = [&](const Vec3& p, const Vec3& q) {
    const Vec3 e = q - p;
    const double ee = dot(e, e), t = ee > 0 ? std::clamp(dot(x - p, e) / ee, 0.0, 1.0) : 0.0;
    const Vec3 d = x - (p + t * e);
    return dot(d, d);
  };
  double least = std::min({to_segment(a, b), to_segment(b, c), to_segment(c, a)});
  const Vec3 n = cross(b - a, c - a);
  const double nn = dot(n, n);
  if (nn > 1e-30) {
    const bool above =
        dot(cross(b - a, x - a), n) >= 0 && dot(cross(c - b, x - b), n) >= 0 && dot(cross(a - c, x - c), n) >= 0;
    if (above) least = std::min(least, dot(x - a, n) * dot(x - a, n) / nn);
  }
  return least;
}

std::vector<Vec3> deformed(const std::vector<Vec3>& nodes, double by, Dice& dice) {
  const Vec3 f = dice.in_cube(100), g = dice.in_cube(100);
  std::vector<Vec3> moved;
  for (const Vec3& p : nodes) {
    moved.push_back(p + by * Vec3{std::sin(dot(f, p)), std::cos(dot(g, p)), std::sin(dot(f, p) + 1)} +
                    dice.in_cube(0.05 * by));
  }
  return moved;
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_nearest_point_of_a_face_is_that_of_its_plane_and_edges) {
  Dice dice(1);
  for (int i = 0; i < 20000; ++i) {
    const Vec3 a = dice.in_cube(1), x = dice.in_cube(2);
    Vec3 b = dice.in_cube(1), c = dice.in_cube(1);
    // Some that are flat to a line or to a point.
    if (i % 10 == 1) c = a + 0.3 * (b - a);
    if (i % 10 == 2) c = a;
    if (i % 10 == 3) b = c = a;
    if (i % 10 == 4) c = a + 0.3 * (b - a) + dice.in_cube(1e-9);
    const OnFace on = nearest_on_face(a, b, c, x);
    BOOST_TEST(std::abs(std::sqrt(on.squared) - std::sqrt(plain_squared(a, b, c, x))) < 2e-8);
    BOOST_TEST(std::abs(on.share[0] + on.share[1] + on.share[2] - 1) < 1e-12);
    BOOST_TEST(std::min({on.share[0], on.share[1], on.share[2]}) > -1e-12);
    BOOST_TEST(norm(on.share[0] * a + on.share[1] * b + on.share[2] * c - on.p) < 1e-12);
  }
}

BOOST_AUTO_TEST_CASE(the_tree_finds_the_faces_and_the_nearest_of_a_mesh_as_it_deforms) {
  Dice dice(2);
  for (const TriangleMesh& mesh : {icosphere(0.03, 3), flat_grid(0.06, 13), box({0.05, 0.03, 0.04})}) {
    const SoftMesh soft = soft_mesh(mesh);
    MovingSurface surface;
    surface.set(soft.surface.faces, soft.nodes);
    std::vector<std::int32_t> found;
    for (int round = 1; round < 12; ++round) {
      const std::vector<Vec3> nodes = deformed(soft.nodes, 0.002 * round, dice);
      surface.move(nodes);
      const auto corners = [&](std::size_t k) {
        return std::array{nodes[static_cast<std::size_t>(soft.surface.faces[k][0])],
                          nodes[static_cast<std::size_t>(soft.surface.faces[k][1])],
                          nodes[static_cast<std::size_t>(soft.surface.faces[k][2])]};
      };
      for (int i = 0; i < 40; ++i) {
        const Vec3 x = dice.in_cube(0.06);
        double least = 1;
        for (std::size_t k = 0; k < soft.surface.faces.size(); ++k) {
          const auto [a, b, c] = corners(k);
          least = std::min(least, plain_squared(a, b, c, x));
        }
        const SurfacePoint near = surface.nearest(x);
        BOOST_TEST(std::abs(std::abs(near.distance) - std::sqrt(least)) < 1e-12);
        const auto [a, b, c] = corners(static_cast<std::size_t>(near.face));
        BOOST_TEST(std::abs(std::sqrt(plain_squared(a, b, c, x)) - std::sqrt(least)) < 1e-12);
        // A hint changes nothing.
        const SurfacePoint hinted = surface.nearest(x, static_cast<std::int32_t>(dice(0, 11)));
        BOOST_TEST((hinted.face == near.face && hinted.p == near.p && hinted.distance == near.distance));

        Bounds part;
        part.add(x);
        part.add(x + dice.in_cube(0.02));
        surface.faces_in(part, found);
        std::vector<std::int32_t> wanted;
        for (std::size_t k = 0; k < soft.surface.faces.size(); ++k) {
          Bounds of_face;
          for (const Vec3& p : corners(k)) of_face.add(p);
          if (boxes_meet(of_face, part)) wanted.push_back(static_cast<std::int32_t>(k));
        }
        BOOST_TEST(found == wanted);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(the_signed_distance_is_that_of_a_solid_of_the_same_shape) {
  // A sphere with bumps that neither cuts itself nor folds.
  TriangleMesh mesh = icosphere(0.03, 3);
  const SoftMesh soft = soft_mesh(mesh);
  MovingSurface surface;
  surface.set(soft.surface.faces, soft.nodes);
  for (Vec3& p : mesh.vertices) p = (1 + 0.2 * std::sin(150 * p.x) * std::cos(120 * p.y)) * p;
  surface.move(mesh.vertices);
  const TreeDistance solid(mesh);
  Dice dice(5);
  int inside = 0;
  for (int i = 0; i < 5000; ++i) {
    const Vec3 x = dice.in_cube(0.04);
    const Nearest expected = solid.nearest(x);
    const SurfacePoint near = surface.nearest(x);
    BOOST_TEST(near.judged);
    BOOST_TEST(std::abs(near.distance - expected.distance) < 1e-12);
    BOOST_TEST(norm(near.p - expected.p) < 1e-9);
    BOOST_TEST(norm(near.n - expected.gradient) < 1e-6);
    inside += near.distance < 0 ? 1 : 0;
  }
  BOOST_TEST(inside > 500);
}

BOOST_AUTO_TEST_CASE(at_the_rim_of_an_open_surface_nothing_is_judged) {
  const SoftMesh soft = soft_mesh(flat_grid(0.04, 4));
  MovingSurface surface;
  surface.set(soft.surface.faces, soft.nodes);
  for (const double z : {-0.003, 0.003}) {
    BOOST_TEST(!surface.nearest({0.021, 0.003, z}).judged);
    BOOST_TEST(!surface.nearest({0.03, -0.03, z}).judged);
    const SurfacePoint near = surface.nearest({0.004, 0.003, z});
    BOOST_TEST(near.judged);
    BOOST_TEST(near.distance == z, boost::test_tools::tolerance(1e-12));
    BOOST_TEST(norm(near.n - Vec3{0, 0, 1}) < 1e-12);
  }
}

BOOST_AUTO_TEST_CASE(faces_with_coordinates_that_are_no_numbers_are_never_found) {
  const double none = std::numeric_limits<double>::quiet_NaN(), endless = std::numeric_limits<double>::infinity();
  SoftMesh soft = soft_mesh(flat_grid(0.04, 6));
  MovingSurface surface;
  surface.set(soft.surface.faces, soft.nodes);
  Dice dice(6);
  std::vector<std::int32_t> found;
  for (int round = 0; round < 50; ++round) {
    std::vector<Vec3> nodes = soft.nodes;
    for (int i = 0; i < 5 * round; ++i) {
      const auto k = static_cast<std::size_t>(dice(0, static_cast<double>(nodes.size())));
      nodes[k][i % 3] = i % 2 == 0 ? none : endless;
    }
    surface.move(nodes);
    const auto is_whole = [&](std::int32_t face) {
      return is_finite(surface.corner(face, 0)) && is_finite(surface.corner(face, 1)) &&
             is_finite(surface.corner(face, 2));
    };
    surface.faces_in(surface.box(), found);
    for (const std::int32_t face : found) BOOST_TEST(is_whole(face));
    for (int i = 0; i < 20; ++i) {
      const SurfacePoint near = surface.nearest(dice.in_cube(0.04));
      if (near.face >= 0) BOOST_TEST((is_whole(near.face) && std::isfinite(near.distance) && is_finite(near.n)));
    }
    BOOST_TEST(!surface.nearest({none, 0, 0}).judged);
    BOOST_TEST(!surface.nearest({endless, 0, 0}).judged);
  }
}

BOOST_AUTO_TEST_SUITE_END()
