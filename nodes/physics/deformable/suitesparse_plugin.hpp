// What the plugin `tactor_suitesparse` offers. Nothing else links SuiteSparse.
#pragma once

#include <memory>
#include <string>

namespace tactor {

class SparseFactor;

struct SuiteSparsePlugin {
  /// nodes/physics/suitesparse/cholmod_factor.hpp
  std::unique_ptr<SparseFactor> (*simplicial_factor)();
  std::unique_ptr<SparseFactor> (*supernodal_factor)();
};

/// Whether the plugin is installed; does not load it.
bool has_suitesparse_plugin();

/// Loads the plugin. Throws InputError, beginning with `what_for`, where it is not installed or belongs to another
/// build.
const SuiteSparsePlugin& load_suitesparse_plugin(const std::string& what_for);

}  // namespace tactor
