// The entry of the plugin `tactor_suitesparse`.
#include "framework/node/abi.hpp"
#include "nodes/physics/deformable/suitesparse_plugin.hpp"
#include "nodes/physics/suitesparse/cholmod_factor.hpp"
#include "tactor_abi.hpp"

TACTOR_STATES_ABI;

extern "C" const tactor::SuiteSparsePlugin* tactor_suitesparse_plugin() {
  static const tactor::SuiteSparsePlugin plugin = {tactor::make_simplicial_factor, tactor::make_supernodal_factor};
  return &plugin;
}
