#include "bench/collision/ours.hpp"

#include <algorithm>

#include "bench/collision/trilinear_distance.hpp"
#include "nodes/physics/cgal/exact_distance.hpp"
#include "nodes/physics/geometry/sample_tree.hpp"
#include "nodes/physics/geometry/triangle.hpp"

namespace tactor::bench {

namespace {

class SampleTrees final : public Contender {
 public:
  using Distance = std::unique_ptr<SignedDistance>;
  SampleTrees(const Pair& pair, double margin, Distance fixed, Distance tool)
      : pair_(pair),
        margin_(margin),
        fixed_(std::move(fixed)),
        tool_(std::move(tool)),
        fixed_tree_(pair.fixed.samples),
        tool_tree_(pair.tool.samples) {}

  void query(const Step& step) override {
    X_AB_ = step.X_AB;
    of_tool_ = &tool_tree_.find(*fixed_, X_AB_, margin_);
    of_fixed_ = &fixed_tree_.find(*tool_, inverse(X_AB_), margin_);
  }
  [[nodiscard]] bool touching() const override {
    const auto inside = [](const NearSample& n) { return n.distance < 0; };
    return std::any_of(of_tool_->begin(), of_tool_->end(), inside) ||
           std::any_of(of_fixed_->begin(), of_fixed_->end(), inside);
  }
  [[nodiscard]] Touches touches() const override {
    Touches found;
    for (const NearSample& n : *of_tool_) {
      const Vec3& p_B = pair_.tool.samples[static_cast<std::size_t>(n.sample)].p;
      found.push_back({transform(X_AB_, p_B), n.nearest.gradient, -n.distance, Side::tool, n.sample});
    }
    for (const NearSample& n : *of_fixed_) {
      const Vec3& p_A = pair_.fixed.samples[static_cast<std::size_t>(n.sample)].p;
      found.push_back({p_A, -rotate(X_AB_.R, n.nearest.gradient), -n.distance, Side::fixed, n.sample});
    }
    return found;
  }

 private:
  const Pair& pair_;
  double margin_;
  Distance fixed_, tool_;
  SampleTree fixed_tree_, tool_tree_;
  const std::vector<NearSample>*of_fixed_ = nullptr, *of_tool_ = nullptr;
  Pose X_AB_;
};

class Floor final : public Contender {
 public:
  explicit Floor(const Pair& pair) : pair_(pair) {}

  void query(const Step& step) override {
    found_.clear();
    const Pose X_BA = inverse(step.X_AB);
    for (const Touch& known : step.exact) {
      const bool of_tool = known.side == Side::tool;
      const Body& own = of_tool ? pair_.tool : pair_.fixed;
      const TriangleMesh& other = of_tool ? pair_.fixed.mesh : pair_.tool.mesh;
      const Vec3& p = own.samples[static_cast<std::size_t>(known.sample)].p;
      const Vec3 x = transform(of_tool ? step.X_AB : X_BA, p);
      const auto& f = other.faces[static_cast<std::size_t>(known.face)];
      const auto corner = [&](std::size_t i) -> const Vec3& { return other.vertices[static_cast<std::size_t>(f[i])]; };
      const Vec3 out = nearest_on({corner(0), corner(1), corner(2)}, x).p - x;
      const double depth = norm(out);
      const Vec3 n = out / depth;
      found_.push_back({of_tool ? x : p, of_tool ? n : -rotate(step.X_AB.R, n), depth, known.side, known.sample});
    }
  }
  [[nodiscard]] bool touching() const override { return !found_.empty(); }
  [[nodiscard]] Touches touches() const override { return found_; }

 private:
  const Pair& pair_;
  Touches found_;
};

}  // namespace

std::unique_ptr<Contender> make_tactor(const Pair& pair, double margin, const CellOptions& options) {
  return std::make_unique<SampleTrees>(pair, margin, std::make_unique<CellDistance>(pair.fixed.mesh, options),
                                       std::make_unique<CellDistance>(pair.tool.mesh, options));
}
std::unique_ptr<Contender> make_exact(const Pair& pair) {
  return std::make_unique<SampleTrees>(pair, 0, std::make_unique<ExactDistance>(pair.fixed.mesh),
                                       std::make_unique<ExactDistance>(pair.tool.mesh));
}
std::unique_ptr<Contender> make_trilinear(const Pair& pair, int cells) {
  return std::make_unique<SampleTrees>(pair, 0, std::make_unique<TrilinearDistance>(pair.fixed.mesh, cells),
                                       std::make_unique<TrilinearDistance>(pair.tool.mesh, cells));
}
std::unique_ptr<Contender> make_floor(const Pair& pair) {
  return std::make_unique<Floor>(pair);
}

}  // namespace tactor::bench
