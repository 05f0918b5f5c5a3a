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

/// What searches of a tree of samples on one surface know from earlier ones.
struct SoftSampleMemory {
  /// A point, when it was last looked at.
  struct Look {
    Vec3 p_W;                        // m
    double distance = 0;             // m, to the surface
    double way = 0;                  // m, of the surface until then
    std::int32_t face = -1;          // that was nearest
    std::int64_t times_placed = -1;  // of the surface; -1: it was not looked at
  };
  std::vector<Look> balls, samples;
};

/// A tree of balls about samples, two children a node. A signed distance changes by no more than the way moved, so
/// nothing in a ball of radius r is nearer than its centre's distance less r, and not either later on, as long as the
/// centre and the surface have moved by less than what is between.
class SoftSampleTree {
 public:
  explicit SoftSampleTree(const std::vector<SurfaceSample>& samples);
  /// Sets `found` to the samples whose signed distance to the surface is judged and below `margin` (m), in an order
  /// that only the samples decide. X_WB: where the body is. `left`: as of MovingSurface::nearest; where it goes below
  /// zero the search ends; a ball takes a step too. `memory`: of this tree and that surface. On a closed surface it
  /// changes nothing but the time. Beyond the rim of an open one the sign of a distance may jump, and then what is
  /// found there may be other than without it.
  void find(const MovingSurface& surface, const Pose& X_WB, double margin, int* left, SoftSampleMemory& memory,
            std::vector<NearSoftSample>& found) const;
  /// For `find` to have room.
  [[nodiscard]] SoftSampleMemory new_memory() const {
    using Looks = std::vector<SoftSampleMemory::Look>;
    return {Looks(balls_.size()), Looks(points_.size())};
  }

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
