#include "nodes/physics/geometry/mesh_distance.hpp"

#include <algorithm>
#include <map>
#include <mutex>

#include "nodes/physics/geometry/cell_cache.hpp"
#include "nodes/physics/geometry/tree_distance.hpp"
#include "nodes/physics/mesh/bounds.hpp"
#include "nodes/physics/mesh/cgal_plugin.hpp"

namespace tactor {

namespace {

/// The cells of that key that somebody holds, or what `make` makes.
template <class Make>
std::shared_ptr<const SignedDistance> shared_cells(const std::string& key, const Make& make) {
  static std::mutex mutex;
  static std::map<std::string, std::weak_ptr<const SignedDistance>> held;
  const std::lock_guard lock(mutex);
  std::weak_ptr<const SignedDistance>& known = held[key];
  std::shared_ptr<const SignedDistance> cells = known.lock();
  if (!cells) known = cells = make();
  return cells;
}

}  // namespace

MakeMeshDistance cell_distances(const CellOptions& options, Notes* notes) {
  return [options, notes](const TriangleMesh& mesh, double reach) {
    CellOptions wide = options;
    wide.band = std::min(std::max(options.band, reach), bounds_of(mesh).longest() / 8);
    return shared_cells(cell_key(mesh, wide), [&] {
      return std::make_shared<const CellDistance>(cached_cell_distance(mesh, wide, cell_cache(), notes));
    });
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
