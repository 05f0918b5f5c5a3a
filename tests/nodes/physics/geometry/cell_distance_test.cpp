// The signed distance by cells against the exact one, a brute-force search, and closed forms.
#include <boost/test/unit_test.hpp>

#include <cmath>
#include <limits>

#include "nodes/physics/cgal/exact_distance.hpp"
#include "nodes/physics/geometry/cell_distance.hpp"
#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/mesh/solid_file.hpp"
#include "tests/support/brute_distance.hpp"
#include "tests/support/dice.hpp"
#include "tests/support/shapes.hpp"

BOOST_AUTO_TEST_SUITE(cell_distance_test)

using namespace tactor;

namespace {

TriangleMesh built_mesh(const char* name) {
  return load_solid(std::string(TACTOR_BINARY_DIR) + "/meshes/" + name).mesh;
}

TriangleMesh joined(TriangleMesh a, const TriangleMesh& b) {
  const int first = static_cast<int>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& f : b.faces) a.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
  return a;
}

/// Four long thin faces: 0.1 m by 2 um.
TriangleMesh needle() {
  return {{{0, 0, 0}, {2e-6, 0, 0}, {0, 2e-6, 0}, {0, 0, 0.1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

/// Two flat tetrahedra: the widest angles of their large faces are near 180 degrees.
TriangleMesh flat_faces() {
  return {{{0, 0, 0}, {0.1, 0, 0}, {0.05, 1e-4, 0}, {0.05, 5e-5, 1e-3}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
}

struct Solid {
  const char* name;
  TriangleMesh mesh;
  CellOptions options;
};

std::vector<Solid> solids() {
  return {
      {"cube", test::box({0.1, 0.1, 0.1}), {.resolution = 16, .band = 0.01}},
      {"needle", needle(), {.resolution = 64, .band = 0.003}},
      {"flat faces", flat_faces(), {.resolution = 32, .band = 0.004}},
      // Two boxes 10 um apart, so that cells hold faces of both.
      {"pair", joined(test::box({0.1, 0.05, 0.02}), test::box({0.1, 0.05, 0.02}, {0, 0, 0.02001})), {.resolution = 24}},
      {"ball", test::icosphere(0.05, 3), {.resolution = 40}},
      {"peg", built_mesh("peg.off"), {.resolution = 48}},
      {"plate", built_mesh("plate.off"), {.resolution = 64}},
      {"duck", built_mesh("duck.off"), {.resolution = 64}},
      {"bunny", built_mesh("bunny.off"), {.resolution = 64}}};
}

/// Points near and far, inside and outside, on corners, on edges, on faces, and at the corners of the box.
std::vector<Vec3> points_about(const TriangleMesh& mesh, int count) {
  test::Dice dice(11);
  const Bounds bounds = bounds_of(mesh);
  const Vec3 low = bounds.low, high = bounds.high;
  const double size = norm(bounds.size());
  std::vector<Vec3> points;
  for (int i = 0; i < 8; ++i) {
    points.push_back({(i & 1) != 0 ? low.x : high.x, (i & 2) != 0 ? low.y : high.y, (i & 4) != 0 ? low.z : high.z});
  }
  for (int i = 0; i < count; ++i) {
    const auto& f = mesh.faces[static_cast<std::size_t>(dice(0, static_cast<double>(mesh.faces.size())))];
    const Vec3 &a = mesh.vertices[static_cast<std::size_t>(f[0])], &b = mesh.vertices[static_cast<std::size_t>(f[1])],
               &c = mesh.vertices[static_cast<std::size_t>(f[2])];
    const double t = dice(0, 1), s = dice(0, 1 - t);
    for (const Vec3& on : {a, a + t * (b - a), a + t * (b - a) + s * (c - a)}) {
      points.push_back(on);
      points.push_back(on + dice.in_cube(1e-5));
      points.push_back(on + dice.in_cube(0.002));
    }
    points.push_back(0.5 * (low + high) + dice.in_cube(0.6 * size));
    points.push_back(10 * dice.in_cube(size));
  }
  return points;
}

}  // namespace

BOOST_AUTO_TEST_CASE(cells_and_the_exact_search_agree_to_the_bit) {
  for (const Solid& solid : solids()) {
    BOOST_TEST_CONTEXT(solid.name) {
      const CellDistance cells(solid.mesh, solid.options);
      const ExactDistance exact(solid.mesh);
      int different = 0, hinted = 0;
      test::Dice dice(11);
      for (const Vec3& x : points_about(solid.mesh, 300)) {
        const Nearest by_cells = cells.nearest(x);
        different += by_cells == exact.nearest(x) ? 0 : 1;
        const int hint = static_cast<int>(dice(0, static_cast<double>(solid.mesh.faces.size())));
        hinted += by_cells == cells.nearest(x, hint) && by_cells == exact.nearest(x, hint) ? 0 : 1;
      }
      BOOST_TEST(different == 0);
      BOOST_TEST(hinted == 0);
    }
  }
}

BOOST_AUTO_TEST_CASE(cells_and_the_exact_search_agree_on_the_smallest_and_the_largest_bodies) {
  for (const double length : {1e-6, 1e3}) {
    TriangleMesh ball = test::icosphere(0.5, 3);
    for (Vec3& v : ball.vertices) v *= length;
    const CellDistance cells(ball, {.resolution = 24, .band = length / 8});
    const ExactDistance exact(ball);
    int different = 0;
    test::Dice dice(11);
    for (int i = 0; i < 1000; ++i) {
      const Vec3 x = length * dice.in_cube(1);
      different += cells.nearest(x) == exact.nearest(x) ? 0 : 1;
    }
    BOOST_TEST(different == 0, "length " << length);
  }
}

BOOST_AUTO_TEST_CASE(cells_find_the_distance_that_a_look_at_every_face_finds) {
  for (const Solid& solid : solids()) {
    BOOST_TEST_CONTEXT(solid.name) {
      const CellDistance cells(solid.mesh, solid.options);
      double worst = 0;
      for (const Vec3& x : points_about(solid.mesh, solid.mesh.faces.size() > 1000 ? 8 : 100)) {
        worst = std::max(worst, std::abs(std::abs(cells.nearest(x).distance) - test::unsigned_distance(solid.mesh, x)));
      }
      BOOST_TEST(worst < 1e-12);
    }
  }
}

BOOST_AUTO_TEST_CASE(most_cells_of_the_band_have_lists_and_points_in_them_need_no_tree) {
  for (const Solid& solid : solids()) {
    BOOST_TEST_CONTEXT(solid.name) {
      const CellData data = build_cells(solid.mesh, solid.options);
      int in_band = 0, listed = 0;
      for (const Cell& cell : data.cells) {
        if (std::abs(cell.distance) > solid.options.band) continue;
        ++in_band;
        listed += (cell.list & 15) != 0 ? 1 : 0;
      }
      BOOST_TEST(in_band > 100);
      BOOST_TEST(listed > 0.95 * in_band);
    }
  }
}

BOOST_AUTO_TEST_CASE(lower_bounds_are_below_the_distance_and_close_to_it_near_the_surface) {
  for (const Solid& solid : solids()) {
    BOOST_TEST_CONTEXT(solid.name) {
      const CellDistance cells(solid.mesh, solid.options);
      const ExactDistance exact(solid.mesh);
      const double edge = cells.data().edge;
      int above = 0, loose = 0;
      const std::vector<Vec3> points = points_about(solid.mesh, 100);
      for (std::size_t i = 0; i + 8 <= points.size(); i += 8) {
        Points8 x;
        for (std::size_t k = 0; k < 8; ++k) {
          x.x[k] = static_cast<float>(points[i + k].x);
          x.y[k] = static_cast<float>(points[i + k].y);
          x.z[k] = static_cast<float>(points[i + k].z);
        }
        std::array<float, 8> by_cells{}, by_search{};
        cells.lower_bounds(x, 0xff, by_cells);
        exact.lower_bounds(x, 0xff, by_search);
        for (std::size_t k = 0; k < 8; ++k) {
          const double distance = exact.nearest({x.x[k], x.y[k], x.z[k]}).distance;
          above += by_cells[k] > distance || by_search[k] > distance ? 1 : 0;
          // Twice half the diagonal of a cell.
          if (std::abs(distance) < solid.options.band) loose += by_cells[k] < distance - 1.8 * edge ? 1 : 0;
        }
      }
      BOOST_TEST(above == 0);
      BOOST_TEST(loose == 0);
    }
  }
}

BOOST_AUTO_TEST_CASE(far_away_the_bound_follows_the_box) {
  const CellDistance cells(test::box({0.1, 0.1, 0.1}));
  Points8 x{};
  x.x.fill(2.0F);
  std::array<float, 8> bound{};
  cells.lower_bounds(x, 0xff, bound);
  for (const float b : bound) BOOST_TEST(std::abs(b - 1.95) < 1e-3);
}

BOOST_AUTO_TEST_CASE(however_far_a_point_is_it_gets_the_nearest_face) {
  for (const Solid& solid : solids()) {
    BOOST_TEST_CONTEXT(solid.name) {
      const CellDistance cells(solid.mesh, solid.options);
      const Surface& surface = cells.data().surface;
      test::Dice dice(11);
      int different = 0, above = 0;
      // The squares of the last ones are beyond floats, and the last one itself.
      for (const double far : {1e3, 1e6, 1e12, 1e17, 1e18, 3e18, 1e19, 1e25, 1e39, 1e100}) {
        for (int i = 0; i < 8; ++i) {
          const Vec3 way = dice.in_cube(1), x = far / norm(way) * way;
          NearestFace nearest = surface.candidate(0, x);
          for (int face = 1; face < surface.size(); ++face) surface.compare(face, x, nearest);
          const Nearest known = surface.signed_distance(nearest, x);
          different += cells.nearest(x) == known && cells.nearest(x, surface.size() - 1) == known ? 0 : 1;
          Points8 points{};
          points.x.fill(static_cast<float>(x.x));
          points.y.fill(static_cast<float>(x.y));
          points.z.fill(static_cast<float>(x.z));
          std::array<float, 8> bound{};
          cells.lower_bounds(points, 0xff, bound);
          // Of the point as floats have it; where they cannot square it, it may count as infinitely far.
          const double distance = cells.nearest({points.x[0], points.y[0], points.z[0]}).distance;
          // Of that far a point rounding decides which faces are nearest, and thereby the sign.
          for (const float b : bound) above += b <= std::abs(distance) || far >= 1e19 ? 0 : 1;
        }
      }
      BOOST_TEST(different == 0);
      BOOST_TEST(above == 0);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_point_that_is_no_point_gets_a_face_that_is_there_and_no_distance) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  for (const Solid& solid : solids()) {
    BOOST_TEST_CONTEXT(solid.name) {
      const CellDistance cells(solid.mesh, solid.options);
      const auto faces = static_cast<int>(solid.mesh.faces.size());
      for (const Vec3& x : {Vec3{nan, 0, 0}, Vec3{0, nan, nan}, Vec3{infinity, 0, 0}, Vec3{0, -infinity, 0},
                            Vec3{infinity, -infinity, infinity}, Vec3{infinity, nan, 0}, Vec3{1e200, 1e200, 0}}) {
        for (const int hint : {-1, 0, faces - 1}) {
          const Nearest nearest = cells.nearest(x, hint);
          BOOST_TEST((nearest.face >= 0 && nearest.face < faces));
          BOOST_TEST(!std::isfinite(nearest.distance));
        }
        Points8 points{};
        points.x.fill(static_cast<float>(x.x));
        points.y.fill(static_cast<float>(x.y));
        points.z.fill(static_cast<float>(x.z));
        std::array<float, 8> bound{};
        cells.lower_bounds(points, 0xff, bound);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(the_hessian_is_how_the_gradient_turns) {
  for (const Solid& solid : solids()) {
    BOOST_TEST_CONTEXT(solid.name) {
      const CellDistance cells(solid.mesh, solid.options);
      int faces = 0, edges = 0, corners = 0;
      double worst = 0;
      for (const Vec3& x : points_about(solid.mesh, 60)) {
        const Nearest here = cells.nearest(x);
        if (std::abs(here.distance) < 1e-4) continue;
        const Eigen::Matrix3d H = cells.hessian(here, x);
        Eigen::Matrix3d differences;
        bool same = true;
        const double h = 1e-4 * std::abs(here.distance);
        for (int axis = 0; axis < 3; ++axis) {
          Vec3 step;
          step[axis] = h;
          const Nearest ahead = cells.nearest(x + step), behind = cells.nearest(x - step);
          for (const Nearest& n : {ahead, behind}) {
            same &= n.face == here.face && n.feature == here.feature && n.of_face == here.of_face;
          }
          const Vec3 column = (ahead.gradient - behind.gradient) / (2 * h);
          differences.col(axis) << column.x, column.y, column.z;
        }
        // Where a step changes the feature, the distance has no second derivative.
        if (!same) continue;
        worst = std::max(worst, (H - differences).cwiseAbs().maxCoeff() * std::abs(here.distance));
        faces += here.feature == Feature::face ? 1 : 0;
        edges += here.feature == Feature::edge ? 1 : 0;
        corners += here.feature == Feature::corner ? 1 : 0;
      }
      BOOST_TEST(worst < 1e-5);
      BOOST_TEST(edges > 3);
      BOOST_TEST(corners + faces > 3);
    }
  }
  const CellDistance cube(test::box({0.1, 0.1, 0.1}));
  const Vec3 corner{0.05, 0.05, 0.05};
  BOOST_TEST(cube.hessian(cube.nearest(corner), corner).isZero(0));
}

BOOST_AUTO_TEST_SUITE_END()
