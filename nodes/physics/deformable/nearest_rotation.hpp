// The rotation nearest to a 3x3 matrix.
#pragma once

#include <Eigen/Core>

namespace tactor {

/// R, which minimises |F - R| among rotations: U V^T of the signed singular values (signed_svd.hpp), also where F is
/// inverted. Of a matrix that neither turns over nor flattens, by Newton's iteration (Higham, SIAM J. Sci. Stat.
/// Comput. 1986), which takes a fraction of the time; of others by singular
/// values. Both agree to rounding. F is finite.
void nearest_rotation(const Eigen::Matrix3d& F, Eigen::Matrix3d& R);

}  // namespace tactor
