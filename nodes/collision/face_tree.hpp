// The nearest face of a mesh anywhere in space, eight boxes or faces at a time.
#pragma once

#include <array>
#include <vector>

#include "nodes/collision/surface.hpp"
#include "nodes/collision/wide.hpp"

namespace tactor {

/// A tree of bounding boxes with eight children a node and eight faces a leaf, in flat arrays.
class FaceTree {
 public:
  FaceTree() = default;
  explicit FaceTree(const Surface& surface);

  /// The nearest of all faces to x (m), exactly, as Surface::compare finds it. `hint`: a face near the answer, or -1.
  [[nodiscard]] NearestFace nearest(const Surface& surface, const Vec3& x, int hint) const;

  /// The records whose faces may be within `reach` (m) of x, into `found`; those beyond by more than rounding are left
  /// out.
  void within(const Vec3& x, double reach, std::vector<std::uint32_t>& found) const;

  /// A search of faces about x that knows none yet.
  [[nodiscard]] wide::Search search(const Surface& surface, const Vec3& x) const;

  /// How far in m squared_distances may be off at x.
  [[nodiscard]] double error(const Vec3& x) const { return wide::relative_error * (norm(x - origin) + reach); }

  struct Node {
    alignas(32) std::array<std::array<float, 8>, 3> low, high;  // m, about the origin
    std::array<std::int32_t, 8> child;                          // a node, or ~r for the eight records from r on
  };
  static_assert(sizeof(Node) == 224);

  Vec3 origin;                            // m
  double reach = 0;                       // m, of the farthest corner from the origin
  std::vector<Node> nodes;                // the root first
  std::vector<wide::FaceRecord> records;  // in the order of the leaves; the last is a face far away that fills up
  [[nodiscard]] std::uint32_t filler() const { return static_cast<std::uint32_t>(records.size() - 1); }

 private:
  std::int32_t build(const Surface& surface, std::vector<int>& order, std::size_t begin, std::size_t end);
  [[nodiscard]] wide::FaceRecord record(const Surface& surface, int face) const;
};

}  // namespace tactor
