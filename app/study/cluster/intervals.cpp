#include "app/study/cluster/intervals.hpp"

#include <fmt/format.h>

#include "app/study/cluster/plan_fields.hpp"
#include "app/study/cluster/shard.hpp"

namespace tactor {

namespace {

/// What intervals.bin holds.
struct FoundIntervals {
  std::string plan;     // its key
  std::string refusal;  // why the study is refused; empty: it is not
  std::vector<JudgedFrom> judged;
};
void fields(auto& bytes, SameAs<FoundIntervals> auto& found) {
  bytes(found.plan, found.refusal, found.judged);
}

}  // namespace

int find_intervals(const ClusterPlan& plan, const ClusterFolder& folder) {
  FoundIntervals found{plan.key, {}, plan.planned.judged};
  std::map<std::size_t, Warmth> warmths;
  const Stage* stage = plan.stage(StageKind::warm);
  for (std::size_t chunk = 0; stage != nullptr && chunk < stage->chunks(); ++chunk) {
    const std::optional<Shard> shard = read_shard(folder.shard(StageKind::warm, chunk));
    if (!shard || !shard->complete || !shard->head.is_of(plan.key, name_of(StageKind::warm), chunk)) {
      throw RunError(fmt::format("{}: expected a complete shard, found {}; --resume makes it again",
                                 folder.shard(StageKind::warm, chunk).string(), shard ? "a damaged one" : "none"));
    }
    for (const auto& [unit, answer] : shard->records) {
      auto warm_up = from_message<WarmUp>(answer);
      // A run that fails before it is warm fails again, and is a row that says so.
      if (warm_up.failure.empty()) warmths[plan.run_of(*stage, unit)] = std::move(warm_up.warmth);
    }
  }
  try {
    found.judged = judged_intervals(plan.planned, warmths);
  } catch (const InputError& error) {
    found.refusal = error.what();
  }
  publish_checked(to_bytes(found), folder.intervals());
  if (!found.refusal.empty()) throw InputError(found.refusal);
  return 0;
}

bool has_intervals(const ClusterPlan& plan, const ClusterFolder& folder) {
  try {
    static_cast<void>(read_intervals(plan, folder));
  } catch (const RunError&) {
    return false;
  } catch (const InputError&) {
    // They say that the study is refused.
  }
  return true;
}

std::vector<JudgedFrom> read_intervals(const ClusterPlan& plan, const ClusterFolder& folder) {
  if (plan.stage(StageKind::warm) == nullptr) return plan.planned.judged;
  const std::optional<std::string> bytes = read_checked(folder.intervals());
  if (!bytes) {
    throw RunError(
        "the time at which runs are warm is not known yet, because tasks of the stage warm are missing; --resume runs "
        "them");
  }
  const auto found = from_bytes<FoundIntervals>(*bytes);
  if (found.plan != plan.key) throw RunError(folder.intervals().string() + ": it is of another study");
  if (!found.refusal.empty()) throw InputError(found.refusal);
  return found.judged;
}

}  // namespace tactor
