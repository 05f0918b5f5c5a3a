// Forces on the nodes of a regular grid, stored where they were felt and interpolated between.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "framework/core/spatial.hpp"

namespace tactor {

/// A sparse grid of forces with fixed storage. Node i is at cell * i; between nodes the force is trilinear,
///   F(p) = sum_i w_i(p) F_i over the 8 corners of the cell of p, sum_i w_i = 1.
/// A sample (p, F) draws its corners towards itself, and those that were not stored before begin at F:
///   F_i += forgetting * min(1, w_i / sum_j w_j^2) * (F - F_i).
/// So every stored force is a mean of forces that were felt. A sample on a node is met exactly where `forgetting` is 1,
/// in the middle of a cell too; elsewhere the grid keeps something of what the corner's other cells felt. (The
/// correction that meets every sample, F_i += w_i / sum_j w_j^2 * (F - F(p)), has up to three times the error on
/// forces with friction: two forces felt close to each other tilt the field.)
///
/// Where corners of a cell are not stored they are extrapolated from the stored nodes within `reach` of them, weighted
/// by 1 / distance^2 (D. Shepard, "A two-dimensional interpolation function for irregularly-spaced data", ACM 1968).
/// F(p) is therefore a mean of forces that were felt, never larger than the largest, and continuous in p as long as
/// nothing is stored.
///
/// The storage is a hash table of sets of 8 nodes each. A node that comes to a full set takes the place of the one that
/// was stored longest ago, which is counted; so the table always takes what is new and forgets what is old. A table is
/// about half full when sets begin to be. Storing and looking allocate nothing and take a bounded time.
class ForceGrid {
 public:
  /// The most cells that `reach` may span.
  static constexpr int most_reach_cells = 3;

  struct Options {
    double cell = 0;         ///< m, above 0
    double reach = 0;        ///< m, at most most_reach_cells * cell
    double forgetting = 1;   ///< above 0, at most 1
    std::int64_t nodes = 0;  ///< the table's size, rounded up to the next 8 * 2^n
  };
  enum class Known : std::uint8_t {
    stored,        ///< all corners that count are stored
    extrapolated,  ///< some are extrapolated
    nothing,       ///< some have no stored node within reach: `otherwise` stands in for them
  };
  struct Look {
    Vec3 force;  ///< N
    Known known = Known::nothing;
  };

  explicit ForceGrid(const Options& options);

  /// Takes a finite force in N, felt at p (m, W). False, and nothing is changed, where p is not finite or a million
  /// cells away from the origin.
  bool store(const Vec3& p, const Vec3& force);

  /// The force at p; `otherwise` where nothing is known.
  [[nodiscard]] Look look(const Vec3& p, const Vec3& otherwise) const;

  [[nodiscard]] std::int64_t stored() const { return stored_; }    ///< nodes that are in the table
  [[nodiscard]] std::int64_t evicted() const { return evicted_; }  ///< nodes that had to make room
  [[nodiscard]] std::int64_t capacity() const { return static_cast<std::int64_t>(table_.size()); }
  [[nodiscard]] std::size_t memory_bytes() const { return table_.size() * sizeof(Entry); }

 private:
  static constexpr std::size_t ways = 8;  // as many as a cell has corners, so that these never evict each other

  struct Entry {
    std::uint64_t key = 0;
    std::uint64_t used = 0;  // when it was stored last, 0: free
    Vec3 force;              // N
  };
  struct Cell {
    std::array<std::int64_t, 3> low{};
    Vec3 share;  // 0 to 1, from the low corner to the high one
  };
  [[nodiscard]] bool cell_of(const Vec3& p, Cell& cell) const;
  [[nodiscard]] const Entry* find(std::uint64_t key) const;
  [[nodiscard]] Entry* find(std::uint64_t key);
  Entry& find_or_insert(std::uint64_t key, const Vec3& force);
  [[nodiscard]] std::size_t set_of(std::uint64_t key) const;

  double cell_;
  double reach_cells_;
  double forgetting_;
  std::int64_t ring_;  // cells around a cell that extrapolation looks at
  std::vector<Entry> table_;
  std::uint64_t clock_ = 0;
  std::int64_t stored_ = 0, evicted_ = 0;
};

}  // namespace tactor
