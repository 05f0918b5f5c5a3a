#include "nodes/physics/geometry/mesh_distance.hpp"

#include <algorithm>

#include "framework/core/shared_object.hpp"
#include "nodes/physics/geometry/cell_cache.hpp"
#include "nodes/physics/geometry/tree_distance.hpp"
#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/mesh/cgal_plugin.hpp"

namespace tactor {

MakeMeshDistance cell_distances(const CellOptions& options, Notes* notes) {
  return [options, notes](const TriangleMesh& mesh, double reach) {
    CellOptions wide = options;
    wide.band = std::min(std::max(options.band, reach), bounds_of(mesh).longest() / 8);
    return std::static_pointer_cast<const CellDistance>(shared_object("cells " + cell_key(mesh, wide), [&] {
      return std::make_shared<const CellDistance>(cached_cell_distance(mesh, wide, cell_cache(), notes));
    }));
  };
}

MakeMeshDistance tree_distances() {
  return [](const TriangleMesh& mesh, double /*reach*/) { return std::make_shared<const TreeDistance>(mesh); };
}

MakeMeshDistance exact_distances() {
  return [](const TriangleMesh& mesh, double /*reach*/) {
    return load_cgal_plugin("collision.exact").exact_distance(mesh);
  };
}

}  // namespace tactor
