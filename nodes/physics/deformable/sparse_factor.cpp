#include "nodes/physics/deformable/sparse_factor.hpp"

#include "framework/core/processor_dependence.hpp"
#include "nodes/physics/deformable/eigen_factor.hpp"
#include "nodes/physics/deformable/suitesparse_plugin.hpp"

namespace tactor {

FactorChoice chosen_factor(int tetrahedra) {
  if (tetrahedra < least_for_supernodal) return {FactorKind::eigen, "there are fewer than 1,000 tetrahedra"};
  if (!has_suitesparse_plugin()) return {FactorKind::eigen, "the plugin tactor_suitesparse is not installed"};
  return {FactorKind::supernodal, "there are 1,000 tetrahedra or more"};
}

std::unique_ptr<SparseFactor> make_factor(FactorKind kind, int tetrahedra) {
  if (kind == FactorKind::automatic) kind = chosen_factor(tetrahedra).kind;
  if (kind == FactorKind::portable) {
    const bool simplicial = tetrahedra >= least_for_simplicial && has_suitesparse_plugin();
    kind = simplicial ? FactorKind::simplicial : FactorKind::eigen;
  }
  if (kind == FactorKind::simplicial) return load_suitesparse_plugin("the simplicial factor").simplicial_factor();
  if (kind == FactorKind::supernodal) {
    note_processor_dependence("dynamics.deformable with the solver supernodal, which calls a BLAS");
    return load_suitesparse_plugin("the supernodal factor").supernodal_factor();
  }
  return std::make_unique<EigenFactor>();
}

}  // namespace tactor
