#include <algorithm>
#include <cstdint>
#include <filesystem>

#include "framework/core/check.hpp"
#include "nodes/physics/mesh/mesh_formats.hpp"
#include "nodes/physics/mesh/mesh_words.hpp"
#include "nodes/physics/mesh/volume_formats.hpp"

namespace tactor {

MeshFormat mesh_format(const std::string& file, std::string_view bytes) {
  ReadBudget budget(file, bytes.size());
  const std::string_view first = MeshWords(budget, file, "", bytes.substr(0, 1000)).next();
  if (first == "ply") return MeshFormat::ply;
  if (first == "OFF" || first == "COFF" || first == "NOFF") return MeshFormat::off;
  std::string ending = std::filesystem::path(file).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? c + 32 : c; });
  if (ending == ".off") return MeshFormat::off;
  if (ending == ".obj") return MeshFormat::obj;
  if (ending == ".stl") return MeshFormat::stl;
  if (ending == ".ply") return MeshFormat::ply;
  if (first == "solid") return MeshFormat::stl;
  if (is_volume_file(file)) {
    throw InputError(file +
                     ": a file of tetrahedra is for a body with `motion: deformable`; others are OFF, OBJ, STL or PLY");
  }
  throw InputError(file +
                   ": neither the name nor the content tells the format of this mesh; expected OFF, OBJ, STL or PLY "
                   "with the ending .off, .obj, .stl or .ply");
}

PolygonSoup read_mesh(const std::string& file, MeshFormat format, std::string_view bytes) {
  switch (format) {
    case MeshFormat::off:
      return read_off(file, bytes);
    case MeshFormat::obj:
      return read_obj(file, bytes);
    case MeshFormat::stl:
      return read_stl(file, bytes);
    case MeshFormat::ply:
      return read_ply(file, bytes);
  }
  TACTOR_DEMAND(false);
}

}  // namespace tactor
