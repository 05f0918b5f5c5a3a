#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include "bench/collision/peers.hpp"

namespace tactor::bench {

namespace {

class Mesh {
 public:
  Mesh(const TriangleMesh& mesh, double unit)
      : points_(points(mesh, unit)),
        corners_(corners(mesh)),
        array_(static_cast<int>(mesh.faces.size()), corners_.data(), 3 * sizeof(int),
               static_cast<int>(mesh.vertices.size()), points_.data(), 3 * sizeof(btScalar)),
        shape_(&array_) {
    shape_.setMargin(0);
    shape_.updateBound();
    object_.setCollisionShape(&shape_);
  }

  btCollisionObject& object() { return object_; }
  btGImpactMeshShape& shape() { return shape_; }

 private:
  static std::vector<btScalar> points(const TriangleMesh& mesh, double unit) {
    std::vector<btScalar> list;
    for (const Vec3& v : mesh.vertices) {
      for (const double x : {v.x, v.y, v.z}) list.push_back(static_cast<btScalar>(x / unit));
    }
    return list;
  }
  static std::vector<int> corners(const TriangleMesh& mesh) {
    std::vector<int> list;
    for (const auto& f : mesh.faces) list.insert(list.end(), f.begin(), f.end());
    return list;
  }

  std::vector<btScalar> points_;
  std::vector<int> corners_;
  btTriangleIndexVertexArray array_;
  btGImpactMeshShape shape_;
  btCollisionObject object_;
};

/// Keeps every contact; Bullet's own result keeps four.
class AllContacts final : public btManifoldResult {
 public:
  struct Point {
    btVector3 normal, point;
    btScalar distance;
  };
  AllContacts(const btCollisionObjectWrapper* tool, const btCollisionObjectWrapper* fixed, std::vector<Point>& found)
      : btManifoldResult(tool, fixed), found_(found) {}
  void addContactPoint(const btVector3& normal, const btVector3& point, btScalar distance) override {
    found_.push_back({normal, point, distance});
  }

 private:
  std::vector<Point>& found_;
};

class GImpact final : public Contender {
 public:
  GImpact(const Pair& pair, double unit)
      : unit_(unit), fixed_(pair.fixed.mesh, unit), tool_(pair.tool.mesh, unit), dispatcher_(&configuration_) {
    btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher_);
  }

  void query(const Step& step) override {
    found_.clear();
    const Pose& X = step.X_AB;
    const auto real = [](double x) { return static_cast<btScalar>(x); };
    tool_.object().setWorldTransform(
        btTransform(btQuaternion(real(X.R.x), real(X.R.y), real(X.R.z), real(X.R.w)),
                    btVector3(real(X.p.x / unit_), real(X.p.y / unit_), real(X.p.z / unit_))));
    const btCollisionObjectWrapper tool(nullptr, &tool_.shape(), &tool_.object(), tool_.object().getWorldTransform(),
                                        -1, -1);
    const btCollisionObjectWrapper fixed(nullptr, &fixed_.shape(), &fixed_.object(),
                                         fixed_.object().getWorldTransform(), -1, -1);
    btCollisionAlgorithm* algorithm = dispatcher_.findAlgorithm(&tool, &fixed, nullptr, BT_CONTACT_POINT_ALGORITHMS);
    AllContacts result(&tool, &fixed, found_);
    algorithm->processCollision(&tool, &fixed, {}, &result);
    algorithm->~btCollisionAlgorithm();
    dispatcher_.freeCollisionAlgorithm(algorithm);
  }
  [[nodiscard]] bool touching() const override { return !found_.empty(); }
  [[nodiscard]] Touches touches() const override {
    Touches touches;
    for (const AllContacts::Point& c : found_) {
      // Its normal is that of the second body, the fixed one; a negative distance is a depth.
      touches.push_back({unit_ * vector(c.point), vector(c.normal), -unit_ * static_cast<double>(c.distance)});
    }
    return touches;
  }

 private:
  static Vec3 vector(const btVector3& v) {
    return {static_cast<double>(v.x()), static_cast<double>(v.y()), static_cast<double>(v.z())};
  }

  double unit_;
  Mesh fixed_, tool_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  std::vector<AllContacts::Point> found_;
};

}  // namespace

std::unique_ptr<Contender> make_gimpact(const Pair& pair, double unit) {
  return std::make_unique<GImpact>(pair, unit);
}

}  // namespace tactor::bench
