// Finds the samples of one body that are near another body's surface or inside it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "nodes/physics/geometry/signed_distance.hpp"
#include "nodes/physics/mesh/surface_samples.hpp"

namespace tactor {

/// A sample within the margin, with the nearest point to its centre on the other body.
struct NearSample {
  int sample = 0;       ///< index into the samples the tree was made of
  double distance = 0;  ///< m, signed, of the sample's sphere: that of its centre less its radius
  Nearest nearest;      ///< of its centre, in the frame of the other body

  bool operator==(const NearSample&) const = default;
};

/// A tree of bounding spheres with eight children a node, of one body's samples against one other body.
///
/// Signed distance changes by no more than the way moved, so a sphere whose distance exceeded its radius and the margin
/// by s stays out of reach until its centre has moved by s. The way of a centre is at most that of the tree's pivot
/// plus the chord of the turns times the centre's distance from the pivot (its lever), so each child keeps one number,
/// its expiry, and eight of them are compared with the way since at once. What is found does not depend on earlier
/// queries, only the time it takes does. Queries allocate nothing once `found` has had its largest size, or from the
/// first one on after reserve_within.
class SampleTree {
 public:
  /// `radii`: of spheres about the samples in m, or empty: points.
  explicit SampleTree(const std::vector<SurfaceSample>& samples, const std::vector<double>& radii = {});

  /// The samples whose distance to `other` is below `margin` (m), in an order that only the samples decide, until the
  /// next call. X_OB: the body of the samples in the frame of `other`, which must be the same in every call.
  /// `left`: where not null, the steps of work that it may do, of which it takes what it does: a look at eight spheres
  /// or at the distance of one sample. Now and then, after a long way or where the margin is another one, all expiries
  /// are written anew: eight nodes of the tree are a step. Where `left` goes below zero the search ends and what it
  /// returns is not all.
  const std::vector<NearSample>& find(const SignedDistance& other, const Pose& X_OB, double margin,
                                      int* left = nullptr);
  /// Queries of at most `work` steps allocate nothing from here on. Returns how many samples such a query finds at
  /// most.
  std::size_t reserve_within(int work);

 private:
  struct Node {
    alignas(32) std::array<float, 8> x, y, z;  // m, centres in the frame of the samples
    std::array<float, 8> radius;               // m, rounded up
    std::array<float, 8> lever;                // m, at least those of all spheres below it
    std::array<float, 8> expiry;               // m, the way up to which the child is out of reach; never: infinite
    std::array<std::int32_t, 8> child;         // a node, or ~i for sample i
  };
  struct Sample {
    Vec3 p;                  // m
    double radius = 0;       // m
    std::int32_t face = -1;  // of its last nearest point
  };
  struct Query;

  std::int32_t build(std::vector<int>& order, std::size_t begin, std::size_t end);
  bool advance(const Pose& X_OB);
  void forget();
  float visit(Node& node, const Query& query);
  static unsigned expired(const Node& node, float way, float turn);
  static void place(const Node& node, const Query& query, Points8& x);

  std::vector<Sample> samples_;
  std::vector<Node> nodes_;  // the root first
  Vec3 pivot_;               // m
  double size_ = 0;          // m, of the longest lever
  // Since the ways were last set back to zero, m and rad.
  double way_ = 0, turn_ = 0;
  std::optional<Pose> last_pose_;
  double last_margin_ = 0;
  bool complete_ = true;  // the last search
  std::vector<NearSample> found_;
};

}  // namespace tactor
