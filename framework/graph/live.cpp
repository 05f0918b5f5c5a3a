// The `live` key of a graph: what a run with a real clock asks of the system and does where it does not get it.
#include "framework/graph/readers.hpp"
#include "framework/graph/scheduling_words.hpp"
#include "framework/graph/values.hpp"

namespace tactor {

namespace {

void read_pool(LiveSettings& live, const Tree& tree, Diagnostics& diagnostics) {
  const std::string path = "live.pool";
  if (!expect_map(tree, path, "a map of the pool's settings", diagnostics)) return;
  check_keys(tree, path, "key", {"workers", "policy", "priority", "cpu"}, diagnostics);
  const auto whole = [&](const std::string& key, int min, int max) -> std::optional<int> {
    const Tree* value = tree.value(key);
    if (value == nullptr) return std::nullopt;
    const auto number = read_integer(*value, path + "." + key, min, max, diagnostics);
    return number ? std::optional(static_cast<int>(*number)) : std::nullopt;
  };
  live.pool_workers = whole("workers", 1, max_pool_workers).value_or(live.pool_workers);
  live.pool.cpu = whole("cpu", 0, highest_cpu);
  const std::optional<int> priority = whole("priority", lowest_priority, highest_priority);
  if (priority) live.pool.priority = *priority;
  if (const Tree* policy = tree.value("policy")) {
    const auto text = read_choice(*policy, path + ".policy", policy_words, diagnostics);
    if (text) live.pool.policy = value_of<SchedulingPolicy>(*text, policy_words);
  }
  if (live.pool.policy != SchedulingPolicy::other) return;
  live.pool.priority = 0;
  if (priority) {
    diagnostics.error(tree.value("priority")->place,
                      path + ".priority: expected it with policy fifo or round_robin, found policy other");
  }
}

}  // namespace

LiveSettings read_live(const Tree& tree, Diagnostics& diagnostics) {
  LiveSettings live;
  if (!expect_map(tree, "live", "a map of settings for a run with clock: real", diagnostics)) return live;
  check_keys(tree, "live", "key", {"on_missing_privilege", "on_stall", "stall_timeout", "impose_cost", "pool"},
             diagnostics);
  if (const Tree* value = tree.value("on_missing_privilege")) {
    const auto text = read_choice(*value, "live.on_missing_privilege", on_missing_privilege_words, diagnostics);
    if (text) live.on_missing_privilege = value_of<OnMissingPrivilege>(*text, on_missing_privilege_words);
  }
  if (const Tree* value = tree.value("on_stall")) {
    const auto text = read_choice(*value, "live.on_stall", on_stall_words, diagnostics);
    if (text) live.on_stall = value_of<OnStall>(*text, on_stall_words);
  }
  if (const Tree* value = tree.value("stall_timeout")) {
    live.stall_timeout = read_duration(*value, "live.stall_timeout", true, diagnostics).value_or(live.stall_timeout);
  }
  if (const Tree* value = tree.value("impose_cost")) {
    live.impose_cost = read_boolean(*value, "live.impose_cost", diagnostics).value_or(false);
  }
  if (const Tree* pool = tree.value("pool")) read_pool(live, *pool, diagnostics);
  return live;
}

}  // namespace tactor
