#include "nodes/physics/deformable/condensation.hpp"

#include <algorithm>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "nodes/physics/mechanics/eigen.hpp"

namespace tactor {

namespace {

// s_0 and s_1 over that of the fastest modes: far below the slowest ones, and far above what rounding leaves.
constexpr double balance = 1e-7, slow = 1e-6;

}  // namespace

Condensation::Condensation(const DeformableStep& step, FactorKind factor, std::size_t results)
    : step_(step),
      factor_(make_factor(factor, step.soft().model.elements())),
      solved_(step.soft().model.unknowns()),
      node_pool_(results, LocalPatch::capacity),
      face_pool_(results, LocalPatch::most_faces),
      mode_pool_(results, 3 * LocalPatch::capacity),
      shape_pool_(results, 9 * LocalPatch::capacity * LocalPatch::capacity) {}

/// Takes the nodes around the tool and the faces between them and nodes that do not move.
void Condensation::choose_nodes() {
  const SoftScene& soft = step_.soft();
  const PatchChoice& patch = step_.patch();
  patch_ = patch.nodes();
  nodes_.assign(patch_.end() - static_cast<std::ptrdiff_t>(patch.around_tool()), patch_.end());
  free_ = nodes_.size();
  faces_.clear();
  const std::size_t others = patch_.size() - free_;
  const auto place = [&](int node) -> std::int32_t {
    if (soft.model.unknown_of(node) >= 0) {
      const int at = patch.place_of(node);
      return at < static_cast<int>(others) ? -1 : static_cast<std::int32_t>(static_cast<std::size_t>(at) - others);
    }
    const auto fixed = std::find(nodes_.begin() + static_cast<std::ptrdiff_t>(free_), nodes_.end(), node);
    if (fixed == nodes_.end()) {
      if (nodes_.size() == LocalPatch::capacity) return -1;
      nodes_.push_back(node);
      return static_cast<std::int32_t>(nodes_.size() - 1);
    }
    return static_cast<std::int32_t>(fixed - nodes_.begin());
  };
  for (std::size_t f = 0; f < soft.surface.faces.size() && faces_.size() < LocalPatch::most_faces; ++f) {
    const auto& face = soft.surface.faces[f];
    // A face between fixed nodes alone says nothing of the patch.
    const bool near = std::any_of(face.begin(), face.end(),
                                  [&](int node) { return patch.place_of(node) >= static_cast<int>(others); });
    if (!near) continue;
    const auto known = [&](int node) {
      return soft.model.unknown_of(node) < 0 || patch.place_of(node) >= static_cast<int>(others);
    };
    if (!std::all_of(face.begin(), face.end(), known)) continue;
    PatchFace one{.node = {place(face[0]), place(face[1]), place(face[2])},
                  .body = soft.surface.body[f],
                  .area = soft.surface.area[f]};
    if (std::all_of(one.node.begin(), one.node.end(), [](std::int32_t n) { return n >= 0; })) faces_.push_back(one);
  }
}

/// From the Schur complement on all last nodes to that on those around the tool, which come last.
void Condensation::reduce(Eigen::MatrixXd& schur) const {
  const auto kept = static_cast<Eigen::Index>(3 * free_);
  if (schur.rows() == kept) return;
  const Eigen::LLT<Eigen::MatrixXd> factors(schur);
  const Eigen::MatrixXd L = factors.matrixL();
  const Eigen::MatrixXd last = L.bottomRightCorner(kept, kept);
  schur = last.triangularView<Eigen::Lower>() * last.transpose();
}

/// Sets on_patch to what the patch feels of a force on all unknowns.
void Condensation::balanced(const Eigen::VectorXd& force, Eigen::VectorXd& on_patch) {
  solved_ = force;
  factor_->solve(solved_);
  Eigen::VectorXd moved(static_cast<Eigen::Index>(3 * free_));
  for (std::size_t i = 0; i < free_; ++i) {
    moved.segment<3>(static_cast<Eigen::Index>(3 * i)) = solved_.segment<3>(step_.soft().model.unknown_of(nodes_[i]));
  }
  on_patch.noalias() = static_ * moved;
}

/// Sets `schur` to A(s) on the patch. False where K + s M is not positive definite.
bool Condensation::condense_at(double s, Eigen::MatrixXd& schur) {
  const Eigen::SparseMatrix<double>& M = step_.soft().model.mass();
  for (Eigen::Index i = 0; i < A_.nonZeros(); ++i) A_.valuePtr()[i] = K_.valuePtr()[i] + s * M.valuePtr()[i];
  ++factors_;
  if (!factor_->factor(A_)) return false;
  factor_->schur(schur);
  reduce(schur);
  return true;
}

/// Sets K_ to the stiffness where the nodes are.
void Condensation::assemble() {
  const ElasticModel& model = step_.soft().model;
  model.assemble(step_.x(), ElasticModel::Tangent::exact, K_, scratch_);
  model.assemble(step_.x(), ElasticModel::Tangent::warped, warped_, scratch_);
  for (Eigen::Index i = 0; i < K_.nonZeros(); ++i) {
    K_.valuePtr()[i] = 0.5 * (K_.valuePtr()[i] + warped_.valuePtr()[i]);
  }
}

/// Makes the modes of K_. False where it or the mass is not positive definite.
bool Condensation::make_modes() {
  const ElasticModel& model = step_.soft().model;
  if (A_.rows() == 0) A_ = K_;
  if (patch_ != step_.patch().nodes() || !is_analysed_) {
    choose_nodes();
    factor_->analyze(A_, step_.patch().last_nodes());
    is_analysed_ = true;
  }
  if (free_ == 0) return true;
  // The factor in balance comes last, because forces are balanced by it.
  const double fastest = K_.diagonal().sum() / model.mass().diagonal().sum();
  const double s0 = balance * fastest, s1 = slow * fastest;
  if (!condense_at(s1, slow_) || !condense_at(s0, static_)) return false;
  mass_ = (slow_ - static_) / (s1 - s0);
  return make_modes_by_body(s0);
}

/// Bodies do not act on each other here. Modes of all together would mix bodies whose modes are equally fast, and with
/// them their damping.
bool Condensation::make_modes_by_body(double s0) {
  const ElasticModel& model = step_.soft().model;
  const auto dofs = static_cast<Eigen::Index>(3 * free_);
  shapes_.setZero(dofs, dofs);
  square_.resize(dofs);
  damping_.resize(dofs);
  Eigen::Index made = 0;
  std::vector<Eigen::Index> own;
  for (std::size_t b = 0; b < model.bodies().size(); ++b) {
    own.clear();
    for (std::size_t i = 0; i < free_; ++i) {
      if (model.body_of(model.unknown_of(nodes_[i])) != static_cast<int>(b)) continue;
      for (std::size_t c = 0; c < 3; ++c) own.push_back(static_cast<Eigen::Index>(3 * i + c));
    }
    if (own.empty()) continue;
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(static_(own, own), mass_(own, own));
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

std::optional<LocalPatch> Condensation::condense() {
  if (step_.counts().steps == 0) return LocalPatch{};
  const ElasticModel& model = step_.soft().model;
  assemble();
  if (!make_modes()) {
    // Pressed hard, a body may be about to buckle. By the warped stiffness it never is.
    K_ = warped_;
    if (!make_modes()) return std::nullopt;
  }
  if (free_ == 0) return LocalPatch{};
  const auto shapes = shape_pool_.make(static_cast<std::size_t>(nodes_.size() * 9 * free_), [&](std::span<double> to) {
    Eigen::Map<Eigen::MatrixXd> all(to.data(), static_cast<Eigen::Index>(3 * nodes_.size()),
                                    static_cast<Eigen::Index>(3 * free_));
    all.setZero();
    all.topRows(static_cast<Eigen::Index>(3 * free_)) = shapes_;
  });
  const auto faces = face_pool_.copy(faces_);
  const auto nodes = node_pool_.make(nodes_.size(), [&](std::span<PatchNode> to) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const int u = model.unknown_of(nodes_[i]);
      to[i] = {plain(step_.x().segment<3>(3 * nodes_[i])), u < 0 ? Vec3{} : plain(step_.v().segment<3>(u)),
               u < 0 ? 1 : 0};
    }
  });
  Eigen::VectorXd on_patch;
  balanced(model.mass().selfadjointView<Eigen::Lower>() * step_.v(), on_patch);
  const Eigen::VectorXd rates = shapes_.transpose() * on_patch;
  balanced(step_.inner_force(), on_patch);
  const Eigen::VectorXd forces = shapes_.transpose() * on_patch;
  const auto modes = mode_pool_.make(3 * free_, [&](std::span<PatchMode> to) {
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
