// Sets that grow together: which things hang together, found pair by pair.
#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

namespace tactor {

/// The things 0 to size - 1, at first each in a set of its own.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  /// The same number for all things of a set.
  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(std::size_t i, std::size_t j) { parent_[root(i)] = root(j); }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace tactor
