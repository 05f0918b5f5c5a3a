// The surface of deforming bodies at one instant: its faces in a tree of boxes, and the signed distance of a point.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "nodes/physics/geometry/signed_distance.hpp"
#include "nodes/physics/mesh/bounds.hpp"

namespace tactor {

using FaceNodes = std::array<std::int32_t, 3>;

/// Whether two boxes have a point in common.
inline bool boxes_meet(const Bounds& a, const Bounds& b) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(a.low[axis] <= b.high[axis] && b.low[axis] <= a.high[axis])) return false;
  }
  return true;
}
/// m^2, the squared distance of x to a box; 0 inside.
inline double squared_to_box(const Bounds& box, const Vec3& x) {
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double d = std::max({box.low[axis] - x[axis], x[axis] - box.high[axis], 0.0});
    sum += d * d;
  }
  return sum;
}
/// A box that reaches farther by so much on each side, m.
inline Bounds larger(Bounds box, double by) {
  box.low -= {by, by, by};
  box.high += {by, by, by};
  return box;
}

/// The point of a face that is nearest to a point. A face that is flat to a line or a point has one too.
struct OnFace {
  std::array<double, 3> share{};  ///< of the corners, sum 1
  Vec3 p;                         ///< m
  double squared = 0;             ///< m^2, squared distance
  Feature feature = Feature::face;
  std::uint8_t i = 0;  ///< edge i leads from corner i to i + 1
};
OnFace nearest_on_face(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& x);

/// The nearest point of a surface.
struct SurfacePoint {
  double distance = 0;  ///< m, signed; negative on the side that faces do not face
  Vec3 n;               ///< unit, the direction of growing distance
  Vec3 p;               ///< m
  std::int32_t face = -1;
  std::array<double, 3> share{};  ///< of the corners of `face`, sum 1
  /// False where the sign says nothing: the surface ends at p, or is open and x is deeper in than its box is long, or
  /// its faces at p have no direction, or no face is finite (`face` is -1 then, and the distance infinite).
  bool judged = false;
};

/// Triangles over nodes that move. The tree is built once; its boxes follow the nodes. Each node of the tree holds the
/// faces of its children, halved by their number, and its box is exact: the least that holds the corners.
///
/// The sign of a distance is that of dot(x - p, N), where N is the angle-weighted pseudo-normal of the face, edge or
/// corner that holds the nearest point p (J. A. Baerentzen and H. Aanaes, "Signed distance computation using the angle
/// weighted pseudonormal", IEEE TVCG 11, 2005). It is right where the surface is closed and does not cut itself. An
/// open surface ends at edges that one face alone has. A point whose nearest point lies there is beyond the rim, and is
/// not judged.
///
/// What is found does not depend on the tree. Coordinates that are no numbers: a face that has one is never found.
class MovingSurface {
 public:
  /// Surfaces of so many faces and nodes allocate nothing from here on.
  void reserve(std::size_t faces, std::size_t nodes);
  /// Takes other faces, and sorts them by where the nodes are now. Every index must be below the number of nodes.
  void set(std::span<const FaceNodes> faces, std::span<const Vec3> nodes);
  /// The nodes are here now, m in W. The span must live until the next call.
  void move(std::span<const Vec3> nodes);

  /// m, no less than any node's way while times_placed stays the same: of each move the longest, added up.
  [[nodiscard]] double way() const { return way_; }
  /// Counts what breaks the way: other faces, and nodes that were or are no numbers.
  [[nodiscard]] std::int64_t times_placed() const { return times_placed_; }

