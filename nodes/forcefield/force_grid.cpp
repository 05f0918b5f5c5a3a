#include "nodes/forcefield/force_grid.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

using Index = std::array<std::int64_t, 3>;

constexpr int bits = 21;  // of each index in a key
constexpr double most_index = (1 << (bits - 1)) - 64;

std::uint64_t key_of(const Index& i) {
  std::uint64_t key = 0;
  for (const std::int64_t n : i) key = (key << bits) | (static_cast<std::uint64_t>(n) & ((1U << bits) - 1));
  return key;
}

Index corner(const Index& low, int c) {
  return {low[0] + (c & 1), low[1] + (c >> 1 & 1), low[2] + (c >> 2 & 1)};
}

double weight(const Vec3& share, int c) {
  const double x = (c & 1) != 0 ? share.x : 1 - share.x;
  const double y = (c & 2) != 0 ? share.y : 1 - share.y;
  const double z = (c & 4) != 0 ? share.z : 1 - share.z;
  return x * y * z;
}

}  // namespace

ForceGrid::ForceGrid(const Options& options)
    : cell_(options.cell),
      reach_cells_(options.reach / options.cell),
      forgetting_(options.forgetting),
      ring_(static_cast<std::int64_t>(std::ceil(reach_cells_ - 1e-9))),
      table_(ways * std::bit_ceil((static_cast<std::size_t>(options.nodes) + ways - 1) / ways)) {
  TACTOR_DEMAND(options.nodes > 0 && options.cell > 0 && ring_ >= 0 && ring_ <= most_reach_cells);
}

bool ForceGrid::cell_of(const Vec3& p, Cell& cell) const {
  for (int axis = 0; axis < 3; ++axis) {
    const double x = p[axis] / cell_;
    if (!(std::abs(x) < most_index)) return false;  // not where x is NaN
    const double low = std::floor(x);
    cell.low[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(low);
    cell.share[axis] = x - low;
  }
  return true;
}

std::size_t ForceGrid::set_of(std::uint64_t key) const {
  // The mixing of splitmix64: neighbours go to sets far apart.
  key = (key ^ (key >> 30)) * 0xbf58476d1ce4e5b9ULL;
  key = (key ^ (key >> 27)) * 0x94d049bb133111ebULL;
  return static_cast<std::size_t>(key ^ (key >> 31)) & (table_.size() / ways - 1);
}

const ForceGrid::Entry* ForceGrid::find(std::uint64_t key) const {
  const Entry* set = &table_[ways * set_of(key)];
  for (std::size_t way = 0; way < ways; ++way) {
    if (set[way].used != 0 && set[way].key == key) return &set[way];
  }
  return nullptr;
}

ForceGrid::Entry* ForceGrid::find(std::uint64_t key) {
  return const_cast<Entry*>(std::as_const(*this).find(key));
}

ForceGrid::Entry& ForceGrid::find_or_insert(std::uint64_t key, const Vec3& force) {
  if (Entry* known = find(key)) return *known;
  Entry* set = &table_[ways * set_of(key)];
  Entry* oldest = set;
  for (std::size_t way = 1; way < ways; ++way) {
    if (set[way].used < oldest->used) oldest = &set[way];
  }
  ++(oldest->used == 0 ? stored_ : evicted_);
  *oldest = {key, clock_, force};
  return *oldest;
}

bool ForceGrid::store(const Vec3& p, const Vec3& force) {
  Cell cell;
  if (!cell_of(p, cell)) return false;
  ++clock_;
  double squares = 0;
  for (int c = 0; c < 8; ++c) {
    const double w = weight(cell.share, c);
    if (w == 0) continue;
    // Marked before any is inserted, so that none of them has to make room.
    if (Entry* known = find(key_of(corner(cell.low, c)))) known->used = clock_;
    squares += w * w;
  }
  for (int c = 0; c < 8; ++c) {
    const double w = weight(cell.share, c);
    if (w == 0) continue;
    Entry& entry = find_or_insert(key_of(corner(cell.low, c)), force);
    entry.force += (forgetting_ * std::min(1.0, w / squares)) * (force - entry.force);
  }
  return true;
}

ForceGrid::Look ForceGrid::look(const Vec3& p, const Vec3& otherwise) const {
  Cell cell;
  if (!cell_of(p, cell)) return {otherwise, Known::nothing};
  Look result{{}, Known::stored};
  std::array<double, 8> missing{};  // weights of the corners that are not stored
  for (int c = 0; c < 8; ++c) {
    const double w = weight(cell.share, c);
    if (w == 0) continue;
    if (const Entry* known = find(key_of(corner(cell.low, c)))) {
      result.force += w * known->force;
    } else {
      missing[static_cast<std::size_t>(c)] = w;
      result.known = Known::extrapolated;
    }
  }
  if (result.known == Known::stored) return result;

  std::array<Vec3, 8> sum{};
  std::array<double, 8> total{};
  for (std::int64_t z = -ring_; z <= ring_ + 1; ++z) {
    for (std::int64_t y = -ring_; y <= ring_ + 1; ++y) {
      for (std::int64_t x = -ring_; x <= ring_ + 1; ++x) {
        const Entry* known = find(key_of({cell.low[0] + x, cell.low[1] + y, cell.low[2] + z}));
        if (known == nullptr) continue;
        for (std::size_t c = 0; c < 8; ++c) {
          if (missing[c] == 0) continue;
          const Index to = corner({-x, -y, -z}, static_cast<int>(c));
          const auto squared = static_cast<double>(to[0] * to[0] + to[1] * to[1] + to[2] * to[2]);
          if (squared > reach_cells_ * reach_cells_ * (1 + 1e-9)) continue;
          sum[c] += known->force / squared;
          total[c] += 1 / squared;
        }
      }
    }
  }
  for (std::size_t c = 0; c < 8; ++c) {
    if (missing[c] == 0) continue;
    if (total[c] == 0) result.known = Known::nothing;
    result.force += missing[c] * (total[c] > 0 ? sum[c] / total[c] : otherwise);
  }
  return result;
}

}  // namespace tactor
