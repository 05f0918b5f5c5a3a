#include "bench/collision/measure.hpp"
#include "bench/collision/quantile.hpp"
#include "bench/collision/scenes.hpp"
#include "bench/collision/sized_bunny.hpp"
#include "framework/core/check.hpp"
#include "framework/core/temporary_folder.hpp"
#include "nodes/physics/geometry/cell_cache.hpp"
#include "nodes/physics/mesh/solid_file.hpp"

namespace tactor::bench {

namespace {

using Json = nlohmann::ordered_json;

Json row(const std::string& name, const TriangleMesh& mesh) {
  const TemporaryFolder folder;
  const CellOptions cells;
  const DiskCache cache = cell_cache(folder.path());
  std::vector<std::string> notes;
  std::vector<double> built, loaded;  // ms
  const double kept =
      1e-3 * microseconds([&] { const CellDistance d = cached_cell_distance(mesh, cells, cache, &notes); });
  for (int i = 0; i < 3; ++i) {
    built.push_back(1e-3 * microseconds([&] { const CellDistance d(mesh, cells); }));
    loaded.push_back(1e-3 *
                     microseconds([&] { const CellDistance d = cached_cell_distance(mesh, cells, cache, &notes); }));
  }
  if (!notes.empty()) throw RunError("the cache did not serve: " + notes.front());
  return {{"mesh", name},
          {"triangles", mesh.faces.size()},
          {"build_ms", quantile(built, 0.5)},
          {"build_and_keep_ms", kept},
          {"load_ms", quantile(loaded, 0.5)},
          {"file_MB", 1e-6 * static_cast<double>(std::filesystem::file_size(cache.file(cell_key(mesh, cells))))}};
}

}  // namespace

Json build_scene(const SceneOptions& options) {
  Json rows = Json::array();
  for (const char* name : {"peg", "plate", "duck", "bunny"}) {
    rows.push_back(row(name, load_solid(options.meshes / (std::string(name) + ".off")).mesh));
  }
  const auto sized = sized_bunnies(options.meshes / "data/meshes/bunny00.off", {75'408, 301'632});
  for (const TriangleMesh& mesh : sized) rows.push_back(row("bunny", mesh));
  return {{"meshes", rows}};
}

}  // namespace tactor::bench