  [[nodiscard]] const std::vector<FaceNodes>& faces() const { return faces_; }
  /// m, about all faces; empty where there are none.
  [[nodiscard]] Bounds box() const { return tree_.empty() ? Bounds{} : tree_.front().box; }
  /// A box outside of which no point is judged to be inside the surface.
  [[nodiscard]] Bounds inner_box() const { return open_ ? larger(box(), norm(box().size())) : box(); }
  [[nodiscard]] const Vec3& corner(std::int32_t face, std::size_t i) const {
    return nodes_[static_cast<std::size_t>(faces_[static_cast<std::size_t>(face)][i])];
  }
  /// Sets `found` to the faces whose box meets that one, in the order of their numbers. `skip`: a function of a box;
  /// where it is true, faces that lie in the box may be left out.
  template <class Skip>
  void faces_in(const Bounds& box, const Skip& skip, std::vector<std::int32_t>& found) const;
  void faces_in(const Bounds& box, std::vector<std::int32_t>& found) const {
    faces_in(
        box, [](const Bounds&) { return false; }, found);
  }
  /// The nearest point to x; of several as near, that of the face of the lowest number. `hint`: a face that may be near
  /// it, or -1; it changes nothing but the time. `left`: where not null, a step of work is taken for each leaf of the
  /// tree that was looked at.
  [[nodiscard]] SurfacePoint nearest(const Vec3& x, std::int32_t hint = -1, int* left = nullptr) const;
  /// Unit: the mean of the faces' normals n_f about `at`, which turns continuously as the point moves over the edges:
  ///   sum(k_f min(area_f, radius^2) n_f),   k_f = (1 - (d_f / radius)^2)^2,
  /// over the faces whose distance d_f from the point is less than `radius` (m). Those that face away from at.n, as the
  /// other side of a thin body does, count less, by clamp(1 + 2 dot(n_f, at.n), 0, 1). It is at.n where the mean has no
  /// direction or one across it. `scratch` is overwritten; `left`: a step of work for each face.
  [[nodiscard]] Vec3 mean_normal(const SurfacePoint& at, double radius, std::vector<std::int32_t>& scratch,
                                 int* left = nullptr) const;

 private:
  struct Node {
    Bounds box;
    std::int32_t right = 0;             // of a branch; the left child comes next
    std::int32_t first = 0, count = 0;  // of a leaf, in order_; a branch has no count
  };
  static constexpr std::size_t most_levels = 64;
  void build(std::size_t begin, std::size_t end);
  void connect(std::size_t nodes);
  [[nodiscard]] Vec3 middle(std::int32_t face) const;
  [[nodiscard]] Vec3 normal(std::int32_t face) const;
  [[nodiscard]] Vec3 normal_of(std::int32_t face, const OnFace& on) const;
  [[nodiscard]] bool ends_at(std::int32_t face, const OnFace& on) const;

  std::vector<FaceNodes> faces_;
  std::vector<std::int32_t> order_;         // faces, those of a leaf together
  std::vector<Node> tree_;                  // the root first, every node before its children
  std::vector<FaceNodes> neighbour_;        // of each face, across its edge i; -1: none
  std::vector<std::int32_t> around_;        // faces of each node, those of a node together
  std::vector<std::int32_t> around_begin_;  // where they begin; one entry more than nodes
  std::vector<std::uint8_t> at_rim_;        // of each node
  bool open_ = false;                       // some edge has one face alone
  std::span<const Vec3> nodes_;
  std::vector<Vec3> were_;  // m, where nodes_ were when they last moved
  double way_ = 0;          // m
  std::int64_t times_placed_ = 0;
};

template <class Skip>
void MovingSurface::faces_in(const Bounds& box, const Skip& skip, std::vector<std::int32_t>& found) const {
  found.clear();
  if (tree_.empty()) return;
  std::array<std::int32_t, most_levels> open;
  std::size_t count = 0;
  open[count++] = 0;
  while (count > 0) {
    const std::int32_t k = open[--count];
    const Node& node = tree_[static_cast<std::size_t>(k)];
    if (!boxes_meet(node.box, box) || skip(node.box)) continue;
    if (node.count == 0) {
      open[count++] = node.right;
      open[count++] = k + 1;
      continue;
    }
    for (std::int32_t j = node.first; j < node.first + node.count; ++j) {
      const std::int32_t face = order_[static_cast<std::size_t>(j)];
      Bounds of_face;
      bool finite = true;
      for (std::size_t i = 0; i < 3; ++i) {
        of_face.add(corner(face, i));
        finite = finite && is_finite(corner(face, i));
      }
      if (finite && boxes_meet(of_face, box)) found.push_back(face);
    }
  }
  std::sort(found.begin(), found.end());
}

}  // namespace tactor
