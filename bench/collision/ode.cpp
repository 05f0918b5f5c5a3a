#include <ode/ode.h>

#include <algorithm>
#include <cstdarg>

#include "bench/collision/peers.hpp"
#include "framework/core/check.hpp"

namespace tactor::bench {

namespace {

class Mesh {
 public:
  explicit Mesh(const TriangleMesh& mesh) : data_(dGeomTriMeshDataCreate()) {
    for (const Vec3& v : mesh.vertices) points_.insert(points_.end(), {v.x, v.y, v.z});
    for (const auto& f : mesh.faces) {
      for (const int i : f) corners_.push_back(static_cast<dTriIndex>(i));
    }
    // The data are not copied.
    dGeomTriMeshDataBuildDouble(data_, points_.data(), 3 * sizeof(double), static_cast<int>(mesh.vertices.size()),
                                corners_.data(), static_cast<int>(corners_.size()), 3 * sizeof(dTriIndex));
    geom_ = dCreateTriMesh(nullptr, data_, nullptr, nullptr, nullptr);
  }
  ~Mesh() {
    dGeomDestroy(geom_);
    dGeomTriMeshDataDestroy(data_);
  }
  Mesh(const Mesh&) = delete;
  Mesh& operator=(const Mesh&) = delete;

  [[nodiscard]] dGeomID geom() const { return geom_; }

 private:
  std::vector<double> points_;
  std::vector<dTriIndex> corners_;
  dTriMeshDataID data_;
  dGeomID geom_;
};

/// The library is brought up once a process.
void start() {
  static const bool started = [] {
    TACTOR_DEMAND(dCheckConfiguration("ODE_double_precision") == 1);
    // Where contacts are dense it says in every query that it could not merge all of them; writing that would be timed.
    dSetMessageHandler([](int, const char*, va_list) {});
    return dInitODE2(0) != 0 && dAllocateODEDataForThread(dAllocateMaskAll) != 0;
  }();
  TACTOR_DEMAND(started);
}

class Ode final : public Contender {
 public:
  Ode(const Pair& pair, int contacts)
      : fixed_(pair.fixed.mesh), tool_(pair.tool.mesh), contacts_(static_cast<std::size_t>(contacts)) {}

  void query(const Step& step) override {
    const Pose& X = step.X_AB;
    if (count_ >= 0) dGeomTriMeshSetLastTransform(tool_.geom(), last_);
    const dQuaternion q = {X.R.w, X.R.x, X.R.y, X.R.z};
    dGeomSetPosition(tool_.geom(), X.p.x, X.p.y, X.p.z);
    dGeomSetQuaternion(tool_.geom(), q);
    count_ = dCollide(tool_.geom(), fixed_.geom(), static_cast<int>(contacts_.size()), contacts_.data(),
                      sizeof(dContactGeom));
    remember();
  }
  [[nodiscard]] bool touching() const override { return count_ > 0; }
  [[nodiscard]] Touches touches() const override {
    Touches found;
    for (int i = 0; i < count_; ++i) {
      const dContactGeom& c = contacts_[static_cast<std::size_t>(i)];
      // Moving the first body, which is the tool, along the normal reduces the depth.
      found.push_back({{c.pos[0], c.pos[1], c.pos[2]}, {c.normal[0], c.normal[1], c.normal[2]}, c.depth});
    }
    return found;
  }

 private:
  void remember() {
    const dReal* p = dGeomGetPosition(tool_.geom());
    const dReal* R = dGeomGetRotation(tool_.geom());
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) last_[4 * column + row] = R[4 * row + column];
      last_[12 + row] = p[row];
      last_[4 * row + 3] = 0;
    }
    last_[15] = 1;
  }

  Mesh fixed_, tool_;
  std::vector<dContactGeom> contacts_;
  dMatrix4 last_ = {};
  int count_ = -1;
};

}  // namespace

std::unique_ptr<Contender> make_ode(const Pair& pair, int contacts) {
  start();
  return std::make_unique<Ode>(pair, contacts);
}

}  // namespace tactor::bench
