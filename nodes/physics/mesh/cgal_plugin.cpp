#include "nodes/physics/mesh/cgal_plugin.hpp"

#include "framework/node/plugin.hpp"

namespace tactor {

namespace {
constexpr const char* cgal_file = "libtactor_cgal.so";
}  // namespace

bool has_cgal_plugin() {
  return has_plugin(cgal_file);
}

const CgalPlugin& load_cgal_plugin(std::string_view what_for) {
  return load_plugin<CgalPlugin>(
      cgal_file, "tactor_cgal_plugin",
      std::string(what_for) +
          " needs the plugin tactor_cgal (package tactor-cgal, or a build with -DTACTOR_WITH_CGAL=ON)");
}

}  // namespace tactor
