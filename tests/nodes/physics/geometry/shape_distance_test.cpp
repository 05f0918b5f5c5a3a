// The closed-form distances of shapes agree with dense samples of their surfaces and with differences of themselves.
#include <boost/test/unit_test.hpp>

#include <numbers>
#include <string>

#include "framework/core/check.hpp"
#include "nodes/physics/geometry/shape_distance.hpp"
#include "tests/support/dice.hpp"

BOOST_AUTO_TEST_SUITE(shape_distance_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

const SphereShape sphere{0.02};
const CapsuleShape capsule{.radius = 0.01, .length = 0.03};
const BoxShape box{{0.02, 0.03, 0.05}};
const double spacing = 0.0004;

std::vector<Vec3> sphere_points(double radius) {
  std::vector<Vec3> points;
  const double step = spacing / radius;
  for (double polar = 0; polar <= std::numbers::pi; polar += step) {
    const double ring = std::max(step, step / std::max(std::sin(polar), 1e-9));
    for (double turn = 0; turn < 2 * std::numbers::pi; turn += ring) {
      points.push_back({radius * std::sin(polar) * std::cos(turn), radius * std::sin(polar) * std::sin(turn),
                        radius * std::cos(polar)});
    }
  }
  return points;
}

std::vector<Vec3> capsule_points() {
  std::vector<Vec3> points;
  const double half = capsule.length / 2;
  for (Vec3 p : sphere_points(capsule.radius)) {
    p.z += p.z >= 0 ? half : -half;
    points.push_back(p);
  }
  for (double z = -half; z <= half; z += spacing) {
    for (double turn = 0; turn < 2 * std::numbers::pi; turn += spacing / capsule.radius) {
      points.push_back({capsule.radius * std::cos(turn), capsule.radius * std::sin(turn), z});
    }
  }
  return points;
}

std::vector<Vec3> box_points() {
  std::vector<Vec3> points;
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const int nu = static_cast<int>(std::ceil(box.size[u] / spacing));
    const int nv = static_cast<int>(std::ceil(box.size[v] / spacing));
    for (int i = 0; i <= nu; ++i) {
      for (int j = 0; j <= nv; ++j) {
        for (const double side : {-0.5, 0.5}) {
          Vec3 p;
          p[axis] = side * box.size[axis];
          p[u] = (static_cast<double>(i) / nu - 0.5) * box.size[u];
          p[v] = (static_cast<double>(j) / nv - 0.5) * box.size[v];
          points.push_back(p);
        }
      }
    }
  }
  return points;
}

struct Case {
  std::string name;
  Shape shape;
  std::vector<Vec3> surface;
  bool (*inside)(const Vec3&);
};

std::vector<Case> cases() {
  return {{"sphere", sphere, sphere_points(sphere.radius), [](const Vec3& x) { return norm(x) < sphere.radius; }},
          {"capsule", capsule, capsule_points(),
           [](const Vec3& x) {
             const double r = capsule.radius, z = std::abs(x.z) - capsule.length / 2;
             const double across = std::hypot(x.x, x.y);
             return z <= 0 ? across < r : std::hypot(across, z) < r;
           }},
          {"box", box, box_points(), [](const Vec3& x) {
             return std::abs(x.x) < box.size.x / 2 && std::abs(x.y) < box.size.y / 2 && std::abs(x.z) < box.size.z / 2;
           }}};
}

