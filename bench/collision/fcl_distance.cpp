#include <fcl/narrowphase/distance.h>

#include "bench/collision/closest_point.hpp"
#include "bench/collision/fcl_model.hpp"

namespace tactor::bench {

namespace {

class FclDistance final : public ClosestPoint {
 public:
  explicit FclDistance(const TriangleMesh& mesh) {
    constexpr double size = 1e-8;  // m
    fill_fcl_model(mesh, mesh_);
    fill_fcl_model({{{0, 0, 0}, {size, 0, 0}, {0, size, 0}}, {{0, 1, 2}}}, point_);
  }
  double distance(const Vec3& x) override {
    fcl::Transform3d pose = fcl::Transform3d::Identity();
    pose.translation() = fcl::Vector3d(x.x, x.y, x.z);
    fcl::DistanceResultd result;
    return fcl::distance<double>(&mesh_, fcl::Transform3d::Identity(), &point_, pose, request_, result);
  }

 private:
  FclModel<double> mesh_, point_;
  fcl::DistanceRequestd request_{true};
};

}  // namespace

std::unique_ptr<ClosestPoint> make_fcl_distance(const TriangleMesh& mesh) {
  return std::make_unique<FclDistance>(mesh);
}

}  // namespace tactor::bench
