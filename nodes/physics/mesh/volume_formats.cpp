#include "nodes/physics/mesh/volume_formats.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "framework/core/check.hpp"
#include "nodes/physics/mesh/tet_quality.hpp"
#include "nodes/physics/mesh/tet_topology.hpp"

namespace tactor {

namespace {

std::string ending_of(const std::string& file) {
  std::string ending = std::filesystem::path(file).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  return ending;
}

std::string place_of(const TetCorners& corners) {
  const Vec3 middle = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "(%.4g, %.4g, %.4g)", middle.x, middle.y, middle.z);
  return text.data();
}

double longest_edge(const TetCorners& corners) {
  double longest = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) longest = std::max(longest, norm(corners[j] - corners[i]));
  }
  return longest;
}

}  // namespace

bool is_volume_file(const std::string& file) {
  const std::string ending = ending_of(file);
  return ending == ".msh" || ending == ".vtu";
}

VolumeFormat volume_format(const std::string& file) {
  const std::string ending = ending_of(file);
  if (ending == ".msh") return VolumeFormat::msh;
  if (ending == ".vtu") return VolumeFormat::vtu;
  throw InputError(file + ": expected a file of tetrahedra with the ending .msh or .vtu");
}

VolumeSoup read_volume(const std::string& file, VolumeFormat format, std::string_view bytes) {
  return format == VolumeFormat::msh ? read_msh(file, bytes) : read_vtu(file, bytes);
}

TetMesh make_volume(VolumeSoup& soup, const std::string& file) {
  if (soup.tets.empty()) {
    throw InputError(
        file +
        ": the file has no tetrahedra; mesh the volume and not its surface alone (in Gmsh: Mesh > 3D, and "
        "where the file has physical groups, one of the volume), or give the surface as OFF, OBJ, STL or PLY");
  }
  TetMesh mesh;
  mesh.nodes = soup.nodes;
  mesh.tets = soup.tets;
  mesh.groups = soup.groups;
  std::size_t turned = 0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const TetCorners corners = corners_of(mesh, mesh.tets[t]);
    // Of a regular one the volume is 0.118 of that cube.
    constexpr double flat = 1e-7;
    const double volume = volume_of(corners), edge = longest_edge(corners);
    if (!(std::abs(volume) > flat * edge * edge * edge)) {
      throw InputError(file + ": tetrahedron " + std::to_string(t) + " (counted from 0) at " + place_of(corners) +
                       " is flat: its corners lie in one plane; mesh the body anew or repair it where it was made");
    }
    if (volume > 0) continue;
    std::swap(mesh.tets[t][2], mesh.tets[t][3]);
    ++turned;
  }
  if (const std::string overlap = find_overlap(mesh); !overlap.empty()) {
    throw InputError(
        file + ": " + overlap +
        " (counted from 0), as where an element is inverted; mesh the body anew or repair it where it was made");
  }
  if (turned > 0) {
    soup.notes.push_back(std::to_string(turned) + " of " + std::to_string(mesh.tets.size()) +
                         " tetrahedra listed their corners in reverse order and were turned");
  }
  const std::size_t nodes = mesh.nodes.size();
  finish_mesh(mesh);
  if (mesh.nodes.size() < nodes) {
    soup.notes.push_back(std::to_string(nodes - mesh.nodes.size()) +
                         " nodes that belong to no tetrahedron were left out");
  }
  return mesh;
}

}  // namespace tactor
