// Finds the samples of a rigid body that are near a deforming surface or inside it.
#pragma once

#include <cstdint>
#include <vector>

#include "framework/core/spatial.hpp"
#include "nodes/physics/contact/soft_surface.hpp"
#include "nodes/physics/mesh/surface_samples.hpp"

namespace tactor {

/// A sample with its nearest point of the surface.
struct NearSoftSample {
  std::int32_t sample;
  SurfacePoint at;
};

/// A tree of balls about samples, two children a node. A signed distance changes by no more than the way moved, so
/// nothing in a ball of radius r is nearer than its centre's distance less r.
class SoftSampleTree {
 public:
  explicit SoftSampleTree(const std::vector<SurfaceSample>& samples);
  /// Sets `found` to the samples whose signed distance to the surface is judged and below `margin` (m), in an order
  /// that only the samples decide. X_WB: where the body is. `left`: as of MovingSurface::nearest; where it goes below
  /// zero the search ends.
  void find(const MovingSurface& surface, const Pose& X_WB, double margin, int* left,
            std::vector<NearSoftSample>& found) const;

 private:
  struct Ball {
    Vec3 middle;                        // m, in the frame of the body
    double radius = 0;                  // m
    std::int32_t right = 0;             // of a branch; the left child comes next
    std::int32_t first = 0, count = 0;  // of a leaf, in order_; a branch has no count
  };
  void build(std::size_t begin, std::size_t end);

  std::vector<Vec3> points_;
  std::vector<std::int32_t> order_;
  std::vector<Ball> balls_;
};

}  // namespace tactor
