// The lanes of a graph's nodes: what the node types and the keys of the nodes say, checked thread by thread.
#include <algorithm>
#include <map>

#include "framework/graph/readers.hpp"
#include "framework/graph/scheduling_words.hpp"
#include "framework/graph/values.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace {

// Devices come before everything else; computing threads that ask for a real-time policy come after the pool (50),
// whose steps are short.
constexpr int realtime_priority = 80;
constexpr int thread_priority = 40;

SchedulingPolicy default_policy(Lane lane) {
  return lane == Lane::realtime ? SchedulingPolicy::fifo : SchedulingPolicy::other;
}

int default_priority(Lane lane) {
  return lane == Lane::realtime ? realtime_priority : thread_priority;
}

// A key of a node that is there and in order.
template <class T>
struct Given {
  T value{};
  std::string path;
  const Tree* tree = nullptr;
};

// What one node says of its thread.
struct ThreadKeys {
  NodeSpec* node = nullptr;
  std::optional<Given<SchedulingPolicy>> policy;
  std::optional<Given<int>> priority;
  std::optional<Given<int>> cpu;
  bool policy_is_broken = false;  // its own error is told already
};

template <class T, class Read>
std::optional<Given<T>> given(const Tree& node, const std::string& path, const std::string& key, const Read& read) {
  const Tree* tree = node.value(key);
  if (tree == nullptr) return std::nullopt;
  const std::string full = path + "." + key;
  const auto value = read(*tree, full);
  if (!value) return std::nullopt;
  return Given<T>{*value, full, tree};
}

std::string types_for_realtime(Registry& registry) {
  try {
    registry.load_all();
  } catch (const InputError&) {
    // A broken library has no types to offer; an error of its own is told where a graph needs it.
  }
  std::vector<std::string> names;
  for (const NodeInfo* info : registry.types()) {
    if (info->realtime_safe && info->rate_parameter) names.push_back(info->type);
  }
  return names.empty() ? "none is known" : list_of(names);
}

bool check_realtime(const NodeInfo& info, const Tree& lane, const std::string& path, Registry& registry,
                    Diagnostics& diagnostics) {
  const bool changes_size = std::any_of(info.outputs.begin(), info.outputs.end(),
                                        [](const OutputInfo& output) { return !output.type->arrays.empty(); });
  if (info.realtime_safe && info.rate_parameter && !changes_size) return true;
  const std::string why = !info.python.empty()   ? " runs in Python, which allocates and waits in a step"
                          : !info.realtime_safe  ? " may allocate or wait in a step"
                          : !info.rate_parameter ? " has no rate"
                                                 : " sends messages that change their size";
  diagnostics.error(lane.place, path + ": realtime expects a node type that steps at a rate and never waits, found " +
                                    info.type + ", which" + why +
                                    "; types for realtime: " + types_for_realtime(registry));
  return false;
}

// The lane of a node; nothing where the graph says it wrongly.
std::optional<Lane> read_lane(const NodeInfo& info, const Tree& node, const std::string& path, Registry& registry,
                              Diagnostics& diagnostics) {
  const Tree* tree = node.value("lane");
  if (tree == nullptr) return info.lane;
  const auto text = read_choice(*tree, path + ".lane", lane_words, diagnostics);
  if (!text) return std::nullopt;
  const Lane lane = value_of<Lane>(*text, lane_words);
  if (lane == Lane::realtime && !check_realtime(info, *tree, path + ".lane", registry, diagnostics)) {
    return std::nullopt;
  }
  return lane;
}

std::string found_lane(const NodeInfo& info, const Tree& node, Lane lane) {
  return "found lane " + word(lane) + (node.value("lane") == nullptr ? " (the default of " + info.type + ")" : "");
}

std::string read_thread(const NodeInfo& info, const Tree& node, const std::string& path, Lane lane,
                        Diagnostics& diagnostics) {
  const TreeEntry* thread = node.find("thread");
  if (thread == nullptr) return lane == info.lane ? info.thread : std::string();
  const std::string full = path + ".thread";
  if (lane != Lane::thread) {
    diagnostics.error(thread->place, full + ": expected it with lane thread, " + found_lane(info, node, lane) +
                                         "; add lane: thread, or remove it");
    return {};
  }
  const auto name = read_text(thread->value, full, diagnostics);
  if (!name || !check_name({*name, thread->value.place, {}}, full, diagnostics)) return {};
  return *name;
}

ThreadKeys read_thread_keys(NodeSpec& spec, const Tree& node, const std::string& path, Diagnostics& diagnostics) {
  const auto whole = [&](int min, int max) {
    return [&diagnostics, min, max](const Tree& tree, const std::string& full) -> std::optional<int> {
      const auto value = read_integer(tree, full, min, max, diagnostics);
      return value ? std::optional(static_cast<int>(*value)) : std::nullopt;
    };
  };
  ThreadKeys keys;
  keys.node = &spec;
  keys.policy = given<SchedulingPolicy>(
      node, path, "policy", [&](const Tree& tree, const std::string& full) -> std::optional<SchedulingPolicy> {
        const auto text = read_choice(tree, full, policy_words, diagnostics);
        return text ? std::optional(value_of<SchedulingPolicy>(*text, policy_words)) : std::nullopt;
      });
  keys.policy_is_broken = node.value("policy") != nullptr && !keys.policy;
  keys.priority = given<int>(node, path, "priority", whole(lowest_priority, highest_priority));
  keys.cpu = given<int>(node, path, "cpu", whole(0, highest_cpu));
  return keys;
}

