#include "nodes/physics/deformable/spread_nodes.hpp"

#include <algorithm>
#include <limits>

namespace tactor {

std::vector<std::vector<int>> spread_nodes(const SoftScene& soft, int count) {
  const ElasticModel& model = soft.model;
  std::vector<std::vector<int>> spread(model.bodies().size());
  for (std::size_t b = 0; b < spread.size(); ++b) {
    const int first = model.first_node(static_cast<int>(b));
    const bool is_last = b + 1 == spread.size();
    const int end = is_last ? model.nodes() : model.first_node(static_cast<int>(b + 1));
    std::vector<int> nodes;
    for (const int node : soft.surface_nodes) {
      if (node >= first && node < end) nodes.push_back(node);
    }
    // m^2, of each node to the nearest of those that are fixed or chosen.
    std::vector<double> squared(nodes.size(), std::numeric_limits<double>::infinity());
    const auto come_near = [&](int other) {
      const Eigen::Vector3d p = model.rest().segment<3>(3 * other);
      for (std::size_t i = 0; i < nodes.size(); ++i) {
        squared[i] = std::min(squared[i], (model.rest().segment<3>(3 * nodes[i]) - p).squaredNorm());
      }
    };
    for (const int node : nodes) {
      if (model.unknown_of(node) < 0) come_near(node);
    }
    while (spread[b].size() < static_cast<std::size_t>(count)) {
      const auto farthest = std::max_element(squared.begin(), squared.end());
      if (farthest == squared.end() || !(*farthest > 0)) break;
      const int node = nodes[static_cast<std::size_t>(farthest - squared.begin())];
      spread[b].push_back(node);
      come_near(node);
    }
  }
  return spread;
}

}  // namespace tactor
