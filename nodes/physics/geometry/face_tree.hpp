// The nearest face of a mesh anywhere in space, eight boxes or faces at a time.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "framework/core/large_vector.hpp"
#include "nodes/physics/geometry/surface.hpp"

namespace tactor {

/// A face in floats about an origin near the mesh. Corner a is that of the widest angle, so the sine there is at least
/// one half in all but very flat faces; those have a NaN in `a` and count as at distance 0 until looked at exactly.
struct alignas(64) FaceRecord {
  float a[3];            // m
  std::int32_t face;     // its index in the mesh
  float ab[3];           // m
  float inverse_ab;      // 1 / |ab|^2
  float ac[3];           // m
  float inverse_ac;      // 1 / |ac|^2
  float cc, bc, bb;      // |ac|^2, ab.ac and |ab|^2 over |ab x ac|^2
  float inverse_across;  // 1 / |ac - ab|^2
};

/// A distance computed from a record errs by less than this times (|x| + the reach of the mesh) from the origin: the
/// roundings sum up to less than 160 times 2^-24 where the sine at corner a is one half.
constexpr float relative_error = 256.0F / (1 << 24);

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

  /// How far in m squared_distances may be off at x.
  [[nodiscard]] double error(const Vec3& x) const { return relative_error * (norm(x - origin) + reach); }

  struct Node {
    alignas(32) std::array<std::array<float, 8>, 3> low, high;  // m, about the origin
    // A node, or ~r for the eight records from r on, or no_child.
    std::array<std::int32_t, 8> child;
  };
  // The root is below none. Its box is empty, hence infinitely far; so are others of a point beyond floats.
  static constexpr std::int32_t no_child = 0;
  static_assert(sizeof(Node) == 224);
  // More than a tree of n leaves has, which is log8(n) + 1; searches keep a stack for so many.
  static constexpr std::size_t most_levels = 12;

  Vec3 origin;                      // m
  double reach = 0;                 // m, of the farthest corner from the origin
  LargeVector<Node> nodes;          // the root first
  LargeVector<FaceRecord> records;  // in the order of the leaves; the last is a face far away that fills up
  [[nodiscard]] std::uint32_t filler() const { return static_cast<std::uint32_t>(records.size() - 1); }

 private:
  std::int32_t build(const Surface& surface, std::vector<int>& order, std::size_t begin, std::size_t end);
  [[nodiscard]] FaceRecord record(const Surface& surface, int face) const;
};

}  // namespace tactor
