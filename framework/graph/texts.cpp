#include "framework/graph/texts.hpp"

#include "framework/graph/values.hpp"

namespace tactor {

std::string queue_text(const Queue& queue) {
  const char* policy = "latest";
  switch (queue.policy) {
    case QueuePolicy::latest:
      return policy;
    case QueuePolicy::drop_oldest:
      policy = "drop_oldest";
      break;
    case QueuePolicy::drop_newest:
      policy = "drop_newest";
      break;
    case QueuePolicy::block:
      policy = "block";
      break;
  }
  return "queue(" + std::to_string(queue.capacity) + ", " + policy + ")";
}

std::string duration_text(Duration duration) {
  if (duration == until_stopped) return std::string(until_stopped_text);
  const auto of = [&](std::int64_t unit, const char* name) {
    return number_text(static_cast<double>(duration.ns) / static_cast<double>(unit)) + " " + name;
  };
  if (duration.ns >= 1'000'000'000) return of(1'000'000'000, "s");
  if (duration.ns >= 1'000'000 || duration.ns == 0) return of(1'000'000, "ms");
  return of(1'000, "us");
}

std::string cost_text(const CostModel& cost) {
  std::string text;
  switch (cost.kind) {
    case CostModel::Kind::none:
      return "none";
    case CostModel::Kind::trace:
      return "trace of " + std::to_string(cost.trace.size()) + " steps";
    case CostModel::Kind::constant:
      text = duration_text(cost.base);
      break;
    case CostModel::Kind::per_item:
      text = duration_text(cost.base) + " + " + duration_text(cost.each) + " a contact";
      break;
  }
  if (cost.jitter > 0) text += ", jitter " + number_text(cost.jitter * 100) + " %";
  if (cost.min.ns > 0) text += ", at least " + duration_text(cost.min);
  if (cost.max) text += ", at most " + duration_text(*cost.max);
  return text;
}

std::string motion_text(const Scene& scene) {
  if (scene.tool() == nullptr) return "nothing moves";
  return scene.rotates() ? "6 degrees of freedom" : "translation-only";
}

}  // namespace tactor
