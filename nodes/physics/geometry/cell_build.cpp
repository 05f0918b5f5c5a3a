// Makes the cells of a mesh: from blocks down to cells, each from the faces that its parent left.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "framework/core/check.hpp"
#include "nodes/physics/geometry/cell_distance.hpp"
#include "nodes/physics/geometry/outward.hpp"
#include "nodes/physics/geometry/wide.hpp"
#include "nodes/physics/mesh/bounds.hpp"

namespace tactor {

namespace {

// Longer lists are left to the tree: 15 batches are what a cell can count.
constexpr std::size_t most_batches = 15;

// About a minute and a gigabyte.
constexpr double most_cells = 1 << 25;
// They are all looked at, which takes as long; the finest grid with the widest band of a node has fewer.
constexpr double most_blocks = 1 << 23;

[[noreturn]] void too_many(const CellOptions& options) {
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(),
                "resolution %d with a band of %.3g m cuts the space about its mesh into more than %.0f million cells; "
                "lower the resolution or the band",
                options.resolution, options.band, most_cells / 1e6);
  throw InputError(text.data());
}

/// Faces and their distances to a point, in m.
struct Measured {
  std::vector<std::uint32_t> record;
  std::vector<float> distance;
  float least = 0;
};

/// Sets the distances to c, in floats; of faces that floats cannot measure, rounded from doubles.
TACTOR_WIDE void measure(const CellData& data, const Vec3& c, Measured& faces) {
  const Vec3 about = c - data.tree.origin;
  const auto x = static_cast<float>(about.x), y = static_cast<float>(about.y), z = static_cast<float>(about.z);
  const std::size_t count = faces.record.size();
  faces.distance.resize(count + 7);
  faces.least = std::numeric_limits<float>::infinity();
  for (std::size_t j = 0; j < count; j += 8) {
    const FaceRecord* face[8];
    for (std::size_t k = 0; k < 8; ++k) {
      face[k] = &data.tree.records[j + k < count ? faces.record[j + k] : data.tree.filler()];
    }
    alignas(32) float squared[8];
    wide::store(squared, wide::squared_distances(face, x, y, z));
    for (std::size_t k = 0; k < 8; ++k) {
      if (std::isnan(face[k]->a[0])) {
        squared[k] = static_cast<float>(data.surface.candidate(face[k]->face, c).squared);
      }
      faces.distance[j + k] = std::sqrt(squared[k]);
      faces.least = std::min(faces.least, faces.distance[j + k]);
    }
  }
}

class Builder {
 public:
  Builder(CellData& data, const CellOptions& options) : data_(data), options_(options) {
    const FaceTree& tree = data.tree;
    Bounds bounds;
    for (const auto& corners : data.surface.corners) {
      for (const Vec3& c : corners) bounds.add(c);
    }
    const Vec3 low = bounds.low, high = bounds.high, size = bounds.size();
    data.box_low = low;
    data.box_high = high;
    data.edge = bounds.longest() / options.resolution;
    double blocks = 1;
    for (int axis = 0; axis < 3; ++axis) blocks *= 1 + (size[axis] + 2 * options.band) / (8 * data.edge);
    if (!(blocks <= most_blocks)) too_many(options);
    for (int axis = 0; axis < 3; ++axis) {
      const auto n = static_cast<std::int32_t>(std::ceil((size[axis] + 2 * options.band) / (8 * data.edge)));
      data.blocks[static_cast<std::size_t>(axis)] = std::max(n, 1);
      data.low[axis] = 0.5 * (low[axis] + high[axis]) - 4 * data.edge * std::max(n, 1);
    }
    error_ = 2 * static_cast<float>(tree.error(data.low));
    kept_for_.resize(tree.records.size());
    place_.resize(tree.records.size());
    data.slack = std::ldexp(norm(low) + norm(high) + norm(data.low), -20);
  }

  void build() {
    const double block_radius = 4 * data_.edge * std::numbers::sqrt3;
    struct Near {
      std::size_t block;
      Vec3 centre;
      double distance;  // m
    };
    std::vector<Near> near;
    int hint = -1;
    for (std::int32_t k = 0; k < data_.blocks[2]; ++k) {
      for (std::int32_t j = 0; j < data_.blocks[1]; ++j) {
        for (std::int32_t i = 0; i < data_.blocks[0]; ++i) {
          const Vec3 centre = data_.low + 8 * data_.edge * Vec3{i + 0.5, j + 0.5, k + 0.5};
          const NearestFace nearest = data_.tree.nearest(data_.surface, centre, hint);
          hint = nearest.face;
          const double distance = data_.surface.signed_distance(nearest, centre).distance;
          if (std::abs(distance) <= options_.band + block_radius)
            near.push_back({data_.block.size(), centre, distance});
          data_.block.push_back({.distance = rounded_down(distance)});
        }
      }
    }
    if (512.0 * static_cast<double>(near.size()) > most_cells) too_many(options_);
    data_.cells.reserve(512 * near.size());
    for (const auto& [index, centre, distance] : near) {
      CellBlock& block = data_.block[index];
      block.cells = static_cast<std::int32_t>(data_.cells.size() / 512);
      palette_ = block.palette = static_cast<std::uint32_t>(data_.palette.size());
      data_.cells.resize(data_.cells.size() + 512);
      data_.palette.push_back(data_.tree.filler());
      data_.tree.within(centre, std::abs(distance) + 2 * block_radius, list_.back().record);
      measure(data_, centre, list_.back());
      cut(centre, 3, data_.cells.size() - 512, {0, 0, 0});
    }
    data_.palette.shrink_to_fit();
    data_.batches.shrink_to_fit();
    data_.batch_bound.shrink_to_fit();
  }

