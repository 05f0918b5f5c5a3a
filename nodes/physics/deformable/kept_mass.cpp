#include "nodes/physics/deformable/kept_mass.hpp"

#include <algorithm>

#include "nodes/physics/deformable/nearest_rotation.hpp"

namespace tactor {

namespace {

/// Of how far the masters of a body reach: how far they may have moved, but for turning all together.
constexpr double still = 0.1;

}  // namespace

void KeptMass::make(const Eigen::MatrixXd& mass, const MasterChoice& choice, const Eigen::VectorXd& x) {
  mass_ = made_ = mass;
  masters_ = choice.masters();
  made_x_ = x;
}

bool KeptMass::turn(const MasterChoice& choice, std::size_t bodies, const Eigen::VectorXd& x) {
  if (masters_ != choice.masters()) return false;
  std::vector<Eigen::Matrix3d> turns(masters_.size());
  for (std::size_t b = 0; b < bodies; ++b) {
    const std::vector<Eigen::Index> own = choice.of_body(b);
    if (own.empty()) continue;
    const auto turn = turn_of(own, x);
    if (!turn) return false;
    for (const Eigen::Index i : own) turns[static_cast<std::size_t>(i)] = *turn;
  }
  mass_.resizeLike(made_);
  for (std::size_t j = 0; j < turns.size(); ++j) {
    for (std::size_t i = 0; i < turns.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(3 * i), column = static_cast<Eigen::Index>(3 * j);
      mass_.block<3, 3>(row, column) = turns[i] * made_.block<3, 3>(row, column) * turns[j].transpose();
    }
  }
  return true;
}

/// The mean turn of some masters of one body since their mass was made. None where they have moved otherwise too.
std::optional<Eigen::Matrix3d> KeptMass::turn_of(std::span<const Eigen::Index> own, const Eigen::VectorXd& x) const {
  const auto then_at = [&](Eigen::Index i) { return made_x_.segment<3>(3 * masters_[static_cast<std::size_t>(i)]); };
  const auto now_at = [&](Eigen::Index i) { return x.segment<3>(3 * masters_[static_cast<std::size_t>(i)]); };
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

}  // namespace tactor
