// Samples cover a surface within their spacing, side by side, whatever its triangles are.
#include <boost/test/unit_test.hpp>

#include "framework/core/check.hpp"
#include "nodes/physics/mesh/refine.hpp"
#include "tests/nodes/physics/mesh/covering.hpp"
#include "tests/support/shapes.hpp"

BOOST_AUTO_TEST_SUITE(surface_samples_test)

using namespace tactor;
using test::covering_distance;
using test::total_area;
namespace tt = boost::test_tools;

namespace {

constexpr double pi = std::numbers::pi;

/// A prism of n sides about z; its ends are fans of slivers about one corner.
TriangleMesh sliver_prism(int n, double radius, double height) {
  TriangleMesh mesh;
  for (int i = 0; i < n; ++i) {
    const double turn = 2 * pi * i / n;
    for (const double z : {-height / 2, height / 2}) {
      mesh.vertices.push_back({radius * std::cos(turn), radius * std::sin(turn), z});
    }
  }
  for (int i = 0; i < n; ++i) {
    const int a = 2 * i, b = 2 * ((i + 1) % n);
    mesh.faces.push_back({a, b, b + 1});
    mesh.faces.push_back({a, b + 1, a + 1});
    if (i == 0 || i == n - 1) continue;
    mesh.faces.push_back({0, b, a});
    mesh.faces.push_back({1, a + 1, b + 1});
  }
  return mesh;
}

double longest_edge(const TriangleMesh& mesh) {
  double longest = 0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto [a, b, c] = test::corners(mesh, f);
    longest = std::max({longest, norm(b - a), norm(c - b), norm(a - c)});
  }
  return longest;
}

}  // namespace

BOOST_AUTO_TEST_CASE(vertices_share_the_area_of_their_faces_in_thirds) {
  const TriangleMesh mesh = test::box({0.01, 0.02, 0.1});
  const std::vector<SurfaceSample> samples = vertex_samples(mesh).points;
  BOOST_TEST(samples.size() == 8U);
  BOOST_TEST(total_area(samples) == surface_area(mesh), tt::tolerance(1e-12));
}

BOOST_AUTO_TEST_CASE(a_refined_mesh_is_the_same_closed_surface_with_short_edges) {
  for (const TriangleMesh& mesh :
       {test::box({0.01, 0.02, 0.1}), sliver_prism(50, 0.01, 0.05), test::icosphere(0.04, 2)}) {
    const RefinedMesh refined = refine(mesh, 0.003);
    BOOST_TEST(longest_edge(refined.mesh) <= 0.003);
    BOOST_TEST(surface_area(refined.mesh) == surface_area(mesh), tt::tolerance(1e-10));
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) BOOST_TEST((refined.mesh.vertices[i] == mesh.vertices[i]));
    std::map<std::pair<int, int>, int> edges;
    BOOST_REQUIRE(refined.parent_face.size() == refined.mesh.faces.size());
    for (std::size_t f = 0; f < refined.mesh.faces.size(); ++f) {
      const auto parent = static_cast<std::size_t>(refined.parent_face[f]);
      BOOST_TEST(dot(test::unit_normal(refined.mesh, f), test::unit_normal(mesh, parent)) > 1 - 1e-9);
      for (const Vec3& v : test::corners(refined.mesh, f)) {
        BOOST_TEST(norm(nearest_on(test::corners(mesh, parent), v).p - v) < 1e-12);
      }
      for (std::size_t i = 0; i < 3; ++i) ++edges[{refined.mesh.faces[f][i], refined.mesh.faces[f][(i + 1) % 3]}];
    }
    // Each edge has one face on either side.
    for (const auto& [edge, count] : edges) {
      BOOST_TEST(count == 1);
      BOOST_TEST(edges.count({edge.second, edge.first}) == 1U);
    }
  }
}