 private:
  /// A cube of 2^level cells, whose faces are list_[level].
  void cut(const Vec3& centre, int level, std::size_t first_cell, const std::array<std::size_t, 3>& corner) {
    const double edge = std::ldexp(data_.edge, level), radius = 0.5 * edge * std::numbers::sqrt3;
    const double distance = signed_distance(centre, list_[static_cast<std::size_t>(level + part_levels)]);
    if (level <= 1 && std::abs(distance) > options_.band + radius) {
      fill(distance, level, first_cell, corner);
      return;
    }
    if (level == 0) {
      Cell& cell = data_.cells[first_cell + corner[0] + 8 * (corner[1] + 8 * corner[2])];
      cell.distance = rounded_down(distance);
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
    const Measured& from = list_[static_cast<std::size_t>(level + part_levels)];
    Measured& to = list_[static_cast<std::size_t>(level + part_levels - 1)];
    for (std::size_t part = 0; part < 8; ++part) {
      const std::array<std::size_t, 3> at = {part & 1, part >> 1 & 1, part >> 2};
      const auto side = [&](std::size_t axis) { return at[axis] == 0 ? -0.25 * edge : 0.25 * edge; };
      const Vec3 c = centre + Vec3{side(0), side(1), side(2)};
      all_.record = from.record;
      measure(data_, c, all_);
      keep_near(all_, static_cast<float>(0.50002 * edge * std::numbers::sqrt3), to);
      use(c, at);
    }
  }

  /// The faces that are farther than the nearest by no more than `more` and rounding.
  void keep_near(const Measured& from, float more, Measured& to) const {
    to.record.clear();
    to.distance.clear();
    to.least = from.least;
    for (std::size_t i = 0; i < from.record.size(); ++i) {
      if (from.distance[i] > from.least + more + error_) continue;
      to.record.push_back(from.record[i]);
      to.distance.push_back(from.distance[i]);
    }
  }

  /// The signed distance of c from the faces near it.
  [[nodiscard]] double signed_distance(const Vec3& c, const Measured& near) const {
    wide::Search search = wide::search_about(data_.tree, data_.surface, c);
    for (std::size_t i = 0; i < near.record.size(); ++i) {
      if (near.distance[i] <= near.least + error_) search.look_at(data_.tree.records[near.record[i]].face);
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
              rounded_down(distance - norm(Vec3{at(i), at(j), at(k)}));
        }
      }
    }
  }

  /// Gives a cell the faces that can be nearest to a point of one of its parts, the nearest to its centre first.
  void add_list(const Vec3& centre, Cell& cell) {
    kept_.record.clear();
    ++cell_number_;
    collect_parts(centre, data_.edge, 0);
    const std::size_t count = (kept_.record.size() + 7) / 8;
    // A cell names its first batch by 28 bits.
    if (count > most_batches || data_.batches.size() + count > (std::size_t{1} << 28)) return;
    measure(data_, centre, kept_);
    by_distance_.clear();
    for (std::size_t i = 0; i < kept_.record.size(); ++i) by_distance_.emplace_back(kept_.distance[i], kept_.record[i]);
    std::sort(by_distance_.begin(), by_distance_.end());
    const std::size_t begin = palette_;
    // The palette of a block of a very fine mesh may be full.
    if (data_.palette.size() - begin + kept_.record.size() > 0xffff) return;
    cell.list = static_cast<std::uint32_t>(data_.batches.size() << 4 | count);
    for (std::size_t j = 0; j < count; ++j) {
      std::array<std::uint16_t, 8>& batch = data_.batches.emplace_back();
      batch.fill(0);
      for (std::size_t k = 0; k < 8 && 8 * j + k < by_distance_.size(); ++k) {
        const std::uint32_t record = by_distance_[8 * j + k].second;
        std::size_t& place = place_[record];
        if (place <= begin || place >= data_.palette.size() || data_.palette[place] != record) {
          place = data_.palette.size();
          data_.palette.push_back(record);
        }
        batch[k] = static_cast<std::uint16_t>(place - begin);
      }
      data_.batch_bound.push_back(by_distance_[8 * j].first - error_);
    }
  }

  /// Adds to kept_ what is left of list_ after part_levels more halvings.
  void collect_parts(const Vec3& centre, double edge, int level) {
    if (level == -part_levels) {
      for (const std::uint32_t record : list_[0].record) {
        if (kept_for_[record] == cell_number_) continue;
        kept_for_[record] = cell_number_;
        kept_.record.push_back(record);
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
  std::size_t palette_ = 0;  // where that of the block under way begins
  float error_ = 0;          // m, twice what squared_distances may be off anywhere in the grid
  // Of the cubes under way, the smallest parts of cells first.
  std::array<Measured, 4 + part_levels> list_;
  Measured all_, kept_;
  std::vector<std::uint32_t> kept_for_;  // of each record the number of the last cell whose kept_ it came to
  std::uint32_t cell_number_ = 0;
  std::vector<std::size_t> place_;  // of each record in the palette that it last came to
  std::vector<std::pair<float, std::uint32_t>> by_distance_;
};

}  // namespace

CellData build_cells(const TriangleMesh& mesh, const CellOptions& options) {
  TACTOR_DEMAND(options.resolution >= 8 && options.resolution <= 1024 && options.band >= 0);
  CellData data;
  data.surface = Surface(mesh);
  data.tree = FaceTree(data.surface);
  Builder(data, options).build();
  return data;
}

}  // namespace tactor
