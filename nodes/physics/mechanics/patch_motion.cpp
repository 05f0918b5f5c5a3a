#include "nodes/physics/mechanics/patch_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

#include "nodes/physics/mechanics/eigen.hpp"

namespace tactor {

namespace {

constexpr std::size_t most_dofs = 3 * LocalPatch::capacity, most_modes = LocalPatch::most_modes;
// Products of larger ones take memory from the heap.
static_assert(most_dofs * most_modes * sizeof(double) <= EIGEN_STACK_ALLOCATION_LIMIT);

/// What of its velocity a mode keeps over h seconds.
double kept(const PatchMode& mode, double h) {
  return 1 / (1 + h * mode.damping + h * h * mode.stiffness);
}

/// The lower triangle of the inverse of L L^T, from the lower triangle of `L`. Rows above a column are never needed, so
/// that it takes half the time of solving for the identity.
void invert(const Eigen::Ref<const Eigen::MatrixXd>& L, Eigen::Ref<Eigen::MatrixXd> inverse) {
  const Eigen::Index n = L.rows();
  constexpr Eigen::Index columns = 24;
  for (Eigen::Index j = 0; j < n; j += columns) {
    const Eigen::Index below = n - j;
    auto block = inverse.block(j, j, below, std::min(columns, below));
    block.setIdentity();
    const auto tail = L.bottomRightCorner(below, below).triangularView<Eigen::Lower>();
    tail.solveInPlace(block);
    tail.adjoint().solveInPlace(block);
  }
}

}  // namespace

PatchMotion::PatchMotion(Integrator integrator)
    : integrator_(integrator),
      p_W_(LocalPatch::most_nodes),
      ahead_W_(LocalPatch::most_nodes),
      face_nodes_(LocalPatch::most_faces),
      face_bodies_(LocalPatch::most_faces),
      face_areas_(LocalPatch::most_faces),
      z_(most_modes),
      rate_(most_modes),
      impulse_(most_modes),
      place_(LocalPatch::most_nodes, -1),
      touched_p_W_(LocalPatch::capacity),
      touched_ahead_W_(LocalPatch::capacity),
      shapes_(most_dofs, most_modes),
      scaled_(most_dofs, most_modes),
      mobility_(most_dofs, most_dofs),
      inertia_(most_dofs, most_dofs),
      velocity_(most_dofs),
      free_velocity_(most_dofs),
      velocity_after_(most_dofs),
      force_(3 * LocalPatch::most_nodes) {
  touched_.reserve(LocalPatch::capacity);
  known_touched_.reserve(LocalPatch::capacity);
}

void PatchMotion::restart(const LocalPatch& patch) {
  patch_ = patch;
  nodes_ = patch.nodes.size();
  known_time_ = 0;
  for (std::size_t i = 0; i < patch.faces.size(); ++i) {
    face_nodes_[i] = patch.faces[i].node;
    face_bodies_[i] = patch.faces[i].body;
    face_areas_[i] = patch.faces[i].area;
  }
  modes_ = static_cast<Eigen::Index>(patch.modes.size());
  for (std::size_t i = 0; i < patch.modes.size(); ++i) {
    z_[static_cast<Eigen::Index>(i)] = patch.modes[i].z;
    rate_[static_cast<Eigen::Index>(i)] = patch.modes[i].rate;
  }
  place_nodes();
}

SoftFaces PatchMotion::faces() const {
  const std::size_t count = patch_.faces.size();
  return {std::span(face_nodes_).first(count), std::span(face_bodies_).first(count),
          std::span(face_areas_).first(count)};
}

void PatchMotion::place_nodes() {
  const auto dofs = static_cast<Eigen::Index>(3 * nodes_);
  const Eigen::Map<const Eigen::MatrixXd> shapes(patch_.shapes.data(), dofs, modes_);
  // A scratch of the right size.
  force_.head(dofs).noalias() = shapes * z_.head(modes_);
  for (std::size_t i = 0; i < nodes_; ++i) {
    p_W_[i] = patch_.nodes[i].p_W + plain(force_.segment<3>(static_cast<Eigen::Index>(3 * i)));
  }
  ahead_W_ = p_W_;
}

std::span<const Vec3> PatchMotion::nodes_ahead_W(double h) {
  const auto dofs = static_cast<Eigen::Index>(3 * nodes_);
  const Eigen::Map<const Eigen::MatrixXd> shapes(patch_.shapes.data(), dofs, modes_);
  force_.head(dofs).noalias() = shapes * rate_.head(modes_);
  for (std::size_t i = 0; i < nodes_; ++i) {
    ahead_W_[i] = p_W_[i] + solved_time(h) * plain(force_.segment<3>(static_cast<Eigen::Index>(3 * i)));
  }
  return std::span(ahead_W_).first(nodes_);
}

/// The rate of a mode after h seconds without contacts, not yet times `kept`.
double PatchMotion::free_rate(std::size_t i, double h) const {
  const PatchMode& mode = patch_.modes[i];
  const auto m = static_cast<Eigen::Index>(i);
  return rate_[m] + h * (mode.force - mode.stiffness * z_[m]);
}

SoftPatch PatchMotion::begin(double h, std::span<SoftContact> contacts, std::span<const Pose> X_WB) {
  touched_.clear();
  for (SoftContact& contact : contacts) {
    for (std::int32_t& node : contact.node) {
      if (patch_.nodes[static_cast<std::size_t>(node)].fixed != 0) {
        node = -1;
        continue;
      }
      std::int32_t& place = place_[static_cast<std::size_t>(node)];
      if (place < 0) {
        place = static_cast<std::int32_t>(touched_.size());
        touched_.push_back(node);
      }
      node = place;
    }
  }
  for (const std::int32_t node : touched_) place_[static_cast<std::size_t>(node)] = -1;

  const double solved = solved_time(h);
  if (touched_ != known_touched_ || solved != known_time_) set_inertia(solved);

  const auto touched = static_cast<Eigen::Index>(3 * touched_.size());
  for (std::size_t i = 0; i < touched_.size(); ++i) {
    touched_p_W_[i] = p_W_[static_cast<std::size_t>(touched_[i])];
    touched_ahead_W_[i] = ahead_W_[static_cast<std::size_t>(touched_[i])];
  }
  const auto shapes = shapes_.topLeftCorner(touched, modes_);
  auto free_rates = impulse_.head(modes_);
  for (std::size_t i = 0; i < patch_.modes.size(); ++i) {
    free_rates[static_cast<Eigen::Index>(i)] = kept(patch_.modes[i], solved) * free_rate(i, solved);
  }
  velocity_.head(touched).noalias() = shapes * rate_.head(modes_);
  free_velocity_.head(touched).noalias() = shapes * free_rates;
  return {.p_W = std::span(touched_p_W_).first(touched_.size()),
          .inertia = inertia_.topLeftCorner(touched, touched),
          .velocity = velocity_.head(touched),
          .free_velocity = free_velocity_.head(touched),
          .contacts = contacts,
          .query_p_W = std::span(touched_ahead_W_).first(touched_.size()),
          .query_X_WB = X_WB};
}

/// The shapes and the inertia of the nodes that are touched, over `solved` seconds. They stay for as long as the same
/// nodes are touched.
void PatchMotion::set_inertia(double solved) {
  known_touched_ = touched_;
  known_time_ = solved;
  const auto dofs = static_cast<Eigen::Index>(3 * nodes_);
  const auto touched = static_cast<Eigen::Index>(3 * touched_.size());
  const Eigen::Map<const Eigen::MatrixXd> all(patch_.shapes.data(), dofs, modes_);
  auto shapes = shapes_.topLeftCorner(touched, modes_);
  for (std::size_t i = 0; i < touched_.size(); ++i) {
    shapes.middleRows<3>(static_cast<Eigen::Index>(3 * i)) =
        all.middleRows<3>(static_cast<Eigen::Index>(3 * touched_[i]));
  }
  auto scaled = scaled_.topLeftCorner(touched, modes_);
  for (std::size_t i = 0; i < patch_.modes.size(); ++i) {
    const auto m = static_cast<Eigen::Index>(i);
    scaled.col(m) = std::sqrt(kept(patch_.modes[i], solved)) * shapes.col(m);
  }
  // The inverse of what an impulse does.
  auto inertia = inertia_.topLeftCorner(touched, touched);
  auto mobility = mobility_.topLeftCorner(touched, touched);
  mobility.setZero();
  mobility.selfadjointView<Eigen::Lower>().rankUpdate(scaled);
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factors(mobility);
  if (factors.info() == Eigen::Success) {
    invert(mobility, inertia);
  } else {
    // Nodes that no force moves. The step will not be solved, and says so.
    inertia.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
}

SoftPatchMotion PatchMotion::motion() {
  const auto touched = static_cast<Eigen::Index>(3 * touched_.size());
  return {velocity_after_.head(touched), force_.head(touched)};
}

void PatchMotion::end(double h) {
  const auto touched = static_cast<Eigen::Index>(3 * touched_.size());
  impulse_.head(modes_).noalias() =
      solved_time(h) * (shapes_.topLeftCorner(touched, modes_).transpose() * force_.head(touched));
  move_modes(h);
}

void PatchMotion::coast(double h) {
  impulse_.setZero();
  move_modes(h);
}

void PatchMotion::move_modes(double h) {
  for (std::size_t i = 0; i < patch_.modes.size(); ++i) {
    const auto m = static_cast<Eigen::Index>(i);
    const double solved = solved_time(h);
    const double rate = kept(patch_.modes[i], solved) * (free_rate(i, solved) + impulse_[m]);
    z_[m] += h * rate;
    rate_[m] = integrator_ == Integrator::midpoint ? 2 * rate - rate_[m] : rate;
  }
  place_nodes();
}

void PatchMotion::write(std::span<PatchMode> modes) const {
  for (std::size_t i = 0; i < modes.size(); ++i) {
    modes[i] = patch_.modes[i];
    modes[i].z = z_[static_cast<Eigen::Index>(i)];
    modes[i].rate = rate_[static_cast<Eigen::Index>(i)];
  }
}

}  // namespace tactor
