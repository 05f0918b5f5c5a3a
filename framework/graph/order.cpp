#include <algorithm>
#include <functional>
#include <queue>

#include "framework/graph/plan_steps.hpp"

namespace tactor {

namespace {

using Lists = std::vector<std::vector<std::size_t>>;

// The strongly connected component of each node (Tarjan 1972, with a stack of its own instead of recursion).
class Components {
 public:
  explicit Components(const Lists& readers)
      : readers_(readers), number_(readers.size(), 0), low_(readers.size(), 0), component(readers.size(), none) {
    for (std::size_t n = 0; n < readers.size(); ++n) {
      if (number_[n] == 0) visit(n);
    }
  }

 private:
  static constexpr std::size_t none = static_cast<std::size_t>(-1);

  void visit(std::size_t root) {
    std::vector<std::pair<std::size_t, std::size_t>> path;  // a node and how many of its readers are done
    enter(root);
    path.emplace_back(root, 0);
    while (!path.empty()) {
      const std::size_t n = path.back().first;
      if (path.back().second < readers_[n].size()) {
        const std::size_t next = readers_[n][path.back().second++];
        if (number_[next] == 0) {
          enter(next);
          path.emplace_back(next, 0);
        } else if (component[next] == none) {
          low_[n] = std::min(low_[n], number_[next]);
        }
        continue;
      }
      path.pop_back();
      if (!path.empty()) low_[path.back().first] = std::min(low_[path.back().first], low_[n]);
      if (low_[n] == number_[n]) close(n);
    }
  }
  void enter(std::size_t n) {
    number_[n] = low_[n] = ++count_;
    open_.push_back(n);
  }
  void close(std::size_t n) {
    std::size_t member = none;
    while (member != n) {
      member = open_.back();
      open_.pop_back();
      component[member] = components;
    }
    ++components;
  }

  const Lists& readers_;
  std::vector<std::size_t> number_;
  std::vector<std::size_t> low_;
  std::vector<std::size_t> open_;
  std::size_t count_ = 0;

 public:
  std::vector<std::size_t> component;
  std::size_t components = 0;
};

// Writers before readers in a graph without cycles; of those that are free the one with the smallest rank goes first.
std::vector<std::size_t> order(const Lists& readers, const std::vector<std::size_t>& rank) {
  std::vector<std::size_t> waits_for(readers.size(), 0);
  for (const auto& list : readers) {
    for (const std::size_t reader : list) ++waits_for[reader];
  }
  using Ranked = std::pair<std::size_t, std::size_t>;
  std::priority_queue<Ranked, std::vector<Ranked>, std::greater<>> free;
  for (std::size_t n = 0; n < readers.size(); ++n) {
    if (waits_for[n] == 0) free.emplace(rank[n], n);
  }
  std::vector<std::size_t> result;
  while (!free.empty()) {
    const std::size_t n = free.top().second;
    free.pop();
    result.push_back(n);
    for (const std::size_t reader : readers[n]) {
      if (--waits_for[reader] == 0) free.emplace(rank[reader], reader);
    }
  }
  TACTOR_DEMAND(result.size() == readers.size());
  return result;
}

bool reaches(const Lists& readers, std::size_t from, std::size_t to) {
  std::vector<bool> seen(readers.size(), false);
  std::vector<std::size_t> todo{from};
  while (!todo.empty()) {
    const std::size_t n = todo.back();
    todo.pop_back();
    if (n == to) return true;
    if (seen[n]) continue;
    seen[n] = true;
    todo.insert(todo.end(), readers[n].begin(), readers[n].end());
  }
  return false;
}

bool binds(const GraphSpec& graph, const std::vector<bool>& triggers, std::size_t e) {
  return triggers[e] && graph.edges[e].delay.ns == 0;
}

}  // namespace

std::vector<std::size_t> find_trigger_cycle(const GraphSpec& graph, const std::vector<Wire>& wires, const Kept& kept,
                                            const std::vector<bool>& triggers) {
  Lists readers(graph.nodes.size());
  for (std::size_t e = 0; e < wires.size(); ++e) {
    if (kept.edges[e] && binds(graph, triggers, e)) readers[wires[e].from].push_back(wires[e].to);
  }
  const Components parts(readers);
  // Every node of a component with an edge inside has such an edge going on, so a walk along them comes back.
  std::map<std::size_t, std::size_t> next;
  for (std::size_t e = wires.size(); e-- > 0;) {
    const bool inside = parts.component[wires[e].from] == parts.component[wires[e].to];
    if (kept.edges[e] && binds(graph, triggers, e) && inside) next[wires[e].from] = e;
  }
  if (next.empty()) return {};
  std::vector<std::size_t> walk;
  std::map<std::size_t, std::size_t> met;
  for (std::size_t n = next.begin()->first; met.emplace(n, walk.size()).second;) {
    walk.push_back(next.at(n));
    n = wires[walk.back()].to;
  }
  const std::size_t back = met.at(wires[walk.back()].to);
  walk.erase(walk.begin(), walk.begin() + static_cast<std::ptrdiff_t>(back));
  return walk;
}

std::vector<std::size_t> order_nodes(const GraphSpec& graph, const std::vector<Wire>& wires, const Kept& kept,
                                     const std::vector<bool>& triggers) {
  const std::size_t count = graph.nodes.size();
  Lists readers(count);
  for (std::size_t e = 0; e < wires.size(); ++e) {
    if (kept.edges[e] && binds(graph, triggers, e)) readers[wires[e].from].push_back(wires[e].to);
  }
  // The others in the order of the file, as long as they close no loop; one that would is the loop's way back.
  for (std::size_t e = 0; e < wires.size(); ++e) {
    if (!kept.edges[e] || binds(graph, triggers, e)) continue;
    if (!reaches(readers, wires[e].to, wires[e].from)) readers[wires[e].from].push_back(wires[e].to);
  }
  std::vector<std::size_t> rank(count);
  for (std::size_t n = 0; n < count; ++n) rank[n] = n;
  std::vector<std::size_t> result = order(readers, rank);
  std::erase_if(result, [&](std::size_t n) { return !kept.nodes[n]; });
  return result;
}

}  // namespace tactor
