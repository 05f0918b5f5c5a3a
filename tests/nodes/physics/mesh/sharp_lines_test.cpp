// Sharp edges of a surface become lines from corner to corner; roughness becomes none.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <boost/test/unit_test.hpp>

#include "nodes/physics/mesh/sharp_lines.hpp"
#include "tests/support/shapes.hpp"

BOOST_AUTO_TEST_SUITE(sharp_lines_test)

using namespace tactor;

namespace {

constexpr double sharp = std::numbers::pi / 4;

/// A prism on a regular polygon: radius 1, from z = 0 to 1.
TriangleMesh prism(int corners) {
  TriangleMesh mesh;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    mesh.vertices.push_back({std::cos(angle), std::sin(angle), 0});
    mesh.vertices.push_back({std::cos(angle), std::sin(angle), 1});
  }
  for (int i = 0; i < corners; ++i) {
    const int j = (i + 1) % corners;
    mesh.faces.push_back({2 * i, 2 * j, 2 * j + 1});
    mesh.faces.push_back({2 * i, 2 * j + 1, 2 * i + 1});
    if (i == 0 || j == 0) continue;
    mesh.faces.push_back({0, 2 * j, 2 * i});
    mesh.faces.push_back({1, 2 * i + 1, 2 * j + 1});
  }
  return mesh;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_box_has_twelve_lines) {
  const std::vector<std::vector<int>> lines = sharp_lines(test::box({1, 2, 3}), sharp, 0);
  BOOST_TEST(lines.size() == 12U);
  for (const auto& line : lines) BOOST_TEST(line.size() == 2U);
}

BOOST_AUTO_TEST_CASE(a_cylinder_has_two_rings_and_a_coarse_prism_its_edges) {
  const std::vector<std::vector<int>> rings = sharp_lines(prism(43), sharp, 0);
  BOOST_TEST_REQUIRE(rings.size() == 2U);
  for (const auto& ring : rings) {
    BOOST_TEST(ring.size() == 44U);
    BOOST_TEST(ring.front() == ring.back());
  }
  // Normals of neighbouring sides of a square differ by 90 degrees.
  BOOST_TEST(sharp_lines(prism(4), sharp, 0).size() == 12U);
  // Of a hexagon by 60, and the corners of its rims have three edges.
  BOOST_TEST(sharp_lines(prism(6), sharp, 0).size() == 18U);
}

BOOST_AUTO_TEST_CASE(lines_near_each_other_ask_for_more_nodes) {
  const auto nodes = [](const TriangleMesh& mesh, double longest) {
    return nodes_on_lines(mesh, sharp_lines(mesh, sharp, 0), longest);
  };
  // The edges of a cube are 12 long in all.
  BOOST_TEST(nodes(test::box({1, 1, 1}), 0.1) == 120.0, boost::test_tools::tolerance(1e-9));
  // Of a plate, eight edges have another one 0.01 away, which is no neighbour: half of that is their distance of nodes.
  const double plate = nodes(test::box({1, 1, 0.01}), 0.1);
  BOOST_TEST(plate > 8 / 0.005);
  BOOST_TEST(plate < 8 / 0.005 + 10);
  BOOST_TEST(nodes_on_lines(test::box({1, 1, 1}), {}, 0.1) == 0);
}

BOOST_AUTO_TEST_CASE(smooth_surfaces_and_short_edges_have_none) {
  BOOST_TEST(sharp_lines(test::icosphere(1, 2), sharp, 0).empty());
  // All edges of the box together are 24 long.
  BOOST_TEST(sharp_lines(test::box({1, 2, 3}), sharp, 23.9).size() == 12U);
  BOOST_TEST(sharp_lines(test::box({1, 2, 3}), sharp, 24.1).empty());
}

BOOST_AUTO_TEST_SUITE_END()
