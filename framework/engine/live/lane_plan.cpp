#include "framework/engine/live/lane_plan.hpp"

#include <unistd.h>

#include <algorithm>
#include <map>

#include "framework/core/check.hpp"
#include "framework/realtime/make_thread.hpp"
#include "framework/realtime/thread_policy.hpp"

namespace tactor {

namespace {

constexpr ThreadSettings realtime_default{SchedulingPolicy::fifo, 80, std::nullopt};
constexpr int priority_without_one = 1;

void check_core(const std::optional<int>& cpu, int cores, const std::string& what) {
  if (!cpu || *cpu < cores) return;
  throw InputError(what + ": cpu: expected a core of this machine, 0 to " + std::to_string(cores - 1) + ", found " +
                   std::to_string(*cpu));
}

/// Whether a thread of this process may be SCHED_FIFO; tried on one.
bool realtime_is_granted() {
  ThreadGrant grant;
  make_thread("trial", [&grant] { grant = apply_thread_settings(realtime_default, "trial"); }).join();
  return grant.granted.policy == SchedulingPolicy::fifo;
}

/// What the node says over `settings`.
void lay_over(const Scheduling& said, ThreadSettings& settings) {
  if (said.policy && *said.policy != settings.policy) {
    settings.policy = *said.policy;
    settings.priority = *said.policy == SchedulingPolicy::other ? 0 : priority_without_one;
  }
  if (said.priority) settings.priority = *said.priority;
  if (said.cpu) settings.cpu = said.cpu;
}

int core_count() {
  return static_cast<int>(std::max(1L, sysconf(_SC_NPROCESSORS_ONLN)));
}

}  // namespace

LanePlan plan_lanes(const Plan& plan, int cores, const std::vector<int>& usable, bool realtime_granted) {
  TACTOR_DEMAND(!usable.empty());
  LanePlan result;
  result.lanes.push_back({"pool", plan.graph.live.pool_workers, plan.graph.live.pool});
  check_core(plan.graph.live.pool.cpu, cores, plan.graph.file.string() + ": live.pool");
  std::map<std::string, std::size_t> threads;
  int in_pool = 0;
  for (const NodeSpec& node : plan.nodes) {
    const Scheduling& said = node.scheduling;
    check_core(said.cpu, cores, node.place.text() + ": nodes." + node.name);
    result.lane_of.push_back(0);
    result.realtime.emplace_back();
    switch (said.lane) {
      case Lane::pool:
        ++in_pool;
        break;
      case Lane::thread: {
        // A name that no graph can give a thread, for the node that has one to itself.
        const std::string name = said.thread.empty() ? "/" + node.name : said.thread;
        const auto [at, made] = threads.try_emplace(name, result.lanes.size());
        if (made) result.lanes.push_back({said.thread.empty() ? node.name : said.thread, 1, {}});
        lay_over(said, result.lanes[at->second].settings);
        result.lane_of.back() = at->second;
        break;
      }
      case Lane::realtime: {
        ThreadSettings settings = realtime_default;
        if (usable.size() > 1 && realtime_granted) settings.cpu = usable.back();
        lay_over(said, settings);
        result.realtime.back() = settings;
        break;
      }
    }
  }
  result.chains = find_chains(plan);
  int& workers = result.lanes[0].workers;
  if (workers == 0) workers = std::clamp(in_pool, 1, static_cast<int>(usable.size()));
  return result;
}

LanePlan plan_lanes(const Plan& plan) {
  std::vector<int> usable = usable_cores();
  if (usable.empty()) usable = {0};  // not told, as on a machine with more cores than the C library's set has
  return plan_lanes(plan, core_count(), usable, realtime_is_granted());
}

std::string check_privileges(const Plan& plan, const LanePlan& lanes, const ThreadSettings& timer) {
  const bool must_have = plan.graph.live.on_missing_privilege == OnMissingPrivilege::fail;
  const bool hardware = std::any_of(plan.nodes.begin(), plan.nodes.end(),
                                    [](const NodeSpec& node) { return node.info->hardware.has_value(); });
  if (!must_have && !hardware) return {};
  std::vector<ThreadSettings> settings{timer};
  for (const LaneSpec& lane : lanes.lanes) settings.push_back(lane.settings);
  for (const auto& loop : lanes.realtime) {
    if (loop) settings.push_back(*loop);
  }
  const std::vector<Refusal> refused = missing_privileges(settings);
  if (refused.empty()) return {};
  if (!must_have) {
    std::string names;
    for (const Refusal& refusal : refused) names += (names.empty() ? "" : ", ") + refusal.what;
    return "the system refuses real-time privileges (" + names +
           "): while other programs work, ticks come late by milliseconds; the force is then cut and comes back by its "
           "ramp. See docs/howto/real_time.md";
  }
  std::string text = plan.graph.file.string() + ": on_missing_privilege is fail, and this system refuses:";
  for (const Refusal& refusal : refused) text += "\n  " + describe(refusal);
  throw RunError(text);
}

}  // namespace tactor
