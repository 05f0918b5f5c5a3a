// The keys of `live` in a graph file, each described once (see framework/fields/fields.hpp).
#pragma once

#include "framework/core/scheduling.hpp"
#include "framework/fields/fields.hpp"
#include "framework/graph/scheduling_words.hpp"

namespace tactor {

class FieldCheck;

template <class Visit>
void fields(Visit& visit, LiveSettings& live) {
  visit.choice("on_missing_privilege", live.on_missing_privilege, on_missing_privilege_words,
               {.doc = "where `fifo` or locked memory is refused"});
  visit.choice(
      "on_stall", live.on_stall, on_stall_words,
      {.doc = "where a step does not come back: `stop` ends the run, `recover` keeps the force at zero until it does"});
  visit.field("stall_timeout", live.stall_timeout,
              {.doc = "a step that takes longer has stalled", .unit = "s", .min = 0, .above_min = true});
  visit.field("impose_cost", live.impose_cost, {.doc = "a step takes at least its declared cost"});
  visit.choice(
      "flight", live.flight, flight_words,
      {.doc = "the last minute of the run, for `tactor flight`: `auto` records it where hardware is driven, and "
              "keeps the file where something went wrong; `keep` always does both"});
  visit.map("pool", {.doc = "the threads of all light nodes"}, [&live](auto& pool) {
    pool.only(live.pool_workers > 0, "", [&] {
      pool.field("workers", live.pool_workers,
                 {.doc = "threads of the pool; absent: the run chooses", .min = 1, .max = max_pool_workers});
    });
    pool.choice("policy", live.pool.policy, policy_words, {.doc = "as of nodes"});
    pool.only(live.pool.policy != SchedulingPolicy::other,
              "expected it with policy fifo or round_robin, found policy other", [&] {
                pool.field("priority", live.pool.priority,
                           {.doc = "as of nodes; below the devices, above the threads",
                            .min = lowest_priority,
                            .max = highest_priority});
              });
    pool.field("cpu", live.pool.cpu, {.doc = "the core of its threads; absent: any", .min = 0, .max = highest_cpu});
  });
}

void check(LiveSettings& live, const FieldCheck& map);

}  // namespace tactor
