// Patches of deforming surfaces whose masses and stiffnesses are known as matrices over their nodes.
#pragma once

#include <algorithm>
#include <vector>

#include <Eigen/Eigenvalues>

#include "nodes/physics/mechanics/patch_motion.hpp"
#include "tests/nodes/physics/deformable/boxes.hpp"

namespace tactor::test {

/// Makes arrays of messages.
class PatchPool {
 public:
  LocalPatch patch(const std::vector<PatchNode>& nodes, const std::vector<PatchFace>& faces,
                   const std::vector<PatchMode>& modes, const Eigen::MatrixXd& shapes) {
    LocalPatch made;
    made.nodes = *nodes_.copy(nodes);
    made.faces = *faces_.copy(faces);
    made.modes = *modes_.copy(modes);
    made.shapes = *shapes_.copy({shapes.data(), static_cast<std::size_t>(shapes.size())});
    return made;
  }

 private:
  // More than a message may have, for messages that have too much.
  static constexpr std::size_t arrays = 64, room = 400;
  ArrayPool<PatchNode> nodes_{arrays, room};
  ArrayPool<PatchFace> faces_{arrays, room};
  ArrayPool<PatchMode> modes_{arrays, room};
  ArrayPool<double> shapes_{arrays, room* room};
};

/// n free nodes with symmetric positive definite mass M (kg) and stiffness K (N/m) that couple all of them, a held
/// force f (N) and velocities u (m/s).
struct RandomPatch {
  explicit RandomPatch(int n, int seed) : count(n) {
    Noise noise;
    for (int i = 0; i < seed; ++i) noise();
    const Eigen::Index size = 3 * n;
    const auto spd = [&](double least, double most) {
      Eigen::MatrixXd B(size, size);
      for (Eigen::Index i = 0; i < size; ++i) B.col(i) = noise.vector(size);
      return Eigen::MatrixXd(most / static_cast<double>(size) * B * B.transpose() +
                             least * Eigen::MatrixXd::Identity(size, size));
    };
    M = spd(0.002, 0.003);
    K = spd(50, 400);
    f = 0.2 * noise.vector(size);
    u = 0.1 * noise.vector(size);
    places = 0.02 * noise.vector(size);
  }
  [[nodiscard]] Vec3 p(int node) const { return {places[3 * node], places[3 * node + 1], places[3 * node + 2]}; }
  /// By its modes, with the damping drag M + beta K, and `fixed` more nodes that do not move.
  LocalPatch make(PatchPool& pool, double drag, double beta, int fixed = 0,
                  const std::vector<PatchFace>& faces = {}) const {
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(K, M);
    const Eigen::MatrixXd& V = solver.eigenvectors();
    std::vector<PatchNode> nodes;
    for (int i = 0; i < count; ++i) nodes.push_back({p(i), {u[3 * i], u[3 * i + 1], u[3 * i + 2]}, 0});
    for (int i = 0; i < fixed; ++i) nodes.push_back({{0.01 * i, 0.05, 0.03}, {}, 1});
    const Eigen::VectorXd force = V.transpose() * f, rate = V.transpose() * M * u;
    std::vector<PatchMode> modes;
    for (int i = 0; i < 3 * count; ++i) {
      const double w2 = solver.eigenvalues()[i];
      modes.push_back({.stiffness = w2, .damping = drag + beta * w2, .force = force[i], .z = 0, .rate = rate[i]});
    }
    Eigen::MatrixXd shapes = Eigen::MatrixXd::Zero(3 * (count + fixed), 3 * count);
    shapes.topRows(3 * count) = V;
    return pool.patch(nodes, faces, modes, shapes);
  }

  int count;
  Eigen::MatrixXd M, K;
  Eigen::VectorXd f, u, places;
};

/// Contacts on faces that name each of n nodes, the last ones first.
inline std::vector<SoftContact> touching_all(int n) {
  std::vector<SoftContact> contacts;
  for (int i = n - 1; i >= 0; i -= 3) {
    SoftContact c;
    c.contact.n_W = {0, 0, 1};
    c.body = 0;
    for (int k = 0; k < 3; ++k) c.node[static_cast<std::size_t>(k)] = std::max(0, i - k);
    c.share = {1.0 / 3, 1.0 / 3, 1.0 / 3};
    contacts.push_back(c);
  }
  return contacts;
}

/// The place of each of n nodes among those that the contacts name, after `begin` has told them so.
inline std::vector<int> order_of(const std::vector<SoftContact>& after, int n) {
  const std::vector<SoftContact> before = touching_all(n);
  std::vector<int> order(static_cast<std::size_t>(n), -1);
  for (std::size_t c = 0; c < after.size(); ++c) {
    for (std::size_t k = 0; k < 3; ++k) order[static_cast<std::size_t>(before[c].node[k])] = after[c].node[k];
  }
  return order;
}

}  // namespace tactor::test
