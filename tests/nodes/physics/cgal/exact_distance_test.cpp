// Signed distance by search against closed forms and a brute-force search.
#include <boost/test/unit_test.hpp>

#include "nodes/physics/cgal/exact_distance.hpp"
#include "tests/support/brute_distance.hpp"
#include "tests/support/dice.hpp"
#include "tests/support/shapes.hpp"

BOOST_AUTO_TEST_SUITE(exact_distance_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

/// Signed distance to a centred box, by cases.
double box_distance(const Vec3& edges, const Vec3& x) {
  Vec3 out;
  double inside = -1e9;
  for (int i = 0; i < 3; ++i) {
    const double d = std::abs(x[i]) - edges[i] / 2;
    out[i] = std::max(d, 0.0);
    inside = std::max(inside, d);
  }
  return inside > 0 ? norm(out) : inside;
}

/// The solid angle of the mesh at x over 4 pi: 1 inside, 0 outside (A. van Oosterom and J. Strackee, 1983).
double winding(const TriangleMesh& mesh, const Vec3& x) {
  double sum = 0;
  for (const auto& f : mesh.faces) {
    const Vec3 a = mesh.vertices[static_cast<std::size_t>(f[0])] - x,
               b = mesh.vertices[static_cast<std::size_t>(f[1])] - x,
               c = mesh.vertices[static_cast<std::size_t>(f[2])] - x;
    const double la = norm(a), lb = norm(b), lc = norm(c);
    sum += 2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return sum / (4 * std::numbers::pi);
}

/// An icosphere with spikes and dents: sharp convex and concave features.
TriangleMesh spiky(int levels) {
  TriangleMesh mesh = test::icosphere(0.05, levels);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) mesh.vertices[i] *= i % 3 == 0 ? 1.5 : i % 3 == 1 ? 0.7 : 1.0;
  return mesh;
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_distance_to_a_box_is_the_closed_form) {
  const Vec3 edges{0.1, 0.2, 0.3};
  const ExactDistance distance(test::box(edges));
  test::Dice dice(7);
  int hint = -1;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 x = dice.in_cube(0.25);
    const Nearest n = distance.nearest(x, hint);
    BOOST_TEST(std::abs(n.distance - box_distance(edges, x)) < 1e-12);
    BOOST_TEST(norm(n.p + n.distance * n.gradient - x) < 1e-12);
    hint = n.face;
  }
}

BOOST_AUTO_TEST_CASE(the_sign_is_right_beside_sharp_edges_and_vertices) {
  // Few faces are scanned, many are searched by the tree.
  for (const int levels : {2, 3}) {
    const TriangleMesh mesh = spiky(levels);
    const ExactDistance distance(mesh);
    test::Dice dice(7);
    for (int i = 0; i < 1000; ++i) {
      const Vec3 x = dice.in_cube(0.08);
      const Nearest n = distance.nearest(x, static_cast<int>(dice(0, 300)));
      BOOST_TEST(std::abs(n.distance) == test::unsigned_distance(mesh, x), tt::tolerance(1e-9));
      BOOST_TEST((n.distance < 0) == (winding(mesh, x) > 0.5));
      const double h = 1e-7;
      BOOST_TEST(distance.nearest(x + h * n.gradient, n.face).distance > n.distance);
    }
  }
}

BOOST_AUTO_TEST_CASE(on_the_surface_the_gradient_is_the_outward_normal) {
  const ExactDistance distance(test::box({0.1, 0.1, 0.1}));
  const Nearest face = distance.nearest({0.05, 0.01, 0.02});
  BOOST_TEST(std::abs(face.distance) < 1e-15);
  BOOST_TEST(norm(face.gradient - Vec3{1, 0, 0}) < 1e-12);
  const Nearest corner = distance.nearest({0.05, 0.05, 0.05});
  BOOST_TEST(corner.gradient.x > 0.5);
  BOOST_TEST(corner.gradient.x == corner.gradient.y, tt::tolerance(1e-9));
}

BOOST_AUTO_TEST_SUITE_END()
