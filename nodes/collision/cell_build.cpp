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
    kept_for_.resize(tree.records.size());
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
          data_.tree.within(centre, std::abs(distance) + 2 * block_radius, list_.back());
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

  /// A cube of 2^level cells, whose faces are list_[level].
  void cut(const Vec3& centre, int level, std::size_t first_cell, const std::array<std::size_t, 3>& corner) {
    const std::vector<std::uint32_t>& list = list_[static_cast<std::size_t>(level + part_levels)];
    const double edge = std::ldexp(data_.edge, level), radius = 0.5 * edge * std::numbers::sqrt3;
    const double distance = signed_distance(centre, list);
    if (level <= 1 && std::abs(distance) > options_.band + radius) {
      fill(distance, level, first_cell, corner);
      return;
    }
    if (level == 0) {
      Cell& cell = data_.cells[first_cell + corner[0] + 8 * (corner[1] + 8 * corner[2])];
      cell.distance = lower(distance);
      add_list(centre, cell);
      return;
    }
    const std::size_t half = std::size_t{1} << level >> 1;
    for_parts(centre, edge, level, [&](const Vec3& c, const std::array<std::size_t, 3>& at) {
      cut(c, level - 1, first_cell, {corner[0] + half * at[0], corner[1] + half * at[1], corner[2] + half * at[2]});
    });
  }

  /// Calls `use` with the centre and place of the eight parts of a cube of edge `edge`, each time after those of its
  /// faces that can be nearest to a point of the part have been put into the list of the next level.
  template <class Use>
  void for_parts(const Vec3& centre, double edge, int level, const Use& use) {
    const auto from = static_cast<std::size_t>(level + part_levels);
    for (std::size_t part = 0; part < 8; ++part) {
      const std::array<std::size_t, 3> at = {part & 1, part >> 1 & 1, part >> 2};
      const auto side = [&](std::size_t axis) { return at[axis] == 0 ? -0.25 * edge : 0.25 * edge; };
      const Vec3 c = centre + Vec3{side(0), side(1), side(2)};
      const float radius = static_cast<float>(0.25001 * edge * std::numbers::sqrt3);
      const float limit = measure_at(c, list_[from]) + 2 * radius + error_;
      list_[from - 1].clear();
      for (std::size_t i = 0; i < list_[from].size(); ++i) {
        if (distance_[i] <= limit) list_[from - 1].push_back(list_[from][i]);
      }
      use(c, at);
    }
  }

  /// The signed distance of c, whose nearest face is in `list`.
  double signed_distance(const Vec3& c, const std::vector<std::uint32_t>& list) {
    wide::Search search = wide::search_about(data_.tree, data_.surface, c);
    const float limit = measure_at(c, list) + error_;
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (distance_[i] <= limit) search.look_at(data_.tree.records[list[i]].face);
    }
    return data_.surface.signed_distance(search.best, c).distance;
  }

  /// Beyond the band the distance of a small cube bounds those of its cells closely enough.
  void fill(double distance, int level, std::size_t first_cell, const std::array<std::size_t, 3>& corner) {
    const std::size_t cells = std::size_t{1} << level;
    const auto at = [&](std::size_t i) {
      return data_.edge * (static_cast<double>(i) + 0.5 - 0.5 * static_cast<double>(cells));
    };
    for (std::size_t k = 0; k < cells; ++k) {
      for (std::size_t j = 0; j < cells; ++j) {
        for (std::size_t i = 0; i < cells; ++i) {
          data_.cells[first_cell + corner[0] + i + 8 * (corner[1] + j + 8 * (corner[2] + k))].distance =
              lower(distance - norm(Vec3{at(i), at(j), at(k)}));
        }
      }
    }
  }

  /// Gives a cell the faces that can be nearest to a point of one of its parts, the nearest to its centre first.
  void add_list(const Vec3& centre, Cell& cell) {
    kept_.clear();
    ++cell_number_;
    collect_parts(centre, data_.edge, 0);
    const std::size_t count = (kept_.size() + 7) / 8;
    if (count > most_batches) return;
    measure_at(centre, kept_);
    by_distance_.clear();
    for (std::size_t i = 0; i < kept_.size(); ++i) by_distance_.emplace_back(distance_[i], kept_[i]);
    std::sort(by_distance_.begin(), by_distance_.end());
    cell.list = static_cast<std::uint32_t>(data_.batches.size() << 4 | count);
    for (std::size_t j = 0; j < count; ++j) {
      std::array<std::uint32_t, 8>& batch = data_.batches.emplace_back();
      for (std::size_t k = 0; k < 8; ++k) {
        batch[k] = 8 * j + k < by_distance_.size() ? by_distance_[8 * j + k].second : data_.tree.filler();
      }
      data_.batch_bound.push_back(by_distance_[8 * j].first - error_);
    }
  }

  /// Adds to kept_ what is left of list_ after part_levels more halvings.
  void collect_parts(const Vec3& centre, double edge, int level) {
    if (level == -part_levels) {
      for (const std::uint32_t record : list_[0]) {
        if (kept_for_[record] == cell_number_) continue;
        kept_for_[record] = cell_number_;
        kept_.push_back(record);
      }
      return;
    }
    for_parts(centre, edge, level,
              [&](const Vec3& c, const std::array<std::size_t, 3>&) { collect_parts(c, 0.5 * edge, level - 1); });
  }

  // A cell's list is made of those of its parts after so many halvings, which are shorter than one for the whole cell:
  // each level takes a quarter off them and costs a third of the time of building.
  static constexpr int part_levels = 1;

  CellData& data_;
  const CellOptions options_;
  float error_ = 0;  // m, twice what squared_distances may be off anywhere in the grid
  // Of the cubes under way, the smallest parts of cells first.
  std::array<std::vector<std::uint32_t>, 4 + part_levels> list_;
  std::vector<std::uint32_t> kept_;
  std::vector<std::uint32_t> kept_for_;  // of each record the number of the last cell whose kept_ it came to
  std::uint32_t cell_number_ = 0;
  std::vector<float> distance_;
  std::vector<std::pair<float, std::uint32_t>> by_distance_;
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
