#include "nodes/physics/deformable/sparse_factor.hpp"

#include "nodes/physics/deformable/eigen_factor.hpp"
#include "nodes/physics/deformable/suitesparse_plugin.hpp"

namespace tactor {

std::unique_ptr<SparseFactor> make_factor(FactorKind kind, int tetrahedra) {
  if (kind == FactorKind::automatic) {
    kind = tetrahedra < least_for_supernodal || !has_suitesparse_plugin() ? FactorKind::eigen : FactorKind::supernodal;
  }
  if (kind == FactorKind::simplicial) return load_suitesparse_plugin("the simplicial factor").simplicial_factor();
  if (kind == FactorKind::supernodal) return load_suitesparse_plugin("the supernodal factor").supernodal_factor();
  return std::make_unique<EigenFactor>();
}

}  // namespace tactor
