// Makes the cells of a mesh: from blocks down to cells, each from the faces that its parent left.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "nodes/collision/cell_distance.hpp"
#include "nodes/collision/wide.hpp"

namespace tactor {

namespace {

// Longer lists are left to the tree: 15 batches are what a cell can count.
constexpr std::size_t most_batches = 15;

/// The distances of some faces to a point, in floats, and the least of them.
TACTOR_WIDE float measure(const std::vector<FaceRecord>& records, const std::vector<std::uint32_t>& list,
                          const float* x, std::vector<float>& distance) {
  distance.resize(list.size() + 7);
  const auto filler = static_cast<std::uint32_t>(records.size() - 1);
  float least = std::numeric_limits<float>::infinity();
  for (std::size_t j = 0; j < list.size(); j += 8) {
    const FaceRecord* face[8];
    for (std::size_t k = 0; k < 8; ++k) face[k] = &records[j + k < list.size() ? list[j + k] : filler];
    alignas(32) float squared[8];
    wide::store(squared, wide::squared_distances(face, x[0], x[1], x[2]));
    for (std::size_t k = 0; k < 8; ++k) {
      distance[j + k] = std::sqrt(squared[k]);
      // A face that floats cannot measure shows 0, which is no distance.
      if (squared[k] > 0 || face[k]->a[0] == face[k]->a[0]) least = std::min(least, distance[j + k]);
    }
  }
  return least;
}

class Builder {
 public:
  Builder(CellData& data, const CellOptions& options) : data_(data), options_(options) {
    const FaceTree& tree = data.tree;
    Vec3 low{1e300, 1e300, 1e300}, high = -low;
    for (const auto& corners : data.surface.corners) {
      for (const Vec3& c : corners) {
        for (int axis = 0; axis < 3; ++axis) {
          low[axis] = std::min(low[axis], c[axis]);
          high[axis] = std::max(high[axis], c[axis]);
        }
      }
    }
    data.box_low = low;
    data.box_high = high;
    const Vec3 size = high - low;
    data.edge = std::max({size.x, size.y, size.z}) / options.resolution;
    for (int axis = 0; axis < 3; ++axis) {
      const auto n = static_cast<std::int32_t>(std::ceil((size[axis] + 2 * options.band) / (8 * data.edge)));
      data.blocks[static_cast<std::size_t>(axis)] = std::max(n, 1);
      data.low[axis] = 0.5 * (low[axis] + high[axis]) - 4 * data.edge * std::max(n, 1);
    }
    error_ = 2 * static_cast<float>(tree.error(data.low));
    data.slack = std::ldexp(norm(low) + norm(high) + norm(data.low), -20);
  }

  void build() {
    const double block_radius = 4 * data_.edge * std::numbers::sqrt3;
    int hint = -1;
    for (std::int32_t k = 0; k < data_.blocks[2]; ++k) {
      for (std::int32_t j = 0; j < data_.blocks[1]; ++j) {
        for (std::int32_t i = 0; i < data_.blocks[0]; ++i) {
          const Vec3 centre = data_.low + 8 * data_.edge * Vec3{i + 0.5, j + 0.5, k + 0.5};
          const NearestFace nearest = data_.tree.nearest(data_.surface, centre, hint);
          hint = nearest.face;
          const double distance = data_.surface.signed_distance(nearest, centre).distance;
          data_.block_distance.push_back(lower(distance));
          data_.block.push_back(-1);
          if (std::abs(distance) > options_.band + block_radius) continue;
          data_.block.back() = static_cast<std::int32_t>(data_.cells.size() / 512);
          data_.cells.resize(data_.cells.size() + 512);
          data_.tree.within(centre, std::abs(distance) + 2 * block_radius, list_[3]);
          cut(centre, 3, data_.cells.size() - 512, {0, 0, 0});
        }
      }
    }
    data_.cells.shrink_to_fit();
    data_.batches.shrink_to_fit();
    data_.batch_bound.shrink_to_fit();
  }

 private:
  static float lower(double distance) {
    const auto rounded = static_cast<float>(distance);
    return rounded > distance ? std::nextafter(rounded, -std::numeric_limits<float>::infinity()) : rounded;
  }

  /// Distances of the faces of `list` to c into distance_, and the least of them.
  float measure_at(const Vec3& c, const std::vector<std::uint32_t>& list) {
    const Vec3 about = c - data_.tree.origin;
    const float x[3] = {static_cast<float>(about.x), static_cast<float>(about.y), static_cast<float>(about.z)};
    return measure(data_.tree.records, list, x, distance_);
  }