BOOST_AUTO_TEST_CASE(every_point_has_a_sample_of_its_sheet_within_the_spacing) {
  const auto check = [](const TriangleMesh& mesh, double spacing) {
    BOOST_TEST_CONTEXT("spacing " << spacing << ", " << mesh.faces.size() << " faces") {
      const std::vector<SurfaceSample> samples = sample_surface(mesh, spacing).points;
      const double covered = covering_distance(mesh, samples, 20'000);
      BOOST_TEST(covered <= spacing);
      BOOST_TEST(total_area(samples) == surface_area(mesh), tt::tolerance(1e-9));
      for (const SurfaceSample& s : samples) {
        BOOST_TEST(s.area > 0);
        // The part of a disk, or of one folded over edges.
        BOOST_TEST(s.area < pi * spacing * spacing);
      }
    }
  };
  for (const double spacing : {0.013, 0.005, 0.002}) check(test::box({0.01, 0.02, 0.1}), spacing);
  for (const double spacing : {0.02, 0.004, 0.002}) check(sliver_prism(50, 0.01, 0.05), spacing);
  for (const double spacing : {0.1, 0.02, 0.006}) check(test::icosphere(0.04, 4), spacing);
  // Both sides of a wall are within the spacing of each other.
  for (const double spacing : {0.01, 0.004}) check(test::box({0.04, 0.04, 0.0005}), spacing);
}

BOOST_AUTO_TEST_CASE(both_sides_of_a_thin_plate_have_samples_of_their_own) {
  const double thickness = 0.0005, side = 0.04, spacing = 0.004;
  const std::vector<SurfaceSample> samples = sample_surface(test::box({side, side, thickness}), spacing).points;
  std::array<int, 2> inside{};
  for (const SurfaceSample& s : samples) {
    if (std::max(std::abs(s.p.x), std::abs(s.p.y)) < side / 2 - 1e-9) ++inside[s.p.z > 0 ? 1 : 0];
  }
  // Disks of the spacing can cover no more than their area.
  const double needed = std::pow(side - 2 * spacing, 2) / (pi * spacing * spacing);
  BOOST_TEST(inside[0] > needed);
  BOOST_TEST(inside[1] > needed);
}

BOOST_AUTO_TEST_CASE(stacked_sheets_that_face_the_same_way_have_samples_of_their_own) {
  // Two plates, 1 mm apart: the tops face the same way and are 1.5 mm apart.
  TriangleMesh mesh = test::box({0.03, 0.03, 0.0005});
  const TriangleMesh upper = test::box({0.03, 0.03, 0.0005}, {0, 0, 0.0015});
  mesh.vertices.insert(mesh.vertices.end(), upper.vertices.begin(), upper.vertices.end());
  for (const auto& f : upper.faces) mesh.faces.push_back({f[0] + 8, f[1] + 8, f[2] + 8});
  const std::vector<SurfaceSample> both = sample_surface(mesh, 0.004).points;
  double lower_area = 0;
  for (const SurfaceSample& s : both) lower_area += s.p.z < 0.0005 ? s.area : 0;
  BOOST_TEST(lower_area == surface_area(upper), tt::tolerance(1e-9));
}

BOOST_AUTO_TEST_CASE(the_number_of_samples_depends_on_the_area_and_not_on_the_triangles) {
  const double spacing = 0.008, area = 4 * pi * 0.04 * 0.04;
  for (const int levels : {3, 4, 5, 6}) {
    const std::vector<SurfaceSample> samples = sample_surface(test::icosphere(0.04, levels), spacing).points;
    // Disks as wide as the least distance between samples do not overlap; 0.907 is how densely they can lie.
    BOOST_TEST(samples.size() * pi * std::pow(0.85 * spacing / 2, 2) < 0.907 * area);
    BOOST_TEST(samples.size() * pi * spacing * spacing > area);
    double nearest = 1;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) nearest = std::min(nearest, norm(samples[i].p - samples[j].p));
    }
    BOOST_TEST(nearest > 0.85 * spacing);
  }
  const TriangleMesh block = test::box({0.03, 0.04, 0.05});
  const auto coarse = static_cast<double>(sample_surface(block, 0.004).points.size());
  for (const double edge : {0.01, 0.002, 0.0005}) {
    const auto fine = static_cast<double>(sample_surface(refine(block, edge).mesh, 0.004).points.size());
    BOOST_TEST(fine == coarse, tt::tolerance(0.1));
  }
}

