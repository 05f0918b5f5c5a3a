// The factor that needs no other library than Eigen.
#pragma once

#include <memory>

#include "nodes/physics/deformable/sparse_factor.hpp"

namespace tactor {

/// Eigen's SimplicialLLT, with the nodes ordered by approximate minimum degree (Amestoy, Davis and Duff, SIMAX 1996).
class EigenFactor final : public SparseFactor {
 public:
  EigenFactor();
  ~EigenFactor() override;

  void analyze(const Eigen::SparseMatrix<double>& A, std::span<const int> last_nodes) override;
  bool factor(const Eigen::SparseMatrix<double>& A) override;
  void solve(Eigen::VectorXd& b) const override;
  void schur(Eigen::MatrixXd& S) const override;
  [[nodiscard]] std::size_t entries() const override;
  [[nodiscard]] double multiplications() const override;
  [[nodiscard]] const char* name() const override { return "Eigen"; }

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tactor
