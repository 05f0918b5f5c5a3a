// Writes elastic boxes and how they sag, for getfem_test.py.
#include <cstdio>
#include <string>

#include "nodes/physics/deformable/static_balance.hpp"
#include "tests/nodes/physics/deformable/boxes.hpp"

using namespace tactor;
using namespace tactor::test;

namespace {

/// `getfem_answers linear|quadratic small|large`: at small load linear elasticity, at large load the neo-Hookean law.
int write_answer(bool quadratic, bool large) {
  constexpr double young = 1e4, poisson = 0.4, density = 1000;
  const TetMesh mesh = box_of_tets(5, 2, 3, {0.05, 0.02, 0.03});
  const ElasticModel model({soft_body(mesh, young, poisson, [](const Vec3& p) { return p.x < 1e-9; })},
                           Elasticity::neo_hookean, quadratic ? ElementOrder::quadratic : ElementOrder::linear);
  const Vec3 gravity{large ? 12.0 : 0.0, large ? 3.0 : 1.0, large ? -20.0 : -9.81};
  Eigen::VectorXd moved_by = Eigen::VectorXd::Zero(3 * model.nodes());
  if (large) {
    const Balance balance = settle(model, model.rest(), gravity);
    if (!balance.converged) return 1;
    moved_by = balance.x - model.rest();
  } else {
    Eigen::SparseMatrix<double> K;
    Eigen::VectorXd f;
    model.assemble(model.rest(), ElasticModel::Tangent::warped, K, f);
    const auto factor = make_factor(FactorKind::eigen, 0);
    factor->analyze(K, {});
    if (!factor->factor(K)) return 1;
    Eigen::VectorXd u = model.weight(gravity);
    factor->solve(u);
    moved_by = moved(model, moved_by, u);
  }
  std::printf(
      "{\"young\": %.17g, \"poisson\": %.17g, \"density\": %.17g, \"gravity\": [%.17g, %.17g, %.17g],\n\"tets\": [",
      young, poisson, density, gravity.x, gravity.y, gravity.z);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const auto& tet = mesh.tets[t];
    std::printf("%s[%d, %d, %d, %d]", t == 0 ? "" : ", ", tet[0], tet[1], tet[2], tet[3]);
  }
  const auto list = [&](const char* name, const Eigen::VectorXd& values) {
    std::printf("],\n\"%s\": [", name);
    for (int n = 0; n < model.nodes(); ++n) {
      std::printf("%s[%.17g, %.17g, %.17g]", n == 0 ? "" : ", ", values[3 * n], values[3 * n + 1], values[3 * n + 2]);
    }
  };
  list("nodes", model.rest());
  list("moved_by", moved_by);
  std::printf("]}\n");
  return 0;
}

}  // namespace

int main(int count, char** words) {
  if (count != 3) return 2;
  return write_answer(std::string(words[1]) == "quadratic", std::string(words[2]) == "large");
}
