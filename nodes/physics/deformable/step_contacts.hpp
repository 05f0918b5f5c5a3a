// The contacts of rigid bodies with the nodes of a step, and where they were found.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "nodes/physics/contact/soft_contacts.hpp"
#include "nodes/physics/deformable/elastic_model.hpp"

namespace tactor {

/// The bodies at that share of their way from start to end, with the velocities of the start.
BodyStates on_the_way(const BodyStates& start, const BodyStates& end, double share);

/// The contacts that a step goes by. Places of nodes: m, of all nodes of the model.
class StepContacts {
 public:
  /// `contacts` must outlive it. `tool_radius`: m.
  StepContacts(const ElasticModel& model, SoftContacts& contacts, double tool_radius);

  /// Finds them with the nodes at x.
  void find(const Eigen::VectorXd& x, const BodyStates& bodies);
  /// The same; false, and nothing is done, where the last search was this one.
  bool refresh(const Eigen::VectorXd& x, const BodyStates& bodies);
  /// Where none of them is of the tool: goes along its way, and the nodes' from x0 to x_end, until one is, so that the
  /// step knows what would stop it. True where there is one.
  bool look_ahead(const BodyStates& start, const BodyStates& end, const Eigen::VectorXd& x0,
                  const Eigen::VectorXd& x_end);

  [[nodiscard]] const std::vector<SoftContact>& found() const { return found_; }
  /// Where they were found.
  [[nodiscard]] const Eigen::VectorXd& x() const { return x_; }
  [[nodiscard]] const BodyStates& bodies() const { return bodies_; }

 private:
  void look(const Eigen::VectorXd& x, const BodyStates& bodies, std::vector<SoftContact>& found);

  SoftContacts& contacts_;
  double tool_radius_;  // m
  std::vector<SoftContact> found_, ahead_;
  Eigen::VectorXd x_, x_ahead_;
  BodyStates bodies_;
  bool is_refreshed_ = false;
  std::vector<Vec3> nodes_W_;
};

}  // namespace tactor
