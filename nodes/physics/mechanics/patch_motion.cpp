#include "nodes/physics/mechanics/patch_motion.hpp"

#include "nodes/physics/mechanics/eigen.hpp"

namespace tactor {

PatchMotion::PatchMotion(Integrator integrator)
    : integrator_(integrator),
      p_W_(LocalPatch::most_nodes),
      ahead_W_(LocalPatch::most_nodes),
      face_nodes_(LocalPatch::most_faces),
      face_bodies_(LocalPatch::most_faces),
      face_areas_(LocalPatch::most_faces),
      z_(LocalPatch::most_modes),
      rate_(LocalPatch::most_modes),
      impulse_(LocalPatch::most_modes),
      moved_(3 * LocalPatch::most_nodes) {}

void PatchMotion::restart(const LocalPatch& patch) {
  patch_ = patch;
  touched_.forget();
  for (std::size_t i = 0; i < patch.faces.size(); ++i) {
    face_nodes_[i] = patch.faces[i].node;
    face_bodies_[i] = patch.faces[i].body;
    face_areas_[i] = patch.faces[i].area;
  }
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

/// Sets moved_ to the sum of the shapes times these amounts.
void PatchMotion::move_by(const Eigen::VectorXd& amounts) {
  const auto dofs = static_cast<Eigen::Index>(3 * patch_.nodes.size());
  const Eigen::Map<const Eigen::MatrixXd> shapes(patch_.shapes.data(), dofs, modes());
  moved_.head(dofs).noalias() = shapes * amounts.head(modes());
}

void PatchMotion::place_nodes() {
  move_by(z_);
  for (std::size_t i = 0; i < patch_.nodes.size(); ++i) {
    p_W_[i] = patch_.nodes[i].p_W + plain(moved_.segment<3>(static_cast<Eigen::Index>(3 * i)));
  }
  ahead_W_ = p_W_;
}

std::span<const Vec3> PatchMotion::nodes_ahead_W(double h) {
  move_by(rate_);
  for (std::size_t i = 0; i < patch_.nodes.size(); ++i) {
    ahead_W_[i] = p_W_[i] + solved_time(h) * plain(moved_.segment<3>(static_cast<Eigen::Index>(3 * i)));
  }
  return std::span(ahead_W_).first(patch_.nodes.size());
}

/// The rate of a mode after h seconds without contacts, not yet times share_kept.
double PatchMotion::free_rate(std::size_t i, double h) const {
  const PatchMode& mode = patch_.modes[i];
  const auto m = static_cast<Eigen::Index>(i);
  return rate_[m] + h * (mode.force - mode.stiffness * z_[m]);
}

SoftPatch PatchMotion::begin(double h, std::span<SoftContact> contacts, std::span<const Pose> X_WB) {
  const double solved = solved_time(h);
  touched_.take(patch_, solved, contacts);
  SoftPatchArrays& arrays = touched_.arrays();
  const std::vector<std::int32_t>& nodes = touched_.nodes();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    arrays.p_W[i] = p_W_[static_cast<std::size_t>(nodes[i])];
    arrays.query_p_W[i] = ahead_W_[static_cast<std::size_t>(nodes[i])];
  }
  auto free_rates = impulse_.head(modes());
  for (std::size_t i = 0; i < patch_.modes.size(); ++i) {
    free_rates[static_cast<Eigen::Index>(i)] = share_kept(patch_.modes[i], solved) * free_rate(i, solved);
  }
  arrays.velocity.head(touched_.dofs()).noalias() = touched_.shapes() * rate_.head(modes());
  arrays.free_velocity.head(touched_.dofs()).noalias() = touched_.shapes() * free_rates;
  return arrays.patch(nodes.size(), contacts, X_WB);
}

SoftPatchMotion PatchMotion::motion() {
  return touched_.arrays().motion(touched_.nodes().size());
}

void PatchMotion::end(double h) {
  impulse_.head(modes()).noalias() =
      solved_time(h) * (touched_.shapes().transpose() * touched_.arrays().force.head(touched_.dofs()));
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
    const double rate = share_kept(patch_.modes[i], solved) * (free_rate(i, solved) + impulse_[m]);
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
