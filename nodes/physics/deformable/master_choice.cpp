#include "nodes/physics/deformable/master_choice.hpp"

#include <algorithm>

#include "nodes/physics/deformable/spread_nodes.hpp"

namespace tactor {

MasterChoice::MasterChoice(const SoftScene& soft, const PatchChoice& patch, int far_nodes)
    : soft_(soft),
      patch_(patch),
      most_far_(static_cast<std::size_t>(far_nodes)),
      spread_(spread_nodes(soft, far_nodes + LocalPatch::capacity)) {}

bool MasterChoice::update() {
  if (is_chosen_ && chosen_for_ == patch_.nodes() && free_ == patch_.around_tool()) return false;
  is_chosen_ = true;
  chosen_for_ = patch_.nodes();
  free_ = patch_.around_tool();
  nodes_.assign(chosen_for_.end() - static_cast<std::ptrdiff_t>(free_), chosen_for_.end());
  choose_far_nodes();
  masters_.insert(masters_.end(), nodes_.begin(), nodes_.end());
  choose_faces();
  return true;
}

/// Takes nodes far from the tool, of those bodies in turn that have some around it.
void MasterChoice::choose_far_nodes() {
  const ElasticModel& model = soft_.model;
  std::vector<char> touched(model.bodies().size(), 0);
  for (const int node : nodes_) touched[static_cast<std::size_t>(model.body_of(model.unknown_of(node)))] = 1;
  const std::size_t most = std::min(most_far_, static_cast<std::size_t>(LocalPatch::most_modes / 3) - free_);
  masters_.clear();
  for (std::size_t k = 0; k < most_far_ + LocalPatch::capacity; ++k) {
    for (std::size_t b = 0; b < spread_.size(); ++b) {
      if (touched[b] == 0 || k >= spread_[b].size() || masters_.size() >= most) continue;
      if (patch_.place_of(spread_[b][k]) < 0) masters_.push_back(spread_[b][k]);
    }
  }
}

/// Takes the faces between nodes around the tool and nodes that do not move, and these nodes.
void MasterChoice::choose_faces() {
  faces_.clear();
  const std::size_t others = chosen_for_.size() - free_;
  const auto place = [&](int node) -> std::int32_t {
    if (soft_.model.unknown_of(node) >= 0) {
      const int at = patch_.place_of(node);
      return at < static_cast<int>(others) ? -1 : static_cast<std::int32_t>(static_cast<std::size_t>(at) - others);
    }
    const auto fixed = std::find(nodes_.begin() + static_cast<std::ptrdiff_t>(free_), nodes_.end(), node);
    if (fixed == nodes_.end()) {
      if (nodes_.size() == LocalPatch::most_nodes) return -1;
      nodes_.push_back(node);
      return static_cast<std::int32_t>(nodes_.size() - 1);
    }
    return static_cast<std::int32_t>(fixed - nodes_.begin());
  };
  for (std::size_t f = 0; f < soft_.surface.faces.size() && faces_.size() < LocalPatch::most_faces; ++f) {
    const auto& face = soft_.surface.faces[f];
    // A face between fixed nodes alone says nothing of the patch.
    const bool near = std::any_of(face.begin(), face.end(),
                                  [&](int node) { return patch_.place_of(node) >= static_cast<int>(others); });
    if (!near) continue;
    const auto known = [&](int node) {
      return soft_.model.unknown_of(node) < 0 || patch_.place_of(node) >= static_cast<int>(others);
    };
    if (!std::all_of(face.begin(), face.end(), known)) continue;
    PatchFace one{.node = {place(face[0]), place(face[1]), place(face[2])},
                  .body = soft_.surface.body[f],
                  .area = soft_.surface.area[f]};
    if (std::all_of(one.node.begin(), one.node.end(), [](std::int32_t n) { return n >= 0; })) faces_.push_back(one);
  }
}

std::vector<Eigen::Index> MasterChoice::of_body(std::size_t body) const {
  std::vector<Eigen::Index> own;
  for (std::size_t i = 0; i < masters_.size(); ++i) {
    if (soft_.model.body_of(soft_.model.unknown_of(masters_[i])) == static_cast<int>(body))
      own.push_back(static_cast<Eigen::Index>(i));
  }
  return own;
}

std::vector<int> MasterChoice::last_nodes() const {
  std::vector<int> last;
  for (std::size_t i = 0; i < chosen_for_.size() - free_; ++i) {
    last.push_back(soft_.model.unknown_of(chosen_for_[i]) / 3);
  }
  for (const int node : masters_) last.push_back(soft_.model.unknown_of(node) / 3);
  return last;
}

}  // namespace tactor