BOOST_AUTO_TEST_CASE(corners_and_each_sharp_edge_have_samples_of_their_own) {
  // The two edges along each side of the plate are half a millimetre apart.
  const Vec3 size{0.03, 0.04, 0.0005};
  const double spacing = 0.004;
  const std::vector<SurfaceSample> samples = sample_surface(test::box(size), spacing).points;
  for (const Vec3& corner : test::box(size).vertices) {
    BOOST_TEST(std::any_of(samples.begin(), samples.end(), [&](const SurfaceSample& s) { return s.p == corner; }));
  }
  for (const double x : {-size.x / 2, size.x / 2}) {
    for (const double z : {-size.z / 2, size.z / 2}) {
      double farthest = 0;
      for (double y = -size.y / 2; y <= size.y / 2; y += 0.0003) {
        double nearest = 1;
        for (const SurfaceSample& s : samples) {
          if (s.p.x == x && s.p.z == z) nearest = std::min(nearest, std::abs(s.p.y - y));
        }
        farthest = std::max(farthest, nearest);
      }
      BOOST_TEST(farthest <= spacing);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_face_is_represented_without_a_lean) {
  // The first moments of what the samples on the top of a plate stand for.
  const Vec3 size{0.08, 0.06, 0.02};
  for (const double spacing : {0.008, 0.003}) {
    double sum = 0, x = 0, y = 0;
    for (const SurfaceSample& s : sample_surface(test::box(size), spacing).points) {
      if (s.p.z != size.z / 2) continue;
      sum += s.area, x += s.area * s.p.x, y += s.area * s.p.y;
    }
    BOOST_TEST(std::abs(x / sum) < 0.1 * spacing);
    BOOST_TEST(std::abs(y / sum) < 0.1 * spacing);
  }
}

BOOST_AUTO_TEST_CASE(a_face_without_area_changes_nothing_but_the_points_on_it) {
  // As files may hold them where nothing repairs a mesh: the third corner lies on the edge of the other two.
  TriangleMesh mesh = test::box({0.02, 0.02, 0.02});
  const Vec3 a = mesh.vertices[static_cast<std::size_t>(mesh.faces[0][0])],
             b = mesh.vertices[static_cast<std::size_t>(mesh.faces[0][1])];
  mesh.vertices.push_back(0.5 * (a + b));
  mesh.faces.push_back({mesh.faces[0][0], mesh.faces[0][1], static_cast<int>(mesh.vertices.size()) - 1});
  double area = 0;
  for (const SurfaceSample& s : sample_surface(mesh, 0.004).points) {
    BOOST_TEST(std::isfinite(s.area));
    area += s.area;
  }
  BOOST_TEST(area == 6 * 0.02 * 0.02, tt::tolerance(1e-9));
}

BOOST_AUTO_TEST_CASE(the_same_mesh_has_the_same_samples) {
  const TriangleMesh mesh = sliver_prism(50, 0.01, 0.05);
  const std::vector<SurfaceSample> a = sample_surface(mesh, 0.003).points, b = sample_surface(mesh, 0.003).points;
  BOOST_REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) BOOST_TEST((a[i].p == b[i].p && a[i].area == b[i].area));
}

BOOST_AUTO_TEST_CASE(a_spacing_that_is_too_small_is_refused_in_its_own_words) {
  BOOST_CHECK_EXCEPTION(sample_surface(test::box({1, 1, 1}), 1e-4), InputError, [](const InputError& error) {
    return std::string(error.what())
        .starts_with("a spacing of 0.100000 mm is too small: edges no longer than 0.025000 mm");
  });
}

BOOST_AUTO_TEST_SUITE_END()
