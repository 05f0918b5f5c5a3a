// The signed distance of a point to a solid, as collision asks for it, whatever computes it.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

#include "framework/core/spatial.hpp"

namespace tactor {

/// What holds the nearest point of a mesh.
enum class Feature : std::uint8_t { face, edge, corner };

/// The nearest surface point of a query, in the frame of the solid.
struct Nearest {
  double distance = 0;  ///< m, negative inside
  Vec3 p;               ///< m, the nearest point of the surface
  Vec3 gradient;        ///< unit, the direction of growing distance; on the surface the pseudo-normal
  int face = -1;        ///< the face that holds p
  Feature feature = Feature::face;
  std::uint8_t of_face = 0;  ///< which edge (from corner i to i + 1) or corner of `face` it is

  bool operator==(const Nearest&) const = default;
};

/// Eight points at once, in the frame of the solid, rounded to float.
struct Points8 {
  alignas(32) std::array<float, 8> x, y, z;
};

class SignedDistance {
 public:
  virtual ~SignedDistance() = default;

  /// The nearest point to x (m). Of several as near, that of the face of the lowest index. A face near the answer as
  /// `hint` (or -1) may make it faster and does not change it. Rounding counts: from 1e15 times the size of the solid
  /// on it decides which face that is, and thereby the sign. Where x is no number or its square none, the face is one
  /// of the solid's and the distance is not finite.
  [[nodiscard]] virtual Nearest nearest(const Vec3& x, int hint = -1) const = 0;

  /// For each of the eight points whose bit is set in `wanted`, a number in m that the signed distance there is not
  /// below; closer to it the nearer the surface is. Other entries of `bound` are undefined. By default the distances
  /// of `nearest`, rounded down.
  virtual void lower_bounds(const Points8& x, unsigned wanted, std::array<float, 8>& bound) const;

  /// The Hessian of the signed distance at x (1/m), `nearest` being what `nearest(x)` gave: how the gradient turns as x
  /// moves while the nearest point stays on its feature. Zero at distance 0, where an edge or corner has none.
  [[nodiscard]] virtual Eigen::Matrix3d hessian(const Nearest& nearest, const Vec3& x) const = 0;
};

}  // namespace tactor
