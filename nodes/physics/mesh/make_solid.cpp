#include "nodes/physics/mesh/make_solid.hpp"

#include <filesystem>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/core/shell_word.hpp"
#include "nodes/physics/mesh/cgal_plugin.hpp"

namespace tactor {

namespace {

/// The polygons as they are, cut into fans.
TriangleMesh unrepaired_solid(PolygonSoup soup, const std::string& file, MeshReport& report) {
  if (soup.polygons.empty()) throw InputError(file + ": the file has no faces; export the surface as polygons");
  TriangleMesh mesh;
  for (const auto& polygon : soup.polygons) {
    for (std::size_t c = 2; c < polygon.size(); ++c) {
      mesh.faces.push_back(
          {static_cast<int>(polygon[0]), static_cast<int>(polygon[c - 1]), static_cast<int>(polygon[c])});
    }
  }
  mesh.vertices = std::move(soup.points);
  // They have no normal, which distances are made of.
  const std::size_t flat =
      std::erase_if(mesh.faces, [&](const auto& face) { return !(norm(doubled_area_normal(mesh, face)) > 0); });
  if (mesh.faces.empty()) throw InputError(file + ": no face of the mesh has an area");
  if (flat > 0) report.warnings.push_back(std::to_string(flat) + " faces without area were left out");
  report.warnings.emplace_back("it was neither checked nor repaired, because the plugin tactor_cgal is not installed");
  return mesh;
}

}  // namespace

TriangleMesh make_solid(PolygonSoup soup, const std::string& file, MeshReport& report) {
  if (!repairs_meshes()) return unrepaired_solid(std::move(soup), file, report);
  return load_cgal_plugin("the repair of " + file).repaired_solid(std::move(soup), file, report);
}

std::string repair_hint(const MeshReport& report, const std::string& file) {
  if (!report.repairable) return "";
  return "; or try `tactor mesh repair " + as_typed(file) + " --out " +
         as_typed(std::filesystem::path(file).stem().string() + "_repaired.off") + "`";
}

bool repairs_meshes() {
  return has_cgal_plugin();
}

}  // namespace tactor
