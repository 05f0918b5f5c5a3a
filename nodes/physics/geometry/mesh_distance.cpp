#include "nodes/physics/geometry/mesh_distance.hpp"

#include <algorithm>

#include "nodes/physics/geometry/cell_cache.hpp"
#include "nodes/physics/geometry/tree_distance.hpp"
#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/mesh/cgal_plugin.hpp"

namespace tactor {

MakeMeshDistance cell_distances(const CellOptions& options, Notes* notes) {
  return [options, notes](const TriangleMesh& mesh, double reach) {
    CellOptions wide = options;
    wide.band = std::min(std::max(options.band, reach), bounds_of(mesh).longest() / 8);
    return std::make_unique<CellDistance>(cached_cell_distance(mesh, wide, cell_cache(), notes));
  };
}

MakeMeshDistance tree_distances() {
  return [](const TriangleMesh& mesh, double /*reach*/) { return std::make_unique<TreeDistance>(mesh); };
}

MakeMeshDistance exact_distances() {
  return [](const TriangleMesh& mesh, double /*reach*/) {
    return load_cgal_plugin("collision.exact").exact_distance(mesh);
  };
}

}  // namespace tactor
