// The geometry of the Novint Falcon: a delta robot of three arms with elbows that are offset.
#pragma once

#include <array>
#include <optional>

#include "framework/core/spatial.hpp"

namespace tactor {

/// Lengths in m and angles in rad, named as in R. E. Stamper, A Three Degree of Freedom Parallel Manipulator with Only
/// Translational Degrees of Freedom, PhD thesis 97-4, University of Maryland, 1997, p. 30; values of the Falcon as
/// published with libnifalcon (BSD licence).
struct DeltaGeometry {
  double a = 0.060;     ///< base to knee
  double b = 0.1025;    ///< shin
  double c = 0.01443;   ///< shin to the handle's centre, along u
  double d = 0.01125;   ///< shin to the handle's joint
  double e = 0.01125;   ///< knee to the shin
  double f = -0.025;    ///< shin to the handle's centre, along v
  double r = 0.040;     ///< base's centre to the arm's, along u
  double s = -0.02309;  ///< base's centre to the arm's, along v
  /// Where the arms stand about z.
  std::array<double, 3> phi{1.8325957145940461, -0.26179938779914935, -2.3561944901923448};
};

/// With u, v, w the axes of an arm, which is base's x, y, z turned by phi about z, and P the handle in them from the
/// arm's base, P = R(phi) p - (r, s, 0), the shin keeps its length where
///   (rho - d - e)^2 + V^2 = b^2,  U = P_u + c - a cos theta,  W = P_w - a sin theta,  V = P_v + f,  rho = |(U, W)|.
/// The inverse has a closed form; forward is Newton's iteration on the three equations from the middle of the
/// workspace. Neither allocates.
class DeltaArm {
 public:
  explicit DeltaArm(const DeltaGeometry& geometry = {}) : g_(geometry) {}

  /// Where the handle is, p_BD in m, at these angles in rad; nothing where it can be nowhere.
  [[nodiscard]] std::optional<Vec3> forward(const std::array<double, 3>& theta) const;
  /// The angles at which the handle is there; nothing where it cannot be.
  [[nodiscard]] std::optional<std::array<double, 3>> inverse(const Vec3& p_BD) const;
  /// K = d theta / d p by rows, 1/m; nothing where an arm is stretched and K has no bound.
  [[nodiscard]] std::optional<std::array<Vec3, 3>> rates(const std::array<double, 3>& theta, const Vec3& p_BD) const;
  /// tau = J^T F in N m with J = dp / d theta = K^-1, for a force on the handle in the base, N; nothing where K has no
  /// inverse, which is where the handle moves with all arms held.
  [[nodiscard]] std::optional<std::array<double, 3>> torques(const std::array<double, 3>& theta, const Vec3& p_BD,
                                                             const Vec3& F_B) const;
  /// The columns of J, m/rad.
  [[nodiscard]] std::optional<std::array<Vec3, 3>> jacobian(const std::array<double, 3>& theta, const Vec3& p_BD) const;

 private:
  /// An arm's equation at theta and p: its value in m^2, and its slopes with p (in B) and theta.
  struct Closure {
    double value = 0;
    Vec3 by_p;
    double by_theta = 0;
  };
  [[nodiscard]] Closure closure(int arm, double theta, const Vec3& p_BD) const;

  DeltaGeometry g_;
};

/// The solution x of row_i . x = right_i; nothing where the rows are (nearly) in one plane.
std::optional<Vec3> solve(const std::array<Vec3, 3>& rows, const std::array<double, 3>& right);

}  // namespace tactor
