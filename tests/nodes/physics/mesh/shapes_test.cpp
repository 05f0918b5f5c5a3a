// The integrals of meshes agree with the closed forms of simple solids.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <boost/test/unit_test.hpp>

#include "nodes/physics/mesh/body_mesh.hpp"
#include "nodes/physics/mesh/mass_properties.hpp"
#include "tests/support/shapes.hpp"

BOOST_AUTO_TEST_SUITE(shapes_test)

using namespace tactor;

namespace {

constexpr double pi = std::numbers::pi;

void check_near(const Vec3& a, const Vec3& b, double tolerance) {
  BOOST_TEST(norm(a - b) <= tolerance);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_box_has_the_closed_form_inertia) {
  const Vec3 a{0.1, 0.2, 0.3};
  const MassProperties p = mass_properties(test::box(a, {1, -2, 3}));
  const double v = 0.1 * 0.2 * 0.3;
  BOOST_TEST(p.volume == v, boost::test_tools::tolerance(1e-12));
  check_near(p.center, {1, -2, 3}, 1e-13);
  BOOST_TEST(p.inertia(0, 0) == v / 12 * (0.04 + 0.09), boost::test_tools::tolerance(1e-10));
  BOOST_TEST(p.inertia(1, 1) == v / 12 * (0.01 + 0.09), boost::test_tools::tolerance(1e-10));
  BOOST_TEST(p.inertia(2, 2) == v / 12 * (0.01 + 0.04), boost::test_tools::tolerance(1e-10));
  BOOST_TEST(std::abs(p.inertia(0, 1)) + std::abs(p.inertia(0, 2)) + std::abs(p.inertia(1, 2)) < 1e-15);
}

BOOST_AUTO_TEST_CASE(a_corner_tetrahedron_has_the_closed_form_inertia) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  const MassProperties p = mass_properties(mesh);
  BOOST_TEST(p.volume == 1.0 / 6, boost::test_tools::tolerance(1e-14));
  check_near(p.center, {0.25, 0.25, 0.25}, 1e-15);
  // The integral of x^2 is 1/60 and of x y 1/120; the centre takes 1/6 * 1/16 off each.
  BOOST_TEST(p.inertia(0, 0) == 2 * (1.0 / 60 - 1.0 / 96), boost::test_tools::tolerance(1e-13));
  BOOST_TEST(p.inertia(0, 1) == -(1.0 / 120 - 1.0 / 96), boost::test_tools::tolerance(1e-13));
}

BOOST_AUTO_TEST_CASE(a_fine_sphere_comes_near_the_closed_forms_quadratically) {
  double last = 1;
  for (const int level : {3, 4, 5}) {
    const MassProperties p = mass_properties(test::icosphere(0.05, level));
    const double volume = 4.0 / 3 * pi * 0.05 * 0.05 * 0.05;
    const double error = 1 - p.volume / volume;
    BOOST_TEST(error > 0);
    BOOST_TEST(error < 0.3 * last);
    last = error;
    BOOST_TEST(p.inertia(0, 0) / p.volume == 0.4 * 0.05 * 0.05, boost::test_tools::tolerance(3 * error));
    check_near(p.center, {}, 1e-14);
  }
}

BOOST_AUTO_TEST_CASE(rigid_motion_rotates_the_inertia_and_moves_the_centre) {
  const TriangleMesh mesh = test::box({0.1, 0.2, 0.3}, {0.01, 0.02, 0.03});
  const Pose X{{5, -3, 2}, from_rotation_vector({0.4, -1.1, 0.7})};
  TriangleMesh moved = mesh;
  for (Vec3& v : moved.vertices) v = transform(X, v);
  const MassProperties a = mass_properties(mesh), b = mass_properties(moved);
  BOOST_TEST(b.volume == a.volume, boost::test_tools::tolerance(1e-11));
  check_near(b.center, transform(X, a.center), 1e-12);
  Eigen::Matrix3d R;
  for (int i = 0; i < 3; ++i) {
    const Vec3 column = rotate(X.R, {i == 0 ? 1.0 : 0.0, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0});
    R.col(i) << column.x, column.y, column.z;
  }
  BOOST_TEST((b.inertia - R * a.inertia * R.transpose()).norm() < 1e-9 * a.inertia.norm());
}

BOOST_AUTO_TEST_CASE(a_moving_body_has_its_origin_at_the_centre_of_mass_and_a_fixed_one_keeps_its_frame) {
  Body body;
  body.name = "block";
  body.shape = MeshShape{test::write_off(test::box({10, 20, 30}, {100, 0, 0}), "block"), 0.001};
  body.mass = 0.6;
  check_near(load_body_mesh(body).vertices[0], {0.095, -0.01, -0.015}, 1e-15);
  body.motion = Motion::rigid;
  check_near(load_body_mesh(body).vertices[0], {-0.005, -0.01, -0.015}, 1e-15);
  BOOST_TEST(body_inertia(body)(0, 0) == 0.6 / 12 * (4e-4 + 9e-4), boost::test_tools::tolerance(1e-12));
  body.inertia = Vec3{1, 2, 3};
  BOOST_TEST(body_inertia(body)(2, 2) == 3.0);
  Body ball;
  ball.shape = SphereShape{0.01};
  ball.mass = 0.2;
  BOOST_TEST(body_inertia(ball)(1, 1) == 0.4 * 0.2 * 1e-4, boost::test_tools::tolerance(1e-14));
}

BOOST_AUTO_TEST_CASE(a_box_has_the_inertia_of_its_mesh) {
  Body box, mesh;
  box.mass = mesh.mass = 0.3;
  box.motion = mesh.motion = Motion::rigid;
  box.shape = BoxShape{{0.01, 0.02, 0.03}};
  mesh.name = "block";
  mesh.shape = MeshShape{test::write_off(test::box({0.01, 0.02, 0.03}), "inertia_block")};
  BOOST_TEST((body_inertia(box) - body_inertia(mesh)).cwiseAbs().maxCoeff() < 1e-15);
}

BOOST_AUTO_TEST_CASE(a_capsule_has_the_inertia_of_the_discs_it_is_made_of) {
  Body body;
  body.mass = 0.3;
  body.shape = CapsuleShape{.radius = 0.02, .length = 0.05};
  // A disc of radius a at height z: dm a^2 / 2 along the axis, dm (a^2 / 4 + z^2) across it.
  double volume = 0, along = 0, across = 0;
  constexpr int slices = 200'000;
  const double height = 0.05 + 2 * 0.02, dz = height / slices;
  for (int i = 0; i < slices; ++i) {
    const double z = -height / 2 + (i + 0.5) * dz, into_cap = std::max(0.0, std::abs(z) - 0.025);
    const double square = 0.02 * 0.02 - into_cap * into_cap, dv = std::numbers::pi * square * dz;
    volume += dv;
    along += dv * square / 2;
    across += dv * (square / 4 + z * z);
  }
  const Eigen::Matrix3d inertia = body_inertia(body);
  BOOST_TEST(inertia(2, 2) == 0.3 / volume * along, boost::test_tools::tolerance(1e-8));
  BOOST_TEST(inertia(0, 0) == 0.3 / volume * across, boost::test_tools::tolerance(1e-8));
  BOOST_TEST(inertia(1, 1) == inertia(0, 0));
}

BOOST_AUTO_TEST_SUITE_END()
