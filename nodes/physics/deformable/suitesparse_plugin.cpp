#include "nodes/physics/deformable/suitesparse_plugin.hpp"

#include "framework/node/plugin.hpp"

namespace tactor {

namespace {
constexpr const char* suitesparse_file = "libtactor_suitesparse.so";
}  // namespace

bool has_suitesparse_plugin() {
  return has_plugin(suitesparse_file);
}

const SuiteSparsePlugin& load_suitesparse_plugin(const std::string& what_for) {
  return load_plugin<SuiteSparsePlugin>(
      suitesparse_file, "tactor_suitesparse_plugin",
      what_for +
          " needs the plugin tactor_suitesparse (package tactor-suitesparse, or a build with "
          "-DTACTOR_WITH_SUITESPARSE=ON)");
}

}  // namespace tactor
