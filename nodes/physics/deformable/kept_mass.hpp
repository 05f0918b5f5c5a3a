// The mass that a body is condensed to, kept from result to result.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "nodes/physics/deformable/master_choice.hpp"

namespace tactor {

/// The mass of the masters: it turns with those of each body, as long as they stay the same and have moved by no more
/// than a tenth of how far they reach but for turning.
class KeptMass {
 public:
  /// Turns the mass as the masters have turned since it was made, with all nodes at x (m) now. False where it does not
  /// do: then it is to be made.
  bool turn(const MasterChoice& choice, std::size_t bodies, const Eigen::VectorXd& x);
  /// `mass`: kg, of the masters with all nodes at x.
  void make(const Eigen::MatrixXd& mass, const MasterChoice& choice, const Eigen::VectorXd& x);
  /// kg, of the masters now.
  [[nodiscard]] const Eigen::MatrixXd& mass() const { return mass_; }

 private:
  [[nodiscard]] std::optional<Eigen::Matrix3d> turn_of(std::span<const Eigen::Index> own,
                                                       const Eigen::VectorXd& x) const;

  Eigen::MatrixXd mass_, made_;
  std::vector<int> masters_;  // whose mass it is
  Eigen::VectorXd made_x_;    // m, where all nodes were when it was made
};

}  // namespace tactor
