// Measures of tetrahedra agree with closed forms.
#include <cmath>
#include <limits>
#include <numbers>

#include <boost/test/unit_test.hpp>

#include "nodes/physics/mesh/tet_quality.hpp"

BOOST_AUTO_TEST_SUITE(tet_quality_test)

using namespace tactor;
namespace tt = boost::test_tools;

namespace {

constexpr double degree = std::numbers::pi / 180;

/// Edges of length 2 sqrt(2) a.
TetCorners regular(double a) {
  return {Vec3{a, -a, -a}, Vec3{a, a, a}, Vec3{-a, a, -a}, Vec3{-a, -a, a}};
}

/// Three edges of length a at right angles.
TetCorners corner(double a) {
  return {Vec3{0, 0, 0}, Vec3{a, 0, 0}, Vec3{0, a, 0}, Vec3{0, 0, a}};
}

TetCorners moved(TetCorners tet, const Pose& X) {
  for (Vec3& p : tet) p = transform(X, p);
  return tet;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_regular_tetrahedron_has_angles_of_70_53_degrees_and_ratio_1) {
  for (const double a : {1e-6, 0.01, 1e3}) {
    for (const Pose& X : {Pose{}, Pose{{5 * a, -3 * a, 2 * a}, from_rotation_vector({0.4, -1.1, 0.7})}}) {
      const TetCorners tet = moved(regular(a), X);
      BOOST_TEST(volume_of(tet) == 8.0 / 3 * a * a * a, tt::tolerance(1e-12));
      const DihedralAngles angles = dihedral_angles(tet);
      BOOST_TEST(angles.smallest == std::acos(1.0 / 3), tt::tolerance(1e-12));
      BOOST_TEST(angles.largest == std::acos(1.0 / 3), tt::tolerance(1e-12));
      BOOST_TEST(angles.smallest / degree == 70.5288, tt::tolerance(1e-5));
      BOOST_TEST(radius_ratio(tet) == 1.0, tt::tolerance(1e-12));
    }
  }
}

BOOST_AUTO_TEST_CASE(a_corner_of_a_cube_has_the_closed_forms) {
  const TetCorners tet = corner(0.3);
  BOOST_TEST(volume_of(tet) == 0.027 / 6, tt::tolerance(1e-13));
  // The slanted face meets the others at arccos(1/sqrt(3)), these meet at right angles.
  BOOST_TEST(dihedral_angles(tet).smallest == std::acos(1 / std::sqrt(3.0)), tt::tolerance(1e-13));
  BOOST_TEST(dihedral_angles(tet).largest == std::numbers::pi / 2, tt::tolerance(1e-13));
  // r = a / (3 + sqrt(3)), R = a sqrt(3) / 2.
  BOOST_TEST(radius_ratio(tet) == 3 / (3 + std::sqrt(3.0)) / (std::sqrt(3.0) / 2), tt::tolerance(1e-13));
}

BOOST_AUTO_TEST_CASE(a_wedge_has_the_angle_it_is_made_with) {
  for (const double angle : {0.01, 0.5, 5.0, 30.0, 50.0}) {
    // Two faces through the z axis at that angle.
    const double a = angle * degree;
    const TetCorners tet{Vec3{0, 0, -1}, Vec3{0, 0, 1}, Vec3{1, 0, 0}, Vec3{std::cos(a), std::sin(a), 0}};
    BOOST_TEST(volume_of(tet) == 2 * std::sin(a) / 6, tt::tolerance(1e-12));
    BOOST_TEST(dihedral_angles(tet).smallest / degree == angle, tt::tolerance(1e-9));
  }
}

BOOST_AUTO_TEST_CASE(flat_and_inverted_tetrahedra_are_told_by_sign) {
  const TetCorners flat{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{1, 1, 0}, Vec3{0, 1, 0}};
  BOOST_TEST(volume_of(flat) == 0);
  BOOST_TEST(radius_ratio(flat) == 0);
  BOOST_TEST(dihedral_angles(flat).smallest == 0);
  BOOST_TEST(radius_ratio({}) == 0);
  TetCorners inverted = regular(1);
  std::swap(inverted[0], inverted[1]);
  BOOST_TEST(volume_of(inverted) == -8.0 / 3, tt::tolerance(1e-13));
  BOOST_TEST(radius_ratio(inverted) == -1, tt::tolerance(1e-13));
}

BOOST_AUTO_TEST_CASE(a_mesh_is_as_good_as_its_worst_tetrahedron) {
  TetMesh mesh;
  for (const TetCorners& tet : {regular(1), corner(1)}) {
    const int n = static_cast<int>(mesh.nodes.size());
    mesh.nodes.insert(mesh.nodes.end(), tet.begin(), tet.end());
    mesh.tets.push_back({n, n + 1, n + 2, n + 3});
  }
  const TetQuality quality = quality_of(mesh);
  BOOST_TEST(quality.volume == 8.0 / 3 + 1.0 / 6, tt::tolerance(1e-13));
  BOOST_TEST(quality.smallest_angle == std::acos(1 / std::sqrt(3.0)), tt::tolerance(1e-13));
  BOOST_TEST(quality.worst_ratio == radius_ratio(corner(1)), tt::tolerance(1e-13));
  BOOST_TEST(quality.mean_edge == (6 * 2 * std::sqrt(2.0) + 3 + 3 * std::sqrt(2.0)) / 12, tt::tolerance(1e-13));
}

BOOST_AUTO_TEST_SUITE_END()
