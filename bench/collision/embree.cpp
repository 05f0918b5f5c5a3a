#include <embree3/rtcore.h>

#include <cmath>
#include <limits>

#include "bench/collision/closest_point.hpp"
#include "framework/core/check.hpp"
#include "nodes/physics/geometry/triangle.hpp"

namespace tactor::bench {

namespace {

class Embree final : public ClosestPoint {
 public:
  explicit Embree(const TriangleMesh& mesh)
      : mesh_(mesh), device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_)) {
    const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                               3 * sizeof(float), mesh.vertices.size()));
    for (const Vec3& v : mesh.vertices) {
      for (int k = 0; k < 3; ++k) *points++ = static_cast<float>(v[k]);
    }
    auto* corners = static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                                   3 * sizeof(unsigned), mesh.faces.size()));
    for (const auto& f : mesh.faces) {
      for (const int i : f) *corners++ = static_cast<unsigned>(i);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    rtcCommitScene(scene_);
    TACTOR_DEMAND(rtcGetDeviceError(device_) == RTC_ERROR_NONE);
  }
  ~Embree() override {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  Embree(const Embree&) = delete;
  Embree& operator=(const Embree&) = delete;

  double distance(const Vec3& x) override {
    Search search{mesh_, x, std::numeric_limits<double>::infinity()};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    RTCPointQuery query{static_cast<float>(x.x), static_cast<float>(x.y), static_cast<float>(x.z), 0,
                        std::numeric_limits<float>::infinity()};
    rtcPointQuery(scene_, &query, &context, look, &search);
    return std::sqrt(search.squared);
  }

 private:
  struct Search {
    const TriangleMesh& mesh;
    Vec3 x;
    double squared;  // m^2, of the nearest triangle so far
  };

  /// Looks at one triangle and narrows the search.
  static bool look(RTCPointQueryFunctionArguments* arguments) {
    auto& search = *static_cast<Search*>(arguments->userPtr);
    const auto& f = search.mesh.faces[arguments->primID];
    const auto corner = [&](std::size_t i) -> const Vec3& {
      return search.mesh.vertices[static_cast<std::size_t>(f[i])];
    };
    const Vec3 away = search.x - nearest_on({corner(0), corner(1), corner(2)}, search.x).p;
    const double squared = dot(away, away);
    if (squared >= search.squared) return false;
    search.squared = squared;
    arguments->query->radius = static_cast<float>(std::sqrt(squared));
    return true;
  }

  const TriangleMesh& mesh_;
  RTCDevice device_;
  RTCScene scene_;
};

}  // namespace

std::unique_ptr<ClosestPoint> make_embree(const TriangleMesh& mesh) {
  return std::make_unique<Embree>(mesh);
}

}  // namespace tactor::bench
