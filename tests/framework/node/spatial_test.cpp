// Rotations and poses against Eigen's own.
#include "framework/core/spatial.hpp"

#include <Eigen/Geometry>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_real_distribution.hpp>
#include <boost/test/unit_test.hpp>

BOOST_AUTO_TEST_SUITE(spatial_test)

using namespace tactor;

namespace {

struct Dice {
  boost::random::mt19937_64 engine{7};
  double operator()(double a, double b) { return boost::random::uniform_real_distribution<double>(a, b)(engine); }
  Vec3 vector(double size) { return {(*this)(-size, size), (*this)(-size, size), (*this)(-size, size)}; }
};

Eigen::Vector3d eigen(const Vec3& v) {
  return {v.x, v.y, v.z};
}

}  // namespace

BOOST_AUTO_TEST_CASE(exponential_map_is_eigens_angle_axis) {
  Dice draw;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 r = draw.vector(3.0);
    const Vec3 v = draw.vector(1.0);
    const Eigen::Vector3d expected = Eigen::AngleAxisd(norm(r), eigen(r).normalized()) * eigen(v);
    BOOST_TEST((eigen(rotate(from_rotation_vector(r), v)) - expected).norm() < 1e-13);
  }
}

BOOST_AUTO_TEST_CASE(logarithm_undoes_the_exponential_down_to_denormal_angles) {
  Dice draw;
  for (const double size : {1.7, 1e-2, 1e-5, 1e-9, 1e-300}) {
    for (int i = 0; i < 200; ++i) {
      const Vec3 r = draw.vector(size);
      BOOST_TEST(norm(to_rotation_vector(from_rotation_vector(r)) - r) <= 1e-14 * size + 1e-15 * (size > 1));
    }
  }
}

BOOST_AUTO_TEST_CASE(logarithm_takes_the_shorter_way_round) {
  const Quat q = from_rotation_vector({0, 0, 3.0});
  const Vec3 r = to_rotation_vector({-q.w, -q.x, -q.y, -q.z});
  BOOST_TEST(norm(r - Vec3{0, 0, 3.0}) < 1e-14);
}

BOOST_AUTO_TEST_CASE(a_pose_times_its_inverse_is_the_identity) {
  Dice draw;
  for (int i = 0; i < 100; ++i) {
    const Pose X{draw.vector(2.0), from_rotation_vector(draw.vector(3.0))};
    const Pose I = X * inverse(X);
    BOOST_TEST(norm(I.p) < 1e-14);
    BOOST_TEST(norm(to_rotation_vector(I.R)) < 1e-14);
  }
}

BOOST_AUTO_TEST_SUITE_END()
