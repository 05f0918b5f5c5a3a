#include "nodes/physics/mesh/box_volume.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "nodes/physics/mesh/tet_topology.hpp"

namespace tactor {

namespace {

std::array<std::size_t, 3> cells_of_edge(const Vec3& size, double edge) {
  std::array<std::size_t, 3> cells{};
  constexpr double most = 1e6;  // along one axis
  for (int axis = 0; axis < 3; ++axis) {
    cells[static_cast<std::size_t>(axis)] =
        static_cast<std::size_t>(std::clamp(std::round(size[axis] / edge), 1.0, most));
  }
  return cells;
}

double tetrahedra_in(const std::array<std::size_t, 3>& cells) {
  return 5.0 * static_cast<double>(cells[0]) * static_cast<double>(cells[1]) * static_cast<double>(cells[2]);
}

/// The longest edge of a cell over the shortest, as a logarithm, and much more where the count is off by over 10 %.
double cost_of(const Vec3& size, const std::array<std::size_t, 3>& cells, double wanted) {
  double shortest = std::numeric_limits<double>::infinity(), longest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double edge = size[axis] / static_cast<double>(cells[static_cast<std::size_t>(axis)]);
    shortest = std::min(shortest, edge);
    longest = std::max(longest, edge);
  }
  constexpr double dear = 20;
  const double off = std::abs(std::log(tetrahedra_in(cells) / wanted));
  return std::log(longest / shortest) + dear * std::max(off - std::log(1.1), 0.0) + 0.1 * off;
}

}  // namespace

std::array<std::size_t, 3> box_cells(const Vec3& size, const VolumeFineness& fineness) {
  if (fineness.edge > 0) return cells_of_edge(size, fineness.edge);
  const auto wanted = static_cast<double>(fineness.tetrahedra);
  const double edge = std::cbrt(5 * size.x * size.y * size.z / wanted);
  const auto longest = static_cast<std::size_t>(size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2);
  std::array<std::size_t, 3> best{};
  double least_cost = std::numeric_limits<double>::infinity();
  // Rounding to whole cells moves the count. Edges around the first guess are tried, and for each the number along the
  // longest axis that gives the count.
  for (int i = -50; i <= 50; ++i) {
    for (const bool fitted : {false, true}) {
      std::array<std::size_t, 3> cells = cells_of_edge(size, edge * std::exp(0.01 * i));
      if (fitted) {
        const double others = tetrahedra_in(cells) / static_cast<double>(cells[longest]);
        cells[longest] = static_cast<std::size_t>(std::max(std::round(wanted / others), 1.0));
      }
      const double cost = cost_of(size, cells, wanted);
      if (cost < least_cost) best = cells, least_cost = cost;
    }
  }
  return best;
}

TetMesh box_volume(const Vec3& size, const std::array<std::size_t, 3>& cells) {
  TetMesh mesh;
  const std::size_t nx = cells[0], ny = cells[1], nz = cells[2];
  for (std::size_t k = 0; k <= nz; ++k) {
    for (std::size_t j = 0; j <= ny; ++j) {
      for (std::size_t i = 0; i <= nx; ++i) {
        const auto along = [](double edge, std::size_t at, std::size_t count) {
          return edge * (static_cast<double>(at) / static_cast<double>(count) - 0.5);
        };
        mesh.nodes.push_back({along(size.x, i, nx), along(size.y, j, ny), along(size.z, k, nz)});
      }
    }
  }
  for (std::size_t k = 0; k < nz; ++k) {
    for (std::size_t j = 0; j < ny; ++j) {
      for (std::size_t i = 0; i < nx; ++i) {
        // Corner c lies at x + (c & 1), y + (c >> 1 & 1), z + (c >> 2).
        const auto node = [&](std::size_t c) {
          return static_cast<int>(((k + (c >> 2U)) * (ny + 1) + j + (c >> 1U & 1U)) * (nx + 1) + i + (c & 1U));
        };
        // Every second cell is the mirror image in x, so that the diagonals of faces meet.
        const std::size_t mirror = (i + j + k) % 2;
        constexpr std::array<std::array<std::size_t, 4>, 5> tets{
            {{0, 3, 6, 5}, {0, 1, 3, 5}, {0, 3, 2, 6}, {0, 6, 4, 5}, {3, 6, 5, 7}}};
        for (const auto& t : tets) {
          std::array<int, 4> tet{node(t[0] ^ mirror), node(t[1] ^ mirror), node(t[2] ^ mirror), node(t[3] ^ mirror)};
          if (mirror != 0) std::swap(tet[2], tet[3]);
          mesh.tets.push_back(tet);
        }
      }
    }
  }
  finish_mesh(mesh);
  return mesh;
}

}  // namespace tactor
