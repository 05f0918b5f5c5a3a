// The signed distance of a point to a closed triangle mesh.
#pragma once

#include <memory>

#include "nodes/scene/mesh.hpp"

namespace tactor {

/// The nearest surface point of a query, in the frame of the mesh.
struct Nearest {
  double distance = 0;  ///< m, negative inside
  Vec3 p;               ///< m, the nearest point of the surface
  Vec3 gradient;        ///< unit, the direction of growing distance; on the surface the pseudo-normal
  int face = -1;        ///< the face that holds p
};

/// Exact distance by CGAL's AABB tree, or by a scan where the mesh has few faces; the sign by the angle-weighted
/// pseudo-normal of the nearest face, edge or vertex (J. A. Baerentzen and H. Aanaes, "Signed distance computation
/// using the angle weighted pseudonormal", IEEE TVCG 11, 2005), which is right for every closed manifold mesh.
class ExactDistance {
 public:
  /// The mesh must be that of a solid, as load_solid and load_body_mesh return it.
  explicit ExactDistance(const TriangleMesh& mesh);
  ~ExactDistance();
  ExactDistance(ExactDistance&&) noexcept;
  ExactDistance& operator=(ExactDistance&&) noexcept;

  /// The nearest point to x. A face near the answer as `hint` (or -1) makes it faster and does not change the distance.
  [[nodiscard]] Nearest query(const Vec3& x, int hint = -1) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tactor
