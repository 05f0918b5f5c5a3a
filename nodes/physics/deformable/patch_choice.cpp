#include "nodes/physics/deformable/patch_choice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nodes/physics/mechanics/rigid_step.hpp"

namespace tactor {

namespace {

constexpr double beyond = std::numeric_limits<double>::infinity();  // m

}  // namespace

PatchChoice::PatchChoice(const SoftScene& soft, const ContactBody& tool, const PatchChoiceOptions& options)
    : soft_(soft),
      tool_(tool),
      options_(options),
      distance_(static_cast<std::size_t>(soft.model.nodes()), beyond),
      place_(static_cast<std::size_t>(soft.model.nodes()), -1) {
  near_.reserve(soft.surface_nodes.size());
}

/// m, from the tool on its way to the point p.
double PatchChoice::distance_of(const Vec3& p, const Pose& X_WT, const Twist& V_WT) const {
  const Vec3 way = options_.horizon * V_WT.v;
  const Vec3 middle = transform(X_WT, tool_.p_BM);
  const double length = dot(way, way);
  // The place on the way that passes nearest, by the middle of the tool.
  const double share = length > 0 ? std::clamp(dot(p - middle, way) / length, 0.0, 1.0) : 0;
  const Vec3 from = p - share * way;
  const double reach = options_.reach + tool_.radius;
  const Vec3 apart = from - middle;
  if (dot(apart, apart) > reach * reach) return beyond;
  return tool_.distance->nearest(rotate(inverse(X_WT.R), from - X_WT.p)).distance;
}

/// Fills near_ with the free surface nodes that the tool touches or that are within reach of its way.
void PatchChoice::look_around(const Eigen::VectorXd& x, const Pose& X_WT, const Twist& V_WT,
                              std::span<const SoftContact> contacts) {
  std::fill(distance_.begin(), distance_.end(), beyond);
  const auto at = [&x](int node) {
    const auto i = static_cast<Eigen::Index>(3 * node);
    return Vec3{x[i], x[i + 1], x[i + 2]};
  };
  const auto bring_near = [this](int node, double distance) {
    double& nearest = distance_[static_cast<std::size_t>(node)];
    nearest = std::min(nearest, distance);
  };
  for (const SoftContact& contact : contacts) {
    if (contact.body != 0) continue;
    for (const std::int32_t node : contact.node) bring_near(node, contact.contact.distance);
  }
  for (const auto& face : soft_.surface.faces) {
    const double distance = distance_of((1.0 / 3) * (at(face[0]) + at(face[1]) + at(face[2])), X_WT, V_WT);
    for (const std::int32_t node : face) bring_near(node, distance);
  }
  near_.clear();
  for (const int node : soft_.surface_nodes) {
    if (soft_.model.unknown_of(node) < 0) continue;
    bring_near(node, distance_of(at(node), X_WT, V_WT));
    const double distance = distance_[static_cast<std::size_t>(node)];
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
  look_around(x, X_WT, V_WT, contacts);
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
