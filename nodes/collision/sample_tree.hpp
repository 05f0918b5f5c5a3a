// Finds the samples of one body that are near another body's surface or inside it.
#pragma once

#include <vector>

#include "nodes/collision/exact_distance.hpp"
#include "nodes/scene/surface_samples.hpp"

namespace tactor {

/// A sample within the margin, with its nearest point on the other body.
struct NearSample {
  int sample = 0;   ///< index into the samples the tree was made of
  Nearest nearest;  ///< in the frame of the other body
};

/// A binary tree of bounding spheres over samples. Signed distance changes by no more than the way moved, so a distance
/// once computed at a sphere's centre bounds it at every later pose; it is computed again only where that bound does
/// not decide. What is found does not depend on earlier queries, only the time it takes does.
class SampleTree {
 public:
  explicit SampleTree(const std::vector<SurfaceSample>& samples);

  /// Puts the samples with signed distance to `other` below `margin` (m) into `found`, in the order of the tree.
  /// X_OB: the body of the samples in the frame of `other`, which must be the same in every call.
  void find(const ExactDistance& other, const Pose& X_OB, double margin, std::vector<NearSample>& found);

 private:
  struct Sphere {
    Vec3 center;        // m, in the frame of the samples
    double radius = 0;  // m
    int sample = -1;    // of a leaf
    int after = 0;      // the next sphere where this one is left out
    // The last exact query of the centre.
    Vec3 asked_at;
    double distance = 0;
    int face = -1;  // -1: not asked yet
  };

  void build(const std::vector<SurfaceSample>& samples, std::vector<int>& order, std::size_t begin, std::size_t end);

  std::vector<Sphere> spheres_;  // depth first
};

}  // namespace tactor
