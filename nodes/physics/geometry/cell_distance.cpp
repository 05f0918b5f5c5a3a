#include "nodes/physics/geometry/cell_distance.hpp"

#include <algorithm>
#include <cmath>

#include "nodes/physics/geometry/wide.hpp"

namespace tactor {

namespace {

using wide::F8;
using wide::I8;

TACTOR_WIDE void search_list(const CellData& data, const CellBlock& block, std::uint32_t list, float from_centre,
                             wide::Search& search) {
  const std::uint32_t* const palette = &data.palette[block.palette];
  const std::size_t first = list >> 4, count = list & 15;
  for (std::size_t j = first; j < first + count; ++j) {
    if (j > first) {
      const float away = data.batch_bound[j] - from_centre;
      if (away > 0 && away * away > search.limit) return;
    }
    const FaceRecord* face[8];
    for (std::size_t k = 0; k < 8; ++k) face[k] = &data.tree.records[palette[data.batches[j][k]]];
    search.consider(face);
  }
}

TACTOR_WIDE void bound_distances(const CellData& data, const Points8& points, unsigned wanted,
                                 std::array<float, 8>& bound) {
  const float* coordinate[3] = {points.x.data(), points.y.data(), points.z.data()};
  const auto edge = static_cast<float>(data.edge), inverse = static_cast<float>(1 / data.edge);
  // The distance is d at the centre of a cell, so it is at least d - r at r from there, even where the nearest cell of
  // the grid does not hold the point.
  F8 to_cell = wide::all(0), to_block = to_cell, to_box = to_cell;
  I8 cell = {}, block = {};
  std::int32_t cell_stride = 1, block_stride = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int32_t blocks = data.blocks[static_cast<std::size_t>(axis)];
    const F8 x = wide::load(coordinate[axis]);
    const F8 from_low = x - static_cast<float>(data.low[axis]);
    const F8 place =
        wide::min(wide::max(from_low * inverse, wide::all(0)), wide::all(static_cast<float>(8 * blocks) - 0.5F));
    const I8 i = __builtin_convertvector(place, I8);
    const F8 dc = from_low - (__builtin_convertvector(i, F8) + 0.5F) * edge;
    const F8 db = from_low - (__builtin_convertvector(i >> 3, F8) + 0.5F) * (8 * edge);
    const F8 out =
        wide::max(wide::max(static_cast<float>(data.box_low[axis]) - x, x - static_cast<float>(data.box_high[axis])),
                  wide::all(0));
    to_cell += dc * dc;
    to_block += db * db;
    to_box += out * out;
    cell += (i & 7) * cell_stride;
    block += (i >> 3) * block_stride;
    cell_stride *= 8;
    block_stride *= blocks;
  }
  alignas(32) float known[8], squared[8], far[8], outside[8];
  alignas(32) std::int32_t c[8], b[8];
  wide::store(squared, to_cell);
  wide::store(far, to_block);
  wide::store(outside, to_box);
  __builtin_memcpy(c, &cell, sizeof c);
  __builtin_memcpy(b, &block, sizeof b);
  for (std::size_t k = 0; k < 8; ++k) {
    known[k] = 0;
    if ((wanted >> k & 1) == 0) continue;
    const CellBlock& of = data.block[static_cast<std::size_t>(b[k])];
    if (of.cells >= 0) {
      const Cell& nearest = data.cells[512 * static_cast<std::size_t>(of.cells) + static_cast<std::size_t>(c[k])];
      known[k] = nearest.distance;
      // Who asks for a bound near the surface is likely to ask for the nearest point next.
      __builtin_prefetch(data.batches.data() + (nearest.list >> 4));
    } else {
      known[k] = of.distance;
      squared[k] = far[k];
    }
  }
  const auto slack = static_cast<float>(data.slack);
  for (std::size_t k = 0; k < 8; ++k) {
    const float by_cell = known[k] - 1.00001F * std::sqrt(squared[k]);
    const float by_box = 0.99999F * std::sqrt(outside[k]);
    bound[k] = (outside[k] > 0 && by_box > by_cell ? by_box : by_cell) - slack;
  }
}

}  // namespace

Nearest CellDistance::nearest(const Vec3& x, int hint) const {
  if (hint >= 0) data_.surface.prefetch(hint);
  const Vec3 place = (x - data_.low) * (1 / data_.edge);
  wide::Search search = wide::search_about(data_.tree, data_.surface, x);
  const auto inside = [&](int axis) {
    return place[axis] >= 0 && place[axis] < 8.0 * data_.blocks[static_cast<std::size_t>(axis)];
  };
  if (inside(0) && inside(1) && inside(2)) {
    const auto i = static_cast<std::size_t>(place.x), j = static_cast<std::size_t>(place.y),
               k = static_cast<std::size_t>(place.z);
    const auto nx = static_cast<std::size_t>(data_.blocks[0]), ny = static_cast<std::size_t>(data_.blocks[1]);
    const CellBlock& block = data_.block[i / 8 + nx * (j / 8 + ny * (k / 8))];
    if (block.cells >= 0) {
      const Cell& cell = data_.cells[512 * static_cast<std::size_t>(block.cells) + i % 8 + 8 * (j % 8 + 8 * (k % 8))];
      if ((cell.list & 15) != 0) {
        const Vec3 from_centre =
            place - Vec3{static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5, static_cast<double>(k) + 0.5};
        search_list(data_, block, cell.list, static_cast<float>(1.00001 * data_.edge * norm(from_centre)), search);
        return data_.surface.signed_distance(search.best, x);
      }
    }
  }
  return data_.surface.signed_distance(data_.tree.nearest(data_.surface, x, hint), x);
}

void CellDistance::lower_bounds(const Points8& x, unsigned wanted, std::array<float, 8>& bound) const {
  bound_distances(data_, x, wanted, bound);
}

Eigen::Matrix3d CellDistance::hessian(const Nearest& nearest, const Vec3& /*x*/) const {
  return data_.surface.hessian(nearest);
}

}  // namespace tactor
