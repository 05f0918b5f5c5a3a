// A mesh as FCL wants it.
#pragma once

#include <fcl/geometry/bvh/BVH_model.h>

#include "nodes/physics/mesh/mesh.hpp"

namespace tactor::bench {

template <class S>
using FclModel = fcl::BVHModel<fcl::OBBRSS<S>>;

template <class S>
void fill_fcl_model(const TriangleMesh& mesh, FclModel<S>& model) {
  std::vector<fcl::Vector3<S>> points;
  for (const Vec3& v : mesh.vertices) {
    points.emplace_back(static_cast<S>(v.x), static_cast<S>(v.y), static_cast<S>(v.z));
  }
  std::vector<fcl::Triangle> triangles;
  const auto index = [](int i) { return static_cast<std::size_t>(i); };
  for (const auto& f : mesh.faces) triangles.emplace_back(index(f[0]), index(f[1]), index(f[2]));
  model.beginModel(static_cast<int>(triangles.size()), static_cast<int>(points.size()));
  model.addSubModel(points, triangles);
  model.endModel();
}

}  // namespace tactor::bench