// The pool's threads are everybody's, so no single node sets them.
void refuse_in_pool(const NodeInfo& info, const Tree& node, const std::string& path, Diagnostics& diagnostics) {
  for (const char* key : {"policy", "priority", "cpu"}) {
    const TreeEntry* entry = node.find(key);
    if (entry == nullptr) continue;
    diagnostics.error(entry->place, path + "." + key + ": expected it with lane thread or realtime, " +
                                        found_lane(info, node, Lane::pool) +
                                        "; the threads of the pool have theirs in live.pool." + key);
  }
}

// What the nodes of one thread say of a key: the first word holds, and another one is an error.
template <class T>
const Given<T>* agreed(const std::vector<ThreadKeys>& nodes, std::optional<Given<T>> ThreadKeys::*key,
                       Diagnostics& diagnostics) {
  const Given<T>* first = nullptr;
  for (const ThreadKeys& keys : nodes) {
    if (!(keys.*key)) continue;
    const Given<T>& mine = *(keys.*key);
    if (first == nullptr) {
      first = &mine;
    } else if (mine.value != first->value) {
      diagnostics.error(mine.tree->place, mine.path + ": expected " + describe(*first->tree) + ", which " +
                                              first->path + " (" + first->tree->place.text() +
                                              ") says of the same thread " + keys.node->scheduling.thread + ", found " +
                                              describe(*mine.tree));
    }
  }
  return first;
}

// Gives all nodes of one thread the same settings.
void settle(const std::vector<ThreadKeys>& nodes, Diagnostics& diagnostics) {
  const Lane lane = nodes.front().node->scheduling.lane;
  const auto* policy_key = agreed(nodes, &ThreadKeys::policy, diagnostics);
  const auto* priority_key = agreed(nodes, &ThreadKeys::priority, diagnostics);
  const auto* cpu_key = agreed(nodes, &ThreadKeys::cpu, diagnostics);
  const SchedulingPolicy policy = policy_key == nullptr ? default_policy(lane) : policy_key->value;
  const bool broken = std::any_of(nodes.begin(), nodes.end(), [](const auto& keys) { return keys.policy_is_broken; });
  if (priority_key != nullptr && policy == SchedulingPolicy::other && !broken) {
    const std::string whose = policy_key == nullptr ? " (the default of lane " + word(lane) + ")" : "";
    diagnostics.error(priority_key->tree->place, priority_key->path +
                                                     ": expected it with policy fifo or round_robin, found policy "
                                                     "other" +
                                                     whose);
  }
  for (const ThreadKeys& keys : nodes) {
    Scheduling& scheduling = keys.node->scheduling;
    scheduling.policy = policy;
    if (policy != SchedulingPolicy::other) {
      scheduling.priority = priority_key == nullptr ? default_priority(lane) : priority_key->value;
    }
    if (cpu_key != nullptr) scheduling.cpu = cpu_key->value;
  }
}

}  // namespace

Scheduling default_scheduling(const NodeInfo& info) {
  Scheduling scheduling;
  scheduling.lane = info.lane;
  scheduling.thread = info.thread;
  if (info.lane == Lane::pool) return scheduling;
  scheduling.policy = default_policy(info.lane);
  if (*scheduling.policy != SchedulingPolicy::other) scheduling.priority = default_priority(info.lane);
  return scheduling;
}

void read_lanes(std::vector<NodeSpec>& nodes, const Tree& tree, Registry& registry, Diagnostics& diagnostics) {
  std::vector<std::vector<ThreadKeys>> threads;
  std::map<std::string, std::size_t> named;
  for (NodeSpec& spec : nodes) {
    const Tree& node = *tree.value(spec.name);
    const std::string path = "nodes." + spec.name;
    const std::optional<Lane> lane = read_lane(*spec.info, node, path, registry, diagnostics);
    if (!lane) continue;
    spec.scheduling.lane = *lane;
    spec.scheduling.thread = read_thread(*spec.info, node, path, *lane, diagnostics);
    if (*lane == Lane::pool) {
      refuse_in_pool(*spec.info, node, path, diagnostics);
      continue;
    }
    std::size_t at = threads.size();
    if (!spec.scheduling.thread.empty()) at = named.emplace(spec.scheduling.thread, at).first->second;
    if (at == threads.size()) threads.emplace_back();
    threads[at].push_back(read_thread_keys(spec, node, path, diagnostics));
  }
  for (const std::vector<ThreadKeys>& thread : threads) settle(thread, diagnostics);
}

void check_realtime_edges(const GraphSpec& graph, Diagnostics& diagnostics) {
  if (graph.clock != Clock::real) return;
  for (const EdgeSpec& edge : graph.edges) {
    if (edge.queue.policy != QueuePolicy::block) continue;
    const std::string blocked = edge.name() + ": expected latest, drop_oldest or drop_newest, found block" +
                                (edge.queue_is_default ? " (the default of " + edge.to_node + ")" : "") + "; ";
    if (graph.node(edge.from_node)->info->actuator && graph.node(edge.from_node)->scheduling.lane != Lane::realtime) {
      diagnostics.error(edge.place,
                        blocked + edge.from_node + " drives a device, and a device never waits for a slow reader");
      continue;
    }
    for (const std::string& name : {edge.from_node, edge.to_node}) {
      if (graph.node(name)->scheduling.lane != Lane::realtime) continue;
      const std::string what =
          name == edge.from_node
              ? name + " is in the realtime lane, whose loop never waits for a reader"
              : name + " is in the realtime lane, whose loop takes the newest message and never makes a writer wait";
      diagnostics.error(edge.place, blocked + what);
      break;
    }
  }
}

}  // namespace tactor
