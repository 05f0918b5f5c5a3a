// A block of tetrahedra that is fine in the middle of its top and ever coarser away from there.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <utility>
#include <vector>

#include "nodes/physics/mesh/tet_mesh.hpp"

namespace tactor::test {

/// How a block is cut. Its core is the box |x| <= c, |y| <= c, -c <= z <= 0 of cells * cells * cells / 2 cubes; then
/// come `shells` boxes about it, each `growth` times as large as the one inside, whose cells grow likewise.
struct Grading {
  int cells = 6;        ///< across the core, even
  double core = 0.001;  ///< m, c
  double growth = 1.3;
  int shells = 17;
  /// m, how far the block reaches to each side and down.
  [[nodiscard]] double reach() const { return core * std::pow(growth, shells); }
};

/// The six tetrahedra of a hexahedron whose corner i is at (i & 1, i & 2, i & 4). Each face of it is cut from its
/// corner of the lowest number, so that neighbours cut it alike.
inline void add_hexahedron(const std::array<int, 8>& corner, TetMesh& mesh) {
  static constexpr std::array<std::array<std::size_t, 4>, 6> faces{
      {{0, 2, 6, 4}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 5, 7, 6}}};
  const int apex = *std::min_element(corner.begin(), corner.end());
  for (const auto& face : faces) {
    std::array<int, 4> ring{};
    for (std::size_t i = 0; i < 4; ++i) ring[i] = corner[face[i]];
    if (std::find(ring.begin(), ring.end(), apex) != ring.end()) continue;
    std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end()), ring.end());
    for (const std::array<int, 4>& tet :
         {std::array{apex, ring[0], ring[1], ring[2]}, std::array{apex, ring[0], ring[2], ring[3]}}) {
      mesh.tets.push_back(tet);
      const auto at = [&](std::size_t i) { return mesh.nodes[static_cast<std::size_t>(tet[i])]; };
      if (dot(at(1) - at(0), cross(at(2) - at(0), at(3) - at(0))) < 0)
        std::swap(mesh.tets.back()[2], mesh.tets.back()[3]);
    }
  }
}

/// Nodes and tetrahedra alone.
inline TetMesh graded_block(const Grading& grading) {
  const int n = grading.cells, deep = n / 2;
  TetMesh mesh;
  std::map<std::array<int, 4>, int> numbers;
  // A node of the core's grid, moved outwards with the shell; inside of the core there is no shell but 0.
  const auto node = [&](int i, int j, int k, int shell) {
    const auto [found, is_new] = numbers.try_emplace({shell, k, j, i}, static_cast<int>(mesh.nodes.size()));
    if (is_new) {
      const double cell = 2 * grading.core / n * std::pow(grading.growth, shell);
      mesh.nodes.push_back({cell * (i - deep), cell * (j - deep), cell * (k - deep)});
    }
    return found->second;
  };
  for (int k = 0; k < deep; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        std::array<int, 8> corner{};
        for (int c = 0; c < 8; ++c) corner[static_cast<std::size_t>(c)] = node(i + c % 2, j + c / 2 % 2, k + c / 4, 0);
        add_hexahedron(corner, mesh);
      }
    }
  }
  // A side of the core is where one index stays; the two others go.
  struct Side {
    int axis, at, first, second;
  };
  for (const Side& side : {Side{0, 0, 1, 2}, Side{0, n, 1, 2}, Side{1, 0, 0, 2}, Side{1, n, 0, 2}, Side{2, 0, 0, 1}}) {
    const auto cells = [&](int axis) { return axis == 2 ? deep : n; };
    for (int shell = 0; shell < grading.shells; ++shell) {
      for (int b = 0; b < cells(side.second); ++b) {
        for (int a = 0; a < cells(side.first); ++a) {
          std::array<int, 8> corner{};
          for (int c = 0; c < 8; ++c) {
            std::array<int, 3> index{};
            index[static_cast<std::size_t>(side.axis)] = side.at;
            index[static_cast<std::size_t>(side.first)] = a + c % 2;
            index[static_cast<std::size_t>(side.second)] = b + c / 2 % 2;
            corner[static_cast<std::size_t>(c)] = node(index[0], index[1], index[2], shell + c / 4);
          }
          add_hexahedron(corner, mesh);
        }
      }
    }
  }
  return mesh;
}

/// Writes nodes and tetrahedra as VTK's XML UnstructuredGrid.
inline void write_vtu(const TetMesh& mesh, const std::filesystem::path& path) {
  std::ofstream file(path);
  file.precision(17);
  file << "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n"
       << "<Piece NumberOfPoints=\"" << mesh.nodes.size() << "\" NumberOfCells=\"" << mesh.tets.size()
       << "\">\n<Points>\n"
       << "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n";
  for (const Vec3& p : mesh.nodes) file << p.x << ' ' << p.y << ' ' << p.z << '\n';
  file << "</DataArray>\n</Points>\n<Cells>\n<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">\n";
  for (const auto& tet : mesh.tets) file << tet[0] << ' ' << tet[1] << ' ' << tet[2] << ' ' << tet[3] << '\n';
  file << "</DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">\n";
  for (std::size_t i = 1; i <= mesh.tets.size(); ++i) file << 4 * i << '\n';
  file << "</DataArray>\n<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n";
  for (std::size_t i = 0; i < mesh.tets.size(); ++i) file << "10\n";
  file << "</DataArray>\n</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

}  // namespace tactor::test
