#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "bench/collision/ours.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/core/user_folders.hpp"
#include "nodes/collision/sdf.hpp"
#include "nodes/physics/mesh/mass_properties.hpp"
#include "tests/support/nodes.hpp"

namespace tactor::bench {

namespace {

/// While it lives the cache is an empty folder of its own: what is timed builds what it needs, and does not load what
/// another contender left.
class OwnCache {
 public:
  OwnCache() { set(folder_.path()); }
  ~OwnCache() { set(before_); }
  OwnCache(const OwnCache&) = delete;
  OwnCache& operator=(const OwnCache&) = delete;

 private:
  static void set(const std::filesystem::path& folder) { setenv("TACTOR_CACHE", folder.c_str(), 1); }

  std::filesystem::path before_ = default_cache_folder();
  TemporaryFolder folder_;
};

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
    const OwnCache cache;
    node_ = std::make_unique<SdfCollision>(params, NodeContext{.name = "collision", .scene = &scene_});
  }

  void query(const Step& step) override {
    step_ = &step;
    // The node's tool has its origin at the centre of mass.
    X_AT_ = {transform(step.X_AB, p_BT_), step.X_AB.R};
    node_->query(X_AT_, found_);
  }
  [[nodiscard]] bool touching() const override { return found_.penetrating > 0; }

  /// A contact does not tell which body's sample it is. The reference's sample at either of its two points tells; where
  /// a sample is nearest to another that is inside too, their depths do, and each is taken once.
  [[nodiscard]] Touches touches() const override {
    Touches touches;
    std::vector<bool> taken(step_->exact.size());
    for (int i = 0; i < found_.count; ++i) {
      const Contact& c = found_.contact[static_cast<std::size_t>(i)];
      const Vec3 on_tool = transform(X_AT_, c.p_TC);
      Touch touch{on_tool, c.n_W, -c.distance};
      std::size_t best = taken.size();
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t k = 0; k < taken.size() && touch.depth > 0; ++k) {
        const Touch& e = step_->exact[k];
        if (taken[k] || norm(e.p_A - (e.side == Side::tool ? on_tool : c.p_WC)) > 1e-9) continue;
        if (const double off = std::abs(e.depth - touch.depth); off < least) least = off, best = k;
      }
      if (best < taken.size()) {
        const Touch& e = step_->exact[best];
        taken[best] = true;
        touch.p_A = e.side == Side::tool ? on_tool : c.p_WC;
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
