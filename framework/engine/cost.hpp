// Draws what a step costs under the virtual clock, from the graph's cost model and the run's seed.
#pragma once

#include <boost/random/mersenne_twister.hpp>
#include <cstdint>
#include <string_view>

#include "framework/graph/spec.hpp"

namespace tactor {

/// The costs of one node's steps, in order. The same model, seed and node name give the same costs.
class CostDraw {
 public:
  /// The draw of a cost with jitter is cut at so many standard deviations.
  static constexpr double most_deviations = 3;

  CostDraw(CostModel model, std::uint64_t seed, std::string_view node);

  /// The cost of the next step, which worked on `items` items. Never negative.
  Duration next(std::int64_t items);

 private:
  CostModel model_;
  boost::random::mt19937_64 engine_;
  std::size_t trace_index_ = 0;
};

}  // namespace tactor
