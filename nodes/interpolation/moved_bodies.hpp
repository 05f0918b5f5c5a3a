// How many bodies of a scene a rollout has moved.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace tactor {

/// Counts of bodies, one a model that was taken into use. Allocates nothing.
class MovedBodies {
 public:
  /// Counts above 63 count as that.
  void note(int bodies) {
    ++times_[static_cast<std::size_t>(std::clamp(bodies, 0, static_cast<int>(times_.size()) - 1))];
    ++all_;
  }
  [[nodiscard]] bool any() const { return all_ > 0; }
  /// The count that `share` of all counts, 0 to 1, are not above: 0 the least, 0.5 the median, 1 the most. 0 where
  /// there is none.
  [[nodiscard]] int quantile(double share) const {
    std::int64_t below = 0;
    for (std::size_t bodies = 0; bodies < times_.size(); ++bodies) {
      below += times_[bodies];
      if (below > 0 && static_cast<double>(below) >= share * static_cast<double>(all_)) return static_cast<int>(bodies);
    }
    return 0;
  }

 private:
  std::array<std::int64_t, 64> times_{};
  std::int64_t all_ = 0;
};

}  // namespace tactor
