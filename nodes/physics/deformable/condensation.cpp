#include "nodes/physics/deformable/condensation.hpp"

#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "nodes/physics/mechanics/eigen.hpp"

namespace tactor {

namespace {

// s_0 and s_1 over that of the fastest modes of all bodies: below the slowest ones, unless bodies differ by more than a
// thousand times in stiffness, and far above what rounding leaves.
constexpr double balance = 1e-7, slow = 1e-6;

}  // namespace

Condensation::Condensation(const DeformableStep& step, std::size_t results)
    : step_(step),
      choice_(step.soft(), step.patch(), step.options().patch_far_nodes),
      factor_(make_factor(step.options().solver, step.soft().model.elements())),
      solved_(step.soft().model.unknowns()),
      node_pool_(results, LocalPatch::most_nodes),
      face_pool_(results, LocalPatch::most_faces),
      mode_pool_(results, LocalPatch::most_modes),
      shape_pool_(results, static_cast<std::size_t>(3 * LocalPatch::most_nodes * LocalPatch::most_modes)) {}

std::optional<LocalPatch> Condensation::condense() {
  if (step_.counts().steps == 0) return LocalPatch{};
  const ElasticModel& model = step_.soft().model;
  model.assemble(step_.x(), ElasticModel::Tangent::mean, K_, force_);
  if (!make_modes()) {
    // Pressed hard, a body may be about to buckle. By the warped stiffness it never is.
    model.assemble(step_.x(), ElasticModel::Tangent::warped, K_, force_);
    if (!make_modes()) return std::nullopt;
  }
  return choice_.free() == 0 ? LocalPatch{} : patch_of_modes();
}

/// Makes the modes of K_. False where it or the mass is not positive definite.
bool Condensation::make_modes() {
  const ElasticModel& model = step_.soft().model;
  if (A_.rows() == 0) A_ = K_;
  if (choice_.update()) factor_->analyze(A_, choice_.last_nodes());
  if (choice_.free() == 0) return true;
  // The factor in balance comes last, because forces are balanced by it.
  const double fastest = K_.diagonal().sum() / model.mass().diagonal().sum();
  const double s0 = balance * fastest, s1 = slow * fastest;
  const bool is_kept = mass_.turn(choice_, model.bodies().size(), step_.x());
  if ((!is_kept && !condense_at(s1, slow_)) || !condense_at(s0, static_)) return false;
  if (!is_kept) mass_.make((slow_ - static_) / (s1 - s0), choice_, step_.x());
  return make_modes_by_body(s0);
}

/// Sets `schur` to A(s) on the masters. False where K + s M is not positive definite.
bool Condensation::condense_at(double s, Eigen::MatrixXd& schur) {
  const Eigen::SparseMatrix<double>& M = step_.soft().model.mass();
  for (Eigen::Index i = 0; i < A_.nonZeros(); ++i) A_.valuePtr()[i] = K_.valuePtr()[i] + s * M.valuePtr()[i];
  ++factors_;
  if (!factor_->factor(A_)) return false;
  factor_->schur(schur);
  reduce(schur);
  return true;
}

/// From the Schur complement on all last nodes to that on the masters, which come last.
void Condensation::reduce(Eigen::MatrixXd& schur) const {
  const Eigen::Index kept = choice_.dofs();
  if (schur.rows() == kept) return;
  const Eigen::LLT<Eigen::MatrixXd> factors(schur);
  const Eigen::MatrixXd L = factors.matrixL();
  const Eigen::MatrixXd last = L.bottomRightCorner(kept, kept);
  schur = last.triangularView<Eigen::Lower>() * last.transpose();
}

/// Bodies do not act on each other here. Modes of all together would mix bodies whose modes are equally fast, and with
/// them their damping.
bool Condensation::make_modes_by_body(double s0) {
  const ElasticModel& model = step_.soft().model;
  const Eigen::Index dofs = choice_.dofs();
  shapes_.setZero(dofs, dofs);
  square_.resize(dofs);
  damping_.resize(dofs);
  Eigen::Index made = 0;
  std::vector<Eigen::Index> own;
  for (std::size_t b = 0; b < model.bodies().size(); ++b) {
    own.clear();
    for (const Eigen::Index i : choice_.of_body(b)) {
      for (Eigen::Index c = 0; c < 3; ++c) own.push_back(3 * i + c);
    }
    if (own.empty()) continue;
    const Eigen::MatrixXd mass = mass_.mass()(own, own);
    // The solver does not tell where it is not positive definite.
    if (Eigen::LLT<Eigen::MatrixXd>(mass).info() != Eigen::Success) return false;
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(static_(own, own), mass);
    if (modes.info() != Eigen::Success || !modes.eigenvectors().allFinite()) return false;
    const auto count = static_cast<Eigen::Index>(own.size());
    shapes_(own, Eigen::seqN(made, count)) = modes.eigenvectors();
    square_.segment(made, count) = (modes.eigenvalues().array() - s0).max(0.0);
    damping_.segment(made, count) =
        model.bodies()[b].drag + model.bodies()[b].damping * square_.segment(made, count).array();
    made += count;
  }
  return true;
}

/// By mode, sqrt(kg) m/s^2: what the masters feel of a force (N) on all unknowns.
Eigen::VectorXd Condensation::on_modes(const Eigen::VectorXd& force) {
  const std::vector<int>& masters = choice_.masters();
  solved_ = force;
  factor_->solve(solved_);
  Eigen::VectorXd moved(choice_.dofs()), felt(choice_.dofs());
  for (std::size_t i = 0; i < masters.size(); ++i) {
    moved.segment<3>(static_cast<Eigen::Index>(3 * i)) = solved_.segment<3>(step_.soft().model.unknown_of(masters[i]));
  }
  felt.noalias() = static_ * moved;
  return shapes_.transpose() * felt;
}

/// None where readers hold all arrays.
std::optional<LocalPatch> Condensation::patch_of_modes() {
  const ElasticModel& model = step_.soft().model;
  const std::vector<int>& told = choice_.nodes();
  const auto modes_count = static_cast<std::size_t>(choice_.dofs());
  const auto shapes = shape_pool_.make(3 * told.size() * modes_count, [&](std::span<double> to) {
    const auto moving = static_cast<Eigen::Index>(3 * choice_.free());
    Eigen::Map<Eigen::MatrixXd> all(to.data(), static_cast<Eigen::Index>(3 * told.size()), shapes_.cols());
    all.topRows(moving) = shapes_.bottomRows(moving);
    all.bottomRows(all.rows() - moving).setZero();
  });
  const auto faces = face_pool_.copy(choice_.faces());
  const auto nodes = node_pool_.make(told.size(), [&](std::span<PatchNode> to) {
    for (std::size_t i = 0; i < told.size(); ++i) {
      const int u = model.unknown_of(told[i]);
      to[i] = {plain(step_.x().segment<3>(3 * told[i])), u < 0 ? Vec3{} : plain(step_.v().segment<3>(u)),
               u < 0 ? 1 : 0};
    }
  });
  const Eigen::VectorXd rates = on_modes(model.mass().selfadjointView<Eigen::Lower>() * step_.v());
  const Eigen::VectorXd forces = on_modes(step_.inner_force());
  const auto modes = mode_pool_.make(modes_count, [&](std::span<PatchMode> to) {
    for (std::size_t i = 0; i < to.size(); ++i) {
      const auto m = static_cast<Eigen::Index>(i);
      to[i] = {.stiffness = square_[m], .damping = damping_[m], .force = forces[m], .z = 0, .rate = rates[m]};
    }
  });
  if (!shapes || !faces || !nodes || !modes) return std::nullopt;
  LocalPatch patch;
  patch.shapes = *shapes;
  patch.faces = *faces;
  patch.nodes = *nodes;
  patch.modes = *modes;
  return patch;
}

}  // namespace tactor