Eigen::Vector3d eigen(const Vec3& v) {
  return {v.x, v.y, v.z};
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_distance_is_that_to_the_nearest_of_dense_surface_points) {
  for (const Case& c : cases()) {
    BOOST_TEST_CONTEXT(c.name) {
      const auto distance = shape_distance(c.shape);
      test::Dice dice(3);
      for (int i = 0; i < 300; ++i) {
        const Vec3 x = dice.in_cube(0.05);
        double least = 1;
        for (const Vec3& p : c.surface) least = std::min(least, norm(p - x));
        const Nearest n = distance->nearest(x);
        BOOST_TEST((n.distance < 0) == c.inside(x));
        // The points are samples: none is nearer than the nearest, and one is within a spacing of it.
        BOOST_TEST(std::abs(n.distance) <= least + 1e-12);
        BOOST_TEST(std::abs(n.distance) >= least - spacing);
        BOOST_TEST(norm(n.gradient) == 1.0, tt::tolerance(1e-12));
        BOOST_TEST(norm(n.p + n.distance * n.gradient - x) < 1e-15);
        BOOST_TEST(std::abs(distance->nearest(n.p).distance) < 1e-15);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(gradient_and_hessian_are_the_differences_of_the_distance) {
  for (const Case& c : cases()) {
    BOOST_TEST_CONTEXT(c.name) {
      const auto distance = shape_distance(c.shape);
      test::Dice dice(3);
      const double h = 1e-7;
      int compared = 0;
      for (int i = 0; i < 500; ++i) {
        const Vec3 x = dice.in_cube(0.04);
        const Nearest n = distance->nearest(x);
        const Eigen::Matrix3d hessian = distance->hessian(n, x);
        // Differences across a boundary between features, or on both sides of a medial surface, tell nothing.
        bool one_feature = true;
        Vec3 gradient;
        Eigen::Matrix3d turned;
        for (int axis = 0; axis < 3; ++axis) {
          Vec3 step;
          step[axis] = h;
          const Nearest up = distance->nearest(x + step), down = distance->nearest(x - step);
          one_feature = one_feature && up.face == n.face && down.face == n.face && up.feature == n.feature &&
                        down.feature == n.feature && up.of_face == n.of_face && down.of_face == n.of_face;
          gradient[axis] = (up.distance - down.distance) / (2 * h);
          turned.col(axis) = eigen(up.gradient - down.gradient) / (2 * h);
        }
        if (!one_feature || hessian.cwiseAbs().maxCoeff() > 2000) continue;
        ++compared;
        BOOST_TEST(norm(gradient - n.gradient) < 1e-6);
        BOOST_TEST((turned - hessian).cwiseAbs().maxCoeff() < 1e-3 * (1 + hessian.cwiseAbs().maxCoeff()));
        BOOST_TEST((hessian * eigen(n.gradient)).norm() < 1e-9);
      }
      BOOST_TEST(compared > 400);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_box_names_the_face_edge_or_corner_that_is_nearest) {
  const auto distance = shape_distance(box);
  const auto of = [&](const Vec3& x) { return distance->nearest(x); };
  BOOST_TEST((of({0.02, 0.001, -0.002}).feature == Feature::face));
  BOOST_TEST(of({0.02, 0.001, -0.002}).face == 1);
  BOOST_TEST(of({0.001, 0.001, -0.03}).face == 4);
  const Nearest edge = of({0.02, 0.001, 0.04});
  BOOST_TEST((edge.feature == Feature::edge));
  BOOST_TEST(edge.of_face == 1);
  BOOST_TEST(norm(edge.p - Vec3{0.01, 0.001, 0.025}) < 1e-15);
  const Nearest corner = of({-0.02, 0.02, 0.04});
  BOOST_TEST((corner.feature == Feature::corner));
  BOOST_TEST(corner.of_face == 6);
  BOOST_TEST(corner.distance == std::sqrt(0.01 * 0.01 + 0.005 * 0.005 + 0.015 * 0.015), tt::tolerance(1e-14));
}

BOOST_AUTO_TEST_CASE(where_several_points_are_as_near_the_choice_is_fixed) {
  const Nearest centre = shape_distance(sphere)->nearest({});
  BOOST_TEST(centre.distance == -sphere.radius);
  BOOST_TEST(norm(centre.gradient - Vec3{0, 0, 1}) == 0.0);
  for (const double z : {0.0, 0.015, -0.015, 0.007}) {
    const Nearest on_axis = shape_distance(capsule)->nearest({0, 0, z});
    BOOST_TEST(on_axis.distance == -capsule.radius);
    BOOST_TEST(norm(on_axis.p - Vec3{capsule.radius, 0, z}) == 0.0);
  }
  // A cube's centre is as near to all faces, its diagonal to three.
  const auto cube = shape_distance(BoxShape{{0.02, 0.02, 0.02}});
  BOOST_TEST(cube->nearest({}).face == 1);
  BOOST_TEST(cube->nearest({-0.005, -0.005, 0.005}).face == 0);
  BOOST_TEST(cube->nearest({0.001, -0.005, 0.005}).face == 2);
}

BOOST_AUTO_TEST_CASE(on_the_surface_the_gradient_is_the_mean_of_the_normals_that_meet) {
  const auto distance = shape_distance(box);
  const auto check = [&](const Vec3& x, const Vec3& n, Feature feature) {
    const Nearest on = distance->nearest(x);
    BOOST_TEST(std::abs(on.distance) < 1e-12);
    BOOST_TEST(norm(on.gradient - n / norm(n)) < 1e-12);
    BOOST_TEST((on.feature == feature));
    BOOST_TEST(distance->hessian(on, x).norm() == 0.0);
  };
  check({0.01, 0.002, 0.003}, {1, 0, 0}, Feature::face);
  check({-0.01, 0.002, 0.025}, {-1, 0, 1}, Feature::edge);
  check({-0.01, -0.015, 0.025}, {-1, -1, 1}, Feature::corner);
  BOOST_TEST(norm(shape_distance(sphere)->nearest({0, 0.02, 0}).gradient - Vec3{0, 1, 0}) < 1e-12);
  BOOST_TEST(norm(shape_distance(capsule)->nearest({0.01, 0, 0.01}).gradient - Vec3{1, 0, 0}) < 1e-12);
}

BOOST_AUTO_TEST_CASE(a_plane_is_the_half_space_below_it) {
  const auto distance = shape_distance(PlaneShape{});
  const Nearest above = distance->nearest({0.3, -0.2, 0.01});
  BOOST_TEST(above.distance == 0.01);
  BOOST_TEST(norm(above.p - Vec3{0.3, -0.2, 0}) == 0.0);
  BOOST_TEST(norm(above.gradient - Vec3{0, 0, 1}) == 0.0);
  BOOST_TEST(distance->nearest({7, 8, -0.5}).distance == -0.5);
  BOOST_TEST(distance->hessian(above, {0.3, -0.2, 0.01}).norm() == 0.0);
}

BOOST_AUTO_TEST_CASE(lower_bounds_are_below_the_distance_and_as_near_as_floats_can_be) {
  std::vector<Shape> shapes{PlaneShape{}};
  for (const Case& c : cases()) shapes.push_back(c.shape);
  test::Dice dice(3);
  for (const Shape& shape : shapes) {
    const auto distance = shape_distance(shape);
    for (int i = 0; i < 200; ++i) {
      Points8 points;
      std::array<float, 8> bound{};
      for (std::size_t k = 0; k < 8; ++k) {
        const Vec3 x = dice.in_cube(0.05);
        points.x[k] = static_cast<float>(x.x);
        points.y[k] = static_cast<float>(x.y);
        points.z[k] = static_cast<float>(x.z);
      }
      distance->lower_bounds(points, 0xF7, bound);
      BOOST_TEST(bound[3] == 0.0F);
      for (std::size_t k = 0; k < 8; ++k) {
        if (k == 3) continue;
        const double d = distance->nearest({points.x[k], points.y[k], points.z[k]}).distance;
        BOOST_TEST(bound[k] <= d);
        BOOST_TEST(bound[k] >= d - 2e-7 * (std::abs(d) + 1e-30));
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(a_mesh_has_no_closed_form) {
  BOOST_CHECK_THROW(shape_distance(MeshShape{}), InputError);
}

BOOST_AUTO_TEST_SUITE_END()
