// Signed singular values and nearest rotations of 3x3 matrices: of every rank, with repeated values, inverted.
#include <boost/test/unit_test.hpp>

#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "nodes/physics/deformable/nearest_rotation.hpp"
#include "nodes/physics/deformable/signed_svd.hpp"
#include "tests/nodes/physics/deformable/boxes.hpp"

BOOST_AUTO_TEST_SUITE(signed_svd_test)

using namespace tactor;
using namespace tactor::test;
namespace tt = boost::test_tools;

namespace {

Eigen::Matrix3d turn(Noise& noise) {
  const Eigen::Vector4d q(noise(), noise(), noise(), noise());
  return Eigen::Quaterniond(Eigen::Vector4d(q.normalized())).toRotationMatrix();
}

/// Rotations left and right, in order, and the product.
void check(const Eigen::Matrix3d& F, double tolerance = 1e-14) {
  SignedSvd svd;
  signed_svd(F, svd);
  const double scale = std::max(F.norm(), 1e-300);
  BOOST_TEST((svd.U.transpose() * svd.U - Eigen::Matrix3d::Identity()).norm() < 1e-14);
  BOOST_TEST((svd.V.transpose() * svd.V - Eigen::Matrix3d::Identity()).norm() < 1e-14);
  BOOST_TEST(svd.U.determinant() == 1, tt::tolerance(1e-13));
  BOOST_TEST(svd.V.determinant() == 1, tt::tolerance(1e-13));
  BOOST_TEST((svd.U * svd.s.asDiagonal() * svd.V.transpose() - F).norm() <= tolerance * scale);
  BOOST_TEST(svd.s[0] >= svd.s[1] - 1e-15 * scale);
  BOOST_TEST(svd.s[1] >= std::abs(svd.s[2]) - tolerance * scale);
  if (std::abs(F.determinant()) > 1e-10 * scale * scale * scale) BOOST_TEST((svd.s[2] < 0) == (F.determinant() < 0));
}

}  // namespace

BOOST_AUTO_TEST_CASE(any_matrix_is_rotations_about_its_signed_singular_values) {
  Noise noise;
  for (int i = 0; i < 2000; ++i) {
    Eigen::Matrix3d F;
    for (double& entry : F.reshaped()) entry = noise();
    check(F);
    // As another method finds them.
    SignedSvd svd;
    signed_svd(F, svd);
    const Eigen::Vector3d other = Eigen::JacobiSVD<Eigen::Matrix3d>(F).singularValues();
    BOOST_TEST((svd.s.cwiseAbs() - other).norm() < 1e-13);
  }
}

BOOST_AUTO_TEST_CASE(repeated_and_missing_singular_values_are_taken) {
  Noise noise;
  const std::vector<Eigen::Vector3d> all{
      {1, 1, 1}, {1, 1, -1},       {2, 1, 1},   {2, 2, 1},     {2, 1, -1},         {1, 1, 0},       {1, 0, 0},
      {0, 0, 0}, {1, 1, 1 + 1e-9}, {1e6, 1, 1}, {1e6, 1e6, 1}, {1e-9, 1e-9, 1e-9}, {1, 1e-3, 1e-6}, {1, 0.5, 1e-12}};
  for (const Eigen::Vector3d& s : all) {
    BOOST_TEST_CONTEXT(s.transpose()) {
      for (int i = 0; i < 50; ++i) check(turn(noise) * s.asDiagonal() * turn(noise).transpose(), 1e-12);
      check(s.asDiagonal(), 1e-12);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_rotation_is_its_own_nearest_rotation) {
  Noise noise;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Matrix3d R = turn(noise);
    SignedSvd svd;
    signed_svd(R, svd);
    BOOST_TEST((svd.U * svd.V.transpose() - R).norm() < 1e-14);
    // And where R is stretched symmetrically.
    const Eigen::Matrix3d Q = turn(noise);
    signed_svd(R * Q * Eigen::Vector3d(1.5, 0.7, 0.2).asDiagonal() * Q.transpose(), svd);
    BOOST_TEST((svd.U * svd.V.transpose() - R).norm() < 1e-14);
  }
}

BOOST_AUTO_TEST_CASE(eigenvalues_of_symmetric_matrices_are_found) {
  Noise noise;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d expected(noise(), noise(), i % 3 == 0 ? 0.0 : noise());
    const Eigen::Matrix3d Q = turn(noise);
    const Eigen::Matrix3d A = Q * expected.asDiagonal() * Q.transpose();
    Eigen::Matrix3d V;
    Eigen::Vector3d d;
    symmetric_eigen(A, V, d);
    BOOST_TEST((V * d.asDiagonal() * V.transpose() - A).norm() < 1e-14);
    BOOST_TEST(V.determinant() == 1, tt::tolerance(1e-13));
  }
}

BOOST_AUTO_TEST_CASE(the_nearest_rotation_is_that_of_singular_values_however_far_it_is) {
  Noise noise;
  for (const double strain : {1e-9, 1e-3, 0.1, 0.5, 1.0, 3.0}) {
    for (int i = 0; i < 1000; ++i) {
      Eigen::Matrix3d F;
      for (double& entry : F.reshaped()) entry = strain * noise();
      F = turn(noise) * (F + Eigen::Matrix3d::Identity());
      Eigen::Matrix3d R;
      nearest_rotation(F, R);
      SignedSvd svd;
      signed_svd(F, svd);
      BOOST_TEST((R.transpose() * R - Eigen::Matrix3d::Identity()).norm() < 1e-14);
      // Where two singular values nearly cancel, no rotation is much nearer than another.
      const double sum = svd.s[1] + svd.s[2];
      BOOST_TEST((R - svd.U * svd.V.transpose()).norm() < 1e-14 * std::max(1.0, F.norm() / sum));
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
