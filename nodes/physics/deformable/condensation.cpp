#include "nodes/physics/deformable/condensation.hpp"

#include <algorithm>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "nodes/physics/deformable/nearest_rotation.hpp"
#include "nodes/physics/deformable/spread_nodes.hpp"
#include "nodes/physics/mechanics/eigen.hpp"

namespace tactor {

namespace {

// s_0 and s_1 over that of the fastest modes of all bodies: below the slowest ones, unless bodies differ by more than a
// thousand times in stiffness, and far above what rounding leaves.
constexpr double balance = 1e-7, slow = 1e-6;

/// Of how far the masters of a body reach: how far they may have moved, but for turning all together, for their mass to
/// be taken as it was.
constexpr double still = 0.1;

}  // namespace

Condensation::Condensation(const DeformableStep& step, FactorKind factor, int far_nodes, std::size_t results)
    : step_(step),
      factor_(make_factor(factor, step.soft().model.elements())),
      most_far_(static_cast<std::size_t>(far_nodes)),
      spread_(spread_nodes(step.soft(), far_nodes + LocalPatch::capacity)),
      solved_(step.soft().model.unknowns()),
      node_pool_(results, LocalPatch::most_nodes),
      face_pool_(results, LocalPatch::most_faces),
      mode_pool_(results, LocalPatch::most_modes),
      shape_pool_(results, static_cast<std::size_t>(3 * LocalPatch::most_nodes * LocalPatch::most_modes)) {}

/// Takes nodes far from the tool, of those bodies in turn that have some around it.
void Condensation::choose_far_nodes() {
  const ElasticModel& model = step_.soft().model;
  std::vector<char> touched(model.bodies().size(), 0);
  for (std::size_t i = 0; i < free_; ++i) {
    touched[static_cast<std::size_t>(model.body_of(model.unknown_of(nodes_[i])))] = 1;
  }
  const std::size_t most = std::min(most_far_, static_cast<std::size_t>(LocalPatch::most_modes / 3) - free_);
  masters_.clear();
  for (std::size_t k = 0; k < most_far_ + LocalPatch::capacity; ++k) {
    for (std::size_t b = 0; b < spread_.size(); ++b) {
      if (touched[b] == 0 || k >= spread_[b].size() || masters_.size() >= most) continue;
      if (step_.patch().place_of(spread_[b][k]) < 0) masters_.push_back(spread_[b][k]);
    }
  }
}

/// The nodes that are eliminated last, as a SparseFactor numbers them: those that only other bodies touch, then the
/// masters.
std::vector<int> Condensation::last_nodes() const {
  const ElasticModel& model = step_.soft().model;
  std::vector<int> last;
  for (std::size_t i = 0; i < patch_.size() - free_; ++i) last.push_back(model.unknown_of(patch_[i]) / 3);
  for (const int node : masters_) last.push_back(model.unknown_of(node) / 3);
  return last;
}

/// Which of the masters are of that body.
std::vector<Eigen::Index> Condensation::masters_of(std::size_t body) const {
  const ElasticModel& model = step_.soft().model;
  std::vector<Eigen::Index> own;
  for (std::size_t i = 0; i < masters_.size(); ++i) {
    if (model.body_of(model.unknown_of(masters_[i])) == static_cast<int>(body))
      own.push_back(static_cast<Eigen::Index>(i));
  }
  return own;
}

/// Takes the nodes around the tool and the faces between them and nodes that do not move.
void Condensation::choose_nodes() {
  const SoftScene& soft = step_.soft();
  const PatchChoice& patch = step_.patch();
  patch_ = patch.nodes();
  nodes_.assign(patch_.end() - static_cast<std::ptrdiff_t>(patch.around_tool()), patch_.end());
  free_ = nodes_.size();
  choose_far_nodes();
  masters_.insert(masters_.end(), nodes_.begin(), nodes_.end());
  faces_.clear();
  const std::size_t others = patch_.size() - free_;
  const auto place = [&](int node) -> std::int32_t {
    if (soft.model.unknown_of(node) >= 0) {
      const int at = patch.place_of(node);
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

/// From the Schur complement on all last nodes to that on the masters, which come last.
void Condensation::reduce(Eigen::MatrixXd& schur) const {
  const auto kept = static_cast<Eigen::Index>(3 * masters_.size());
  if (schur.rows() == kept) return;
  const Eigen::LLT<Eigen::MatrixXd> factors(schur);
  const Eigen::MatrixXd L = factors.matrixL();
  const Eigen::MatrixXd last = L.bottomRightCorner(kept, kept);
  schur = last.triangularView<Eigen::Lower>() * last.transpose();
}

/// Sets on_masters to what these feel of a force on all unknowns.
void Condensation::balanced(const Eigen::VectorXd& force, Eigen::VectorXd& on_masters) {
  solved_ = force;
  factor_->solve(solved_);
  Eigen::VectorXd moved(static_cast<Eigen::Index>(3 * masters_.size()));
  for (std::size_t i = 0; i < masters_.size(); ++i) {
    moved.segment<3>(static_cast<Eigen::Index>(3 * i)) = solved_.segment<3>(step_.soft().model.unknown_of(masters_[i]));
  }
  on_masters.noalias() = static_ * moved;
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

/// The mean turn of some masters of one body since their mass was made. None where they have moved otherwise too.
std::optional<Eigen::Matrix3d> Condensation::turn_of(std::span<const Eigen::Index> own) const {
  const auto then_at = [&](Eigen::Index i) { return mass_x_.segment<3>(3 * masters_[static_cast<std::size_t>(i)]); };
  const auto now_at = [&](Eigen::Index i) { return step_.x().segment<3>(3 * masters_[static_cast<std::size_t>(i)]); };
  Eigen::Vector3d then = Eigen::Vector3d::Zero(), now = then;
  for (const Eigen::Index i : own) {
    then += then_at(i) / static_cast<double>(own.size());
    now += now_at(i) / static_cast<double>(own.size());
  }
  // W. Kabsch, "A solution for the best rotation to relate two sets of vectors", 1976.
  Eigen::Matrix3d both = Eigen::Matrix3d::Zero(), R;
  double reach = 0, moved = 0;
  for (const Eigen::Index i : own) {
    both += (now_at(i) - now) * (then_at(i) - then).transpose();
    reach = std::max(reach, (then_at(i) - then).norm());
  }
  nearest_rotation(both / (reach * reach), R);
  for (const Eigen::Index i : own) moved = std::max(moved, (now_at(i) - now - R * (then_at(i) - then)).norm());
  if (!(moved <= still * reach)) return std::nullopt;
  return R;
}

/// Turns the mass as the masters have turned since it was made. False where they are others or have moved otherwise.
bool Condensation::turn_mass() {
  if (mass_masters_ != masters_) return false;
  std::vector<Eigen::Matrix3d> turns(masters_.size());
  for (std::size_t b = 0; b < step_.soft().model.bodies().size(); ++b) {
    const std::vector<Eigen::Index> own = masters_of(b);
    if (own.empty()) continue;
    const auto turn = turn_of(own);
    if (!turn) return false;
    for (const Eigen::Index i : own) turns[static_cast<std::size_t>(i)] = *turn;
  }
  mass_.resizeLike(made_mass_);
  for (std::size_t j = 0; j < turns.size(); ++j) {
    for (std::size_t i = 0; i < turns.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(3 * i), column = static_cast<Eigen::Index>(3 * j);
      mass_.block<3, 3>(row, column) = turns[i] * made_mass_.block<3, 3>(row, column) * turns[j].transpose();
    }
  }
  return true;
}

/// Makes the modes of K_. False where it or the mass is not positive definite.
bool Condensation::make_modes() {
  const ElasticModel& model = step_.soft().model;
  if (A_.rows() == 0) A_ = K_;
  if (patch_ != step_.patch().nodes() || free_ != step_.patch().around_tool() || !is_analysed_) {
    choose_nodes();
    factor_->analyze(A_, last_nodes());
    is_analysed_ = true;
  }
  if (free_ == 0) return true;
  // The factor in balance comes last, because forces are balanced by it.
  const double fastest = K_.diagonal().sum() / model.mass().diagonal().sum();
  const double s0 = balance * fastest, s1 = slow * fastest;
  const bool is_kept = turn_mass();
  if ((!is_kept && !condense_at(s1, slow_)) || !condense_at(s0, static_)) return false;
  if (!is_kept) {
    mass_ = made_mass_ = (slow_ - static_) / (s1 - s0);
    mass_masters_ = masters_;
    mass_x_ = step_.x();
  }
  return make_modes_by_body(s0);
}

/// Bodies do not act on each other here. Modes of all together would mix bodies whose modes are equally fast, and with
/// them their damping.
bool Condensation::make_modes_by_body(double s0) {
  const ElasticModel& model = step_.soft().model;
  const auto dofs = static_cast<Eigen::Index>(3 * masters_.size());
  shapes_.setZero(dofs, dofs);
  square_.resize(dofs);
  damping_.resize(dofs);
  Eigen::Index made = 0;
  std::vector<Eigen::Index> own;
  for (std::size_t b = 0; b < model.bodies().size(); ++b) {
    own.clear();
    for (const Eigen::Index i : masters_of(b)) {
      for (Eigen::Index c = 0; c < 3; ++c) own.push_back(3 * i + c);
    }
    if (own.empty()) continue;
    const Eigen::MatrixXd mass = mass_(own, own);
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

std::optional<LocalPatch> Condensation::condense() {
  if (step_.counts().steps == 0) return LocalPatch{};
  const ElasticModel& model = step_.soft().model;
  model.assemble(step_.x(), ElasticModel::Tangent::mean, K_, scratch_);
  if (!make_modes()) {
    // Pressed hard, a body may be about to buckle. By the warped stiffness it never is.
    model.assemble(step_.x(), ElasticModel::Tangent::warped, K_, scratch_);
    if (!make_modes()) return std::nullopt;
  }
  if (free_ == 0) return LocalPatch{};
  const auto shapes = shape_pool_.make(9 * nodes_.size() * masters_.size(), [&](std::span<double> to) {
    const auto moving = static_cast<Eigen::Index>(3 * free_);
    Eigen::Map<Eigen::MatrixXd> all(to.data(), static_cast<Eigen::Index>(3 * nodes_.size()), shapes_.cols());
    all.topRows(moving) = shapes_.bottomRows(moving);
    all.bottomRows(all.rows() - moving).setZero();
  });
  const auto faces = face_pool_.copy(faces_);
  const auto nodes = node_pool_.make(nodes_.size(), [&](std::span<PatchNode> to) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const int u = model.unknown_of(nodes_[i]);
      to[i] = {plain(step_.x().segment<3>(3 * nodes_[i])), u < 0 ? Vec3{} : plain(step_.v().segment<3>(u)),
               u < 0 ? 1 : 0};
    }
  });
  Eigen::VectorXd on_masters;
  balanced(model.mass().selfadjointView<Eigen::Lower>() * step_.v(), on_masters);
  const Eigen::VectorXd rates = shapes_.transpose() * on_masters;
  balanced(step_.inner_force(), on_masters);
  const Eigen::VectorXd forces = shapes_.transpose() * on_masters;
  const auto modes = mode_pool_.make(3 * masters_.size(), [&](std::span<PatchMode> to) {
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
