#include <fcl/narrowphase/detail/collision_func_matrix.h>

#include "bench/collision/fcl_model.hpp"
#include "bench/collision/peers.hpp"

namespace tactor::bench {

namespace {

template <class S>
class Fcl final : public Contender {
 public:
  Fcl(const Pair& pair, std::size_t contacts) : request_(contacts == 0 ? 1 : contacts, contacts > 0) {
    fill_fcl_model(pair.fixed.mesh, fixed_);
    fill_fcl_model(pair.tool.mesh, tool_);
  }

  void query(const Step& step) override {
    const Pose& X = step.X_AB;
    fcl::Transform3<S> pose = fcl::Transform3<S>::Identity();
    pose.linear() = Eigen::Quaterniond(X.R.w, X.R.x, X.R.y, X.R.z).toRotationMatrix().template cast<S>();
    pose.translation() = Eigen::Vector3d(X.p.x, X.p.y, X.p.z).template cast<S>();
    result_.clear();
    // What fcl::collide calls for two such meshes. It would compile every other pair of shapes too: its library holds
    // them for double alone.
    fcl::detail::orientedMeshCollide<fcl::detail::MeshCollisionTraversalNodeOBBRSS<S>, fcl::OBBRSS<S>>(
        &fixed_, fcl::Transform3<S>::Identity(), &tool_, pose, request_, result_);
  }
  [[nodiscard]] bool touching() const override { return result_.isCollision(); }
  [[nodiscard]] Touches touches() const override {
    Touches found;
    for (std::size_t i = 0; i < result_.numContacts() && request_.enable_contact; ++i) {
      const fcl::Contact<S>& c = result_.getContact(i);
      // Its normal points from the first body to the second, which is the tool.
      found.push_back({vector(c.pos), vector(c.normal), static_cast<double>(c.penetration_depth)});
    }
    return found;
  }

 private:
  static Vec3 vector(const fcl::Vector3<S>& v) {
    return {static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
  }

  FclModel<S> fixed_, tool_;
  fcl::CollisionRequest<S> request_;
  fcl::CollisionResult<S> result_;
};

}  // namespace

std::unique_ptr<Contender> make_fcl(const Pair& pair, Precision precision, std::size_t contacts) {
  if (precision == Precision::double_precision) return std::make_unique<Fcl<double>>(pair, contacts);
  return std::make_unique<Fcl<float>>(pair, contacts);
}

}  // namespace tactor::bench