  /// Goes on with the eight parts of a cube of 2^level cells, whose faces are list_[level].
  void cut(const Vec3& centre, std::size_t level, std::size_t first_cell, const std::array<std::size_t, 3>& corner) {
    const std::size_t half = std::size_t{1} << level >> 1;
    const double quarter = 0.5 * data_.edge * static_cast<double>(half);
    const double radius = quarter * std::numbers::sqrt3;
    for (std::size_t part = 0; part < 8; ++part) {
      const std::array<std::size_t, 3> at = {part & 1, part >> 1 & 1, part >> 2};
      const auto side = [&](std::size_t axis) { return at[axis] == 0 ? -quarter : quarter; };
      const Vec3 c = centre + Vec3{side(0), side(1), side(2)};
      keep_near(c, radius, list_[level], list_[level - 1]);
      const std::array<std::size_t, 3> to = {corner[0] + half * at[0], corner[1] + half * at[1],
                                             corner[2] + half * at[2]};
      if (half > 1) {
        cut(c, level - 1, first_cell, to);
      } else {
        finish(c, radius, data_.cells[first_cell + to[0] + 8 * (to[1] + 8 * to[2])]);
      }
    }
  }

  /// The faces of `from` that can be nearest to a point within `radius` of c.
  void keep_near(const Vec3& c, double radius, const std::vector<std::uint32_t>& from,
                 std::vector<std::uint32_t>& kept) {
    const float limit = measure_at(c, from) + static_cast<float>(2.0001 * radius) + error_;
    kept.clear();
    for (std::size_t i = 0; i < from.size(); ++i) {
      if (distance_[i] <= limit) kept.push_back(from[i]);
    }
  }

  /// The distance of a cell and, within the band, its list, from the faces in list_[0].
  void finish(const Vec3& c, double radius, Cell& cell) {
    wide::Search search = wide::search_about(data_.tree, data_.surface, c);
    const float least = measure_at(c, list_[0]);
    for (std::size_t i = 0; i < list_[0].size(); ++i) {
      if (distance_[i] <= least + error_) search.look_at(data_.tree.records[list_[0][i]].face);
    }
    const double distance = data_.surface.signed_distance(search.best, c).distance;
    cell.distance = lower(distance);
    if (std::abs(distance) > options_.band + radius) return;

    // A face can be nearest to a point of the cell only where it can be so to a point of one of its parts.
    by_distance_.clear();
    for (std::size_t i = 0; i < list_[0].size(); ++i) by_distance_.push_back({distance_[i], list_[0][i], false});
    for (std::size_t part = 0; part < 64; ++part) {
      const auto side = [&](std::size_t i) { return data_.edge * (0.25 * static_cast<double>(i) - 0.375); };
      const Vec3 s = c + Vec3{side(part & 3), side(part >> 2 & 3), side(part >> 4)};
      const float limit = measure_at(s, list_[0]) + static_cast<float>(0.25 * 2.0001 * radius) + error_;
      for (std::size_t i = 0; i < list_[0].size(); ++i) by_distance_[i].kept |= distance_[i] <= limit;
    }
    std::erase_if(by_distance_, [](const Entry& e) { return !e.kept; });
    std::sort(by_distance_.begin(), by_distance_.end(), [](const Entry& a, const Entry& b) {
      return a.distance != b.distance ? a.distance < b.distance : a.record < b.record;
    });
    const std::size_t count = (by_distance_.size() + 7) / 8;
    if (count > most_batches) return;
    cell.list = static_cast<std::uint32_t>(data_.batches.size() << 4 | count);
    for (std::size_t j = 0; j < count; ++j) {
      std::array<std::uint32_t, 8>& batch = data_.batches.emplace_back();
      for (std::size_t k = 0; k < 8; ++k) {
        batch[k] = 8 * j + k < by_distance_.size() ? by_distance_[8 * j + k].record : data_.tree.filler();
      }
      data_.batch_bound.push_back(by_distance_[8 * j].distance - error_);
    }
  }

  struct Entry {
    float distance;
    std::uint32_t record;
    bool kept;
  };
  CellData& data_;
  const CellOptions options_;
  float error_ = 0;                                 // m, twice what squared_distances may be off anywhere in the grid
  std::array<std::vector<std::uint32_t>, 4> list_;  // of the cubes of 1, 2, 4 and 8 cells under way
  std::vector<float> distance_;
  std::vector<Entry> by_distance_;
};

}  // namespace

CellData build_cells(const TriangleMesh& mesh, const CellOptions& options) {
  CellData data;
  data.surface = Surface(mesh);
  data.tree = FaceTree(data.surface);
  Builder(data, options).build();
  return data;
}

}  // namespace tactor
