// Which nodes of deforming surfaces a step keeps at hand: those around the tool, and those that other bodies touch.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "nodes/physics/contact/contact_body.hpp"
#include "nodes/physics/contact/soft_contact.hpp"
#include "nodes/physics/deformable/deformable_options.hpp"
#include "nodes/physics/deformable/soft_scene.hpp"

namespace tactor {

/// The patch of a tool: the free surface nodes nearest to it, where it is and where its velocity takes it within the
/// horizon. They are twice as many as those nearer than a twentieth of the reach, 16 at least and patch_nodes at most:
/// what a large tool touches needs more of them, and each costs time. A node is as near as the middle of any of its
/// faces, and as any contact of the tool there: a large face that is touched in its middle is kept whole, also where
/// the tool touches at two places. The patch stays as it is while it has the nearest two thirds of them, because
/// another one costs a new order of elimination. Before them stand nodes that contacts of other bodies touch.
class PatchChoice {
 public:
  PatchChoice(const SoftScene& soft, const ContactBody& tool, const DeformableOptions& options);

  /// Chooses anew where the one before does not do; true where it changed. `x`: m, of the model's nodes. `contacts`:
  /// those that are expected, in the model's nodes.
  bool update(const Eigen::VectorXd& x, const Pose& X_WT, const Twist& V_WT, std::span<const SoftContact> contacts);

  /// s, for how long the tool's way counts, from the next `update` on.
  void set_horizon(double horizon) { horizon_ = horizon; }
  /// s, until it is set.
  static constexpr double first_horizon = 0.03;

  /// Nodes of the model, all free: those that only others touch, then those around the tool.
  [[nodiscard]] const std::vector<int>& nodes() const { return nodes_; }
  /// The same as a SparseFactor numbers them: the nodes to eliminate last.
  [[nodiscard]] std::vector<int> last_nodes() const;
  /// How many of them are around the tool.
  [[nodiscard]] std::size_t around_tool() const { return around_tool_; }
  /// The place of a node of the model among them; -1 where it is not.
  [[nodiscard]] int place_of(int node) const { return place_[static_cast<std::size_t>(node)]; }

 private:
  struct Near {
    double distance;  // m
    int node;
    bool operator<(const Near& other) const {
      return distance != other.distance ? distance < other.distance : node < other.node;
    }
  };
  /// A free surface node or the middle of a face.
  struct Candidate {
    double bound;  // m, which its distance is not below
    Vec3 p_T;      // m, where it passes the tool
    std::array<std::int32_t, 3> node;
    bool operator<(const Candidate& other) const { return bound > other.bound; }  // the least on top of a heap
  };
  void look_for_candidates(const Eigen::VectorXd& x, const Pose& X_WT, const Twist& V_WT);
  void look_around(const Eigen::VectorXd& x, const Pose& X_WT, const Twist& V_WT,
                   std::span<const SoftContact> contacts);
  [[nodiscard]] bool serves(std::span<const SoftContact> contacts) const;

  const SoftScene& soft_;
  const ContactBody& tool_;
  std::size_t most_nodes_;
  double reach_, horizon_ = first_horizon;  // m, s
  std::vector<Near> near_;
  std::vector<Candidate> candidates_;
  std::vector<double> distance_;  // m, of each node, as far as it is known
  std::vector<int> known_;        // nodes whose distance is known and below the reach
  std::vector<int> nodes_, place_;
  std::size_t around_tool_ = 0;
};

}  // namespace tactor
