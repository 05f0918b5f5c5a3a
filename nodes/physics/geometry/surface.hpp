// The faces of a closed mesh with the normals that tell inside from outside.
#pragma once

#include <array>

#include "framework/core/large_vector.hpp"
#include "nodes/physics/geometry/triangle.hpp"
#include "nodes/physics/mesh/mesh.hpp"

namespace tactor {

/// The face nearest to a point so far.
struct NearestFace {
  double squared = 0;  ///< m^2
  int face = -1;
  OnTriangle on;
};

/// Flat arrays, one entry a face.
class Surface {
 public:
  Surface() = default;

  /// `mesh`: of a solid, as load_solid returns it.
  explicit Surface(const TriangleMesh& mesh);

  [[nodiscard]] int size() const { return static_cast<int>(corners.size()); }

  /// Fetches what is needed of a face that is likely to be the nearest.
  void prefetch(int face) const {
    const auto i = static_cast<std::size_t>(face);
    __builtin_prefetch(&corners[i]);
    __builtin_prefetch(&corners[i][2].z);
    __builtin_prefetch(&normals[i]);
  }

  /// A first candidate.
  [[nodiscard]] NearestFace candidate(int face, const Vec3& x) const {
    const OnTriangle on = nearest_on(corners[static_cast<std::size_t>(face)], x);
    return {dot(x - on.p, x - on.p), face, on};
  }

  /// Keeps the nearer of `best` and `face`; of two as near the one of the lower index, so that the order in which faces
  /// come does not matter.
  void compare(int face, const Vec3& x, NearestFace& best) const {
    const NearestFace other = candidate(face, x);
    if (other.squared < best.squared || (other.squared == best.squared && face < best.face)) best = other;
  }

  /// The signed distance of x, `nearest` being the nearest of all faces; the sign by the angle-weighted pseudo-normal
  /// of the face, edge or corner (J. A. Baerentzen and H. Aanaes, "Signed distance computation using the angle weighted
  /// pseudonormal", IEEE TVCG 11, 2005), which is right for every closed manifold mesh.
  [[nodiscard]] Nearest signed_distance(const NearestFace& nearest, const Vec3& x) const;

  /// See SignedDistance::hessian: 0 on a face, (1 - n n^T - e e^T) / d on an edge of direction e and (1 - n n^T) / d at
  /// a corner, where n is the gradient and d the signed distance.
  [[nodiscard]] Eigen::Matrix3d hessian(const Nearest& nearest) const;

  struct Normals {
    Vec3 face;                   ///< unit
    std::array<Vec3, 3> edge;    ///< unit, of the edge from corner i to i + 1
    std::array<Vec3, 3> corner;  ///< unit
  };
  LargeVector<std::array<Vec3, 3>> corners;  ///< m
  LargeVector<Normals> normals;
};

}  // namespace tactor
