#include <algorithm>

#include "bench/collision/ours.hpp"
#include "nodes/collision/sdf.hpp"
#include "nodes/scene/mass_properties.hpp"
#include "tests/nodes/defaults.hpp"

namespace tactor::bench {

namespace {

class SdfNode final : public Contender {
 public:
  SdfNode(const Pair& pair, const MeshFiles& files, std::optional<double> margin, std::optional<double> spacing)
      : p_BT_(mass_properties(pair.tool.mesh).center) {
    tactor::Body fixed;
    fixed.name = "fixed body";
    fixed.shape = MeshShape{files.fixed};
    tactor::Body tool;
    tool.name = "tool";
    tool.shape = MeshShape{files.tool};
    tool.motion = Motion::rigid;
    scene_.bodies = {fixed, tool};
    auto params = test::default_params<SdfCollision>();
    params.margin = margin.value_or(params.margin);
    params.spacing = spacing.value_or(params.spacing);
    node_ = std::make_unique<SdfCollision>(params, NodeContext{.name = "collision", .scene = &scene_});
  }

  void query(const Step& step) override {
    step_ = &step;
    // The node's tool has its origin at the centre of mass.
    X_AT_ = {transform(step.X_AB, p_BT_), step.X_AB.R};
    node_->query(X_AT_, found_);
  }
  [[nodiscard]] bool touching() const override { return found_.penetrating > 0; }

  /// A contact does not tell which body's sample it is. The reference's sample at either of its two points tells.
  [[nodiscard]] Touches touches() const override {
    Touches touches;
    for (int i = 0; i < found_.count; ++i) {
      const Contact& c = found_.contact[static_cast<std::size_t>(i)];
      const Vec3 on_tool = transform(X_AT_, c.p_TC);
      Touch touch{on_tool, c.n_W, -c.distance};
      for (const Touch& e : step_->exact) {
        const Vec3& own = e.side == Side::tool ? on_tool : c.p_WC;
        if (norm(e.p_A - own) > 1e-9) continue;
        touch.p_A = own;
        touch.side = e.side;
        touch.sample = e.sample;
      }
      touches.push_back(touch);
    }
    return touches;
  }

 private:
  Vec3 p_BT_;  // m
  Scene scene_;
  std::unique_ptr<SdfCollision> node_;
  const Step* step_ = nullptr;
  Pose X_AT_;
  ContactSet found_;
};

}  // namespace

std::unique_ptr<Contender> make_sdf_node(const Pair& pair, const MeshFiles& files, std::optional<double> margin,
                                         std::optional<double> spacing) {
  return std::make_unique<SdfNode>(pair, files, margin, spacing);
}

}  // namespace tactor::bench
