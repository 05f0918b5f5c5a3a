#include "nodes/physics/deformable/patch_choice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nodes/physics/mechanics/rigid_step.hpp"

namespace tactor {

namespace {

constexpr double about_to_touch = 0.05;                             // of the reach
constexpr std::size_t fewest_nodes = 16;                            // of a patch, where there are as many
constexpr double beyond = std::numeric_limits<double>::infinity();  // m

}  // namespace

PatchChoice::PatchChoice(const SoftScene& soft, const ContactBody& tool, const DeformableOptions& options)
    : soft_(soft),
      tool_(tool),
      most_nodes_(static_cast<std::size_t>(options.patch_nodes)),
      reach_(options.patch_reach),
      distance_(static_cast<std::size_t>(soft.model.nodes()), beyond),
      place_(static_cast<std::size_t>(soft.model.nodes()), -1) {
  near_.reserve(soft.surface_nodes.size());
  known_.reserve(soft.surface_nodes.size());
  candidates_.reserve(soft.surface_nodes.size() + soft.surface.faces.size());
}

/// Fills candidates_ with the free surface nodes and the middles of faces within reach of the tool's way, the one with
/// the least bound of its distance on top of the heap.
void PatchChoice::look_for_candidates(const Eigen::VectorXd& x, const Pose& X_WT, const Twist& V_WT) {
  const Vec3 way = horizon_ * V_WT.v;
  const Vec3 middle = transform(X_WT, tool_.p_BM);
  const double length = dot(way, way);
  const double reach = reach_ + tool_.radius;
  const Quat R_TW = inverse(X_WT.R);
  candidates_.clear();
  const auto add = [&](const Vec3& p, const std::array<std::int32_t, 3>& nodes) {
    // The place on the way that passes nearest, by the middle of the tool.
    const double share = length > 0 ? std::clamp(dot(p - middle, way) / length, 0.0, 1.0) : 0;
    const Vec3 from = p - share * way;
    const Vec3 apart = from - middle;
    if (dot(apart, apart) <= reach * reach) candidates_.push_back({0, rotate(R_TW, from - X_WT.p), nodes});
  };
  const auto at = [&x](int node) {
    const auto i = static_cast<Eigen::Index>(3 * node);
    return Vec3{x[i], x[i + 1], x[i + 2]};
  };
  for (const auto& face : soft_.surface.faces) add((1.0 / 3) * (at(face[0]) + at(face[1]) + at(face[2])), face);
  for (const int node : soft_.surface_nodes) {
    if (soft_.model.unknown_of(node) >= 0) add(at(node), {node, node, node});
  }
  for (std::size_t first = 0; first < candidates_.size(); first += 8) {
    const std::size_t count = std::min<std::size_t>(8, candidates_.size() - first);
    Points8 points{};
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3& p = candidates_[first + i].p_T;
      points.x[i] = static_cast<float>(p.x);
      points.y[i] = static_cast<float>(p.y);
      points.z[i] = static_cast<float>(p.z);
    }
    std::array<float, 8> bound{};
    tool_.distance->lower_bounds(points, (1U << count) - 1U, bound);
    for (std::size_t i = 0; i < count; ++i) candidates_[first + i].bound = static_cast<double>(bound[i]);
  }
  std::make_heap(candidates_.begin(), candidates_.end());
}

/// Fills near_ with the free surface nodes nearest to the tool's way: twice as many as it touches or is about to touch.
void PatchChoice::look_around(const Eigen::VectorXd& x, const Pose& X_WT, const Twist& V_WT,
                              std::span<const SoftContact> contacts) {
  std::fill(distance_.begin(), distance_.end(), beyond);
  known_.clear();
  const auto bring_near = [this](int node, double distance) {
    if (soft_.model.unknown_of(node) < 0 || !(distance < reach_)) return;
    double& nearest = distance_[static_cast<std::size_t>(node)];
    if (nearest == beyond) known_.push_back(node);
    nearest = std::min(nearest, distance);
  };
  for (const SoftContact& contact : contacts) {
    if (contact.body != 0) continue;
    for (const std::int32_t node : contact.node) bring_near(node, contact.contact.distance);
  }
  look_for_candidates(x, X_WT, V_WT);
  const auto wanted = static_cast<std::ptrdiff_t>(most_nodes_);
  // Until as many nodes are known to be nearer than anything that has not been looked at.
  while (!candidates_.empty() && candidates_.front().bound < reach_) {
    std::pop_heap(candidates_.begin(), candidates_.end());
    const Candidate next = candidates_.back();
    candidates_.pop_back();
    const auto nearer = [&](int node) { return distance_[static_cast<std::size_t>(node)] < next.bound; };
    if (std::count_if(known_.begin(), known_.end(), nearer) >= wanted) break;
    const double distance = tool_.distance->nearest(next.p_T).distance;
    for (const std::int32_t node : next.node) bring_near(node, distance);
  }
  near_.clear();
  for (const int node : known_) near_.push_back({distance_[static_cast<std::size_t>(node)], node});
  const auto kept = std::min(near_.size(), most_nodes_);
  std::partial_sort(near_.begin(), near_.begin() + static_cast<std::ptrdiff_t>(kept), near_.end());
  near_.resize(kept);
  // Those that are touched or about to be, and as many around them.
  const auto touched = static_cast<std::size_t>(
      std::count_if(near_.begin(), near_.end(), [&](const Near& n) { return n.distance < about_to_touch * reach_; }));
  near_.resize(std::min(near_.size(), std::max(2 * touched, fewest_nodes)));
}

bool PatchChoice::serves(std::span<const SoftContact> contacts) const {
  const std::size_t others = nodes_.size() - around_tool_;
  if (near_.empty() && around_tool_ > 0) return false;
  const std::size_t few = std::min(fewest_nodes, most_nodes_);
  const std::size_t needed = near_.size() < few ? near_.size() : 2 * near_.size() / 3;
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
