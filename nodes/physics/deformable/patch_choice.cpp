#include "nodes/physics/deformable/patch_choice.hpp"

#include <algorithm>
#include <cmath>

#include "nodes/physics/mechanics/rigid_step.hpp"

namespace tactor {

PatchChoice::PatchChoice(const SoftScene& soft, const ContactBody& tool, const PatchChoiceOptions& options)
    : soft_(soft), tool_(tool), options_(options), place_(static_cast<std::size_t>(soft.model.nodes()), -1) {
  near_.reserve(soft.surface_nodes.size());
}

/// Fills near_ with the free surface nodes within reach of the tool's way.
void PatchChoice::look_around(const Eigen::VectorXd& x, const Pose& X_WT, const Twist& V_WT) {
  const Vec3 way = options_.horizon * V_WT.v;
  const Vec3 middle = transform(X_WT, tool_.p_BM);
  const double reach = options_.reach + tool_.radius;
  const double length = dot(way, way);
  near_.clear();
  for (const int node : soft_.surface_nodes) {
    if (soft_.model.unknown_of(node) < 0) continue;
    const auto at = static_cast<Eigen::Index>(3 * node);
    const Vec3 p{x[at], x[at + 1], x[at + 2]};
    // The place on the way that passes nearest, by the middle of the tool.
    const double share = length > 0 ? std::clamp(dot(p - middle, way) / length, 0.0, 1.0) : 0;
    const Vec3 from = p - share * way;
    const Vec3 apart = from - middle;
    if (dot(apart, apart) > reach * reach) continue;
    const double distance = tool_.distance->nearest(rotate(inverse(X_WT.R), from - X_WT.p)).distance;
    if (distance < options_.reach) near_.push_back({distance, node});
  }
  const auto kept = std::min(near_.size(), static_cast<std::size_t>(options_.nodes));
  std::partial_sort(near_.begin(), near_.begin() + static_cast<std::ptrdiff_t>(kept), near_.end());
  near_.resize(kept);
}

bool PatchChoice::serves(std::span<const SoftContact> contacts) const {
  const std::size_t others = nodes_.size() - around_tool_;
  const std::size_t needed =
      near_.size() < static_cast<std::size_t>(options_.nodes) ? near_.size() : 2 * near_.size() / 3;
  for (std::size_t i = 0; i < needed; ++i) {
    const int place = place_of(near_[i].node);
    if (place < 0 || static_cast<std::size_t>(place) < others) return false;
  }
  for (const SoftContact& contact : contacts) {
    for (const std::int32_t node : contact.node) {
      if (soft_.model.unknown_of(node) >= 0 && place_of(node) < 0 && nodes_.size() < RigidStep::most_patch_nodes) {
        return false;
      }
    }
  }
  return true;
}

std::vector<int> PatchChoice::last_nodes() const {
  std::vector<int> last;
  for (const int node : nodes_) last.push_back(soft_.model.unknown_of(node) / 3);
  return last;
}

bool PatchChoice::update(const Eigen::VectorXd& x, const Pose& X_WT, const Twist& V_WT,
                         std::span<const SoftContact> contacts) {
  look_around(x, X_WT, V_WT);
  if (serves(contacts)) return false;
  for (const int node : nodes_) place_[static_cast<std::size_t>(node)] = -1;
  nodes_.clear();
  constexpr int around = -2;
  for (const Near& near : near_) place_[static_cast<std::size_t>(near.node)] = around;
  const std::size_t most_others = RigidStep::most_patch_nodes - near_.size();
  for (const SoftContact& contact : contacts) {
    for (const std::int32_t node : contact.node) {
      int& place = place_[static_cast<std::size_t>(node)];
      if (place != -1 || soft_.model.unknown_of(node) < 0 || nodes_.size() == most_others) continue;
      place = static_cast<int>(nodes_.size());
      nodes_.push_back(node);
    }
  }
  around_tool_ = near_.size();
  for (const Near& near : near_) {
    place_[static_cast<std::size_t>(near.node)] = static_cast<int>(nodes_.size());
    nodes_.push_back(near.node);
  }
  return true;
}

}  // namespace tactor
