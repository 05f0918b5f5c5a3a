#include "framework/engine/cost.hpp"

#include <algorithm>
#include <boost/random/normal_distribution.hpp>
#include <string>
#include <utility>

#include "framework/core/random.hpp"

namespace tactor {

CostDraw::CostDraw(CostModel model, std::uint64_t seed, std::string_view node)
    : model_(std::move(model)), engine_(derive_seed(seed, "cost of " + std::string(node))) {}

Duration CostDraw::next(std::int64_t items) {
  const CostModel& m = model_;
  Duration cost;
  switch (m.kind) {
    case CostModel::Kind::none:
      return {};
    case CostModel::Kind::constant:
      cost = m.base;
      break;
    case CostModel::Kind::per_item:
      cost = m.base + m.each * items;
      break;
    case CostModel::Kind::trace:
      cost = m.trace[trace_index_];
      trace_index_ = (trace_index_ + 1) % m.trace.size();
      break;
  }
  if (m.jitter > 0) {
    const double z =
        std::clamp(boost::random::normal_distribution<double>()(engine_), -most_deviations, most_deviations);
    cost = Duration::from_seconds(cost.seconds() * (1.0 + m.jitter * z));
  }
  cost = std::max({cost, m.min, Duration{}});
  if (m.max) cost = std::min(cost, *m.max);
  return cost;
}

}  // namespace tactor
