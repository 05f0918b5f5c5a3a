// Elastic boxes of regular tetrahedra, and what tests ask of them.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "nodes/physics/deformable/elastic_model.hpp"

namespace tactor::test {

/// A box from the origin to `size` (m) of nx * ny * nz cubes, each cut into six tetrahedra about one of its diagonals
/// (Kuhn), or where `mirrored` so that neighbouring cubes are mirror images.
inline TetMesh box_of_tets(int nx, int ny, int nz, const Vec3& size, bool mirrored = false) {
  TetMesh mesh;
  const auto at = [&](int i, int j, int k) { return (k * (ny + 1) + j) * (nx + 1) + i; };
  for (int k = 0; k <= nz; ++k) {
    for (int j = 0; j <= ny; ++j) {
      for (int i = 0; i <= nx; ++i) mesh.nodes.push_back({size.x * i / nx, size.y * j / ny, size.z * k / nz});
    }
  }
  constexpr std::array<std::array<int, 3>, 6> ways{{{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        for (const std::array<int, 3>& way : ways) {
          std::array<int, 4> tet{};
          std::array<int, 3> step{};
          for (std::size_t c = 0; c < 4; ++c) {
            const auto place = [&](int cube, int s) { return mirrored && cube % 2 == 1 ? cube + 1 - s : cube + s; };
            tet[c] = at(place(i, step[0]), place(j, step[1]), place(k, step[2]));
            if (c < 3) step[static_cast<std::size_t>(way[c])] = 1;
          }
          const Vec3 a = mesh.nodes[static_cast<std::size_t>(tet[0])];
          const auto edge = [&](std::size_t c) { return mesh.nodes[static_cast<std::size_t>(tet[c])] - a; };
          if (dot(edge(1), cross(edge(2), edge(3))) < 0) std::swap(tet[2], tet[3]);
          mesh.tets.push_back(tet);
        }
      }
    }
  }
  return mesh;
}

/// A body of one material, fixed where `is_fixed` says so.
inline SoftBody soft_body(TetMesh mesh, double young, double poisson,
                          const std::function<bool(const Vec3&)>& is_fixed) {
  SoftBody body;
  body.young.assign(mesh.tets.size(), young);
  body.poisson = poisson;
  for (const Vec3& p : mesh.nodes) body.fixed.push_back(is_fixed(p) ? 1 : 0);
  body.mesh = std::move(mesh);
  return body;
}

/// Numbers in [-1, 1) that look random and are the same everywhere.
class Noise {
 public:
  double operator()() {
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state_ >> 11) / 4503599627370496.0 - 1;
  }
  Eigen::VectorXd vector(Eigen::Index size) {
    Eigen::VectorXd v(size);
    for (double& entry : v) entry = (*this)();
    return v;
  }

 private:
  unsigned long long state_ = 1;
};

/// A symmetric matrix of its lower triangle.
inline Eigen::MatrixXd full(const Eigen::SparseMatrix<double>& lower) {
  Eigen::MatrixXd matrix = lower;
  matrix.triangularView<Eigen::StrictlyUpper>() = matrix.transpose();
  return matrix;
}

/// Positions of all nodes: unknowns moved by `u`.
inline Eigen::VectorXd moved(const ElasticModel& model, const Eigen::VectorXd& x, const Eigen::VectorXd& u) {
  Eigen::VectorXd to = x;
  for (int i = 0; i < model.unknowns(); ++i) to[3 * model.node_of(i) + i % 3] += u[i];
  return to;
}

}  // namespace tactor::test
