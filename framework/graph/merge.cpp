#include "framework/graph/merge.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <set>

#include "framework/core/text.hpp"
#include "framework/graph/scheduling_words.hpp"

namespace tactor {

namespace {

std::optional<EdgeEnds> split_arrow(const std::string& text) {
  const std::size_t arrow = text.find("->");
  if (arrow == std::string::npos) return std::nullopt;
  return EdgeEnds{std::string(trimmed(std::string_view(text).substr(0, arrow))),
                  std::string(trimmed(std::string_view(text).substr(arrow + 2)))};
}

void erase(Tree& map, std::string_view key) {
  std::erase_if(map.entries, [&](const TreeEntry& e) { return e.key == key; });
}

void merge_maps(Tree& parent, const Tree& child);

// The child's value over the parent's: maps key by key, everything else replaced.
void merge_value(Tree& parent, const Tree& child) {
  if (parent.is_map() && child.is_map()) {
    merge_maps(parent, child);
  } else {
    parent = child;
  }
}

using Merge = std::function<void(Tree& parent, const TreeEntry& child)>;

void merge_entries(Tree& parent, const Tree& child, const Merge& merge) {
  for (const TreeEntry& entry : child.entries) {
    TreeEntry* mine = parent.find(entry.key);
    if (mine != nullptr && entry.value.is_null()) {
      erase(parent, entry.key);
    } else if (mine != nullptr) {
      // A value of the command line does not make the map around it come from there.
      if (entry.place.line > 0 || !mine->value.is_map() || !entry.value.is_map()) mine->place = entry.place;
      merge(mine->value, entry);
    } else {
      parent.entries.push_back(entry);
    }
  }
  // A value of the command line does not make its whole map come from there.
  if (child.place.line > 0) parent.place = child.place;
}

void merge_maps(Tree& parent, const Tree& child) {
  merge_entries(parent, child, [](Tree& mine, const TreeEntry& entry) { merge_value(mine, entry.value); });
}

// What the child does not say of these is not taken over.
void drop_unsaid(Tree& parent, const Tree& child, const std::vector<std::string>& keys) {
  for (const std::string& key : keys) {
    if (child.find(key) == nullptr) erase(parent, key);
  }
}

// Of these keys one is there at most: the one the child names takes the place of the parent's.
void drop_alternatives(Tree& parent, const Tree& child, const std::vector<std::string>& keys) {
  const bool named = std::any_of(keys.begin(), keys.end(), [&](const auto& key) { return child.find(key) != nullptr; });
  if (named) drop_unsaid(parent, child, keys);
}

void merge_body(Tree& parent, const TreeEntry& child) {
  if (!parent.is_map() || !child.value.is_map()) {
    parent = child.value;
    return;
  }
  const std::vector<std::string> shapes{"mesh", "sphere", "capsule", "box", "plane"};
  // The scale goes with the mesh it was said of, but a child may say it anew of its parent's mesh.
  if (std::any_of(shapes.begin(), shapes.end(), [&](const auto& key) { return child.value.find(key) != nullptr; })) {
    drop_unsaid(parent, child.value, {"scale"});
  }
  drop_alternatives(parent, child.value, shapes);
  if (const TreeEntry* pose = child.value.find("pose")) {
    if (TreeEntry* mine = parent.find("pose")) drop_alternatives(mine->value, pose->value, {"rpy", "quaternion"});
  }
  merge_maps(parent, child.value);
}

// A policy without priorities takes the place of one with its priority.
void drop_priority(Tree& parent, const Tree& child) {
  const Tree* policy = child.value("policy");
  if (policy != nullptr && policy->text == word(SchedulingPolicy::other)) drop_unsaid(parent, child, {"priority"});
}

// Another lane takes the place of the old one with its thread.
void drop_thread_settings(Tree& parent, const Tree& child) {
  const Tree* lane = child.value("lane");
  const Tree* before = parent.value("lane");
  if (lane != nullptr && (before == nullptr || lane->text != before->text)) {
    drop_unsaid(parent, child, {"thread", "policy", "priority", "cpu"});
  }
  drop_priority(parent, child);
}

// A policy of the pool without priorities drops the priority.
void merge_live(Tree& parent, const Tree& child) {
  const Tree* pool = child.value("pool");
  if (TreeEntry* mine = parent.find("pool"); mine != nullptr && pool != nullptr) drop_priority(mine->value, *pool);
  merge_value(parent, child);
}

/// Whether the child names another type than the parent, in a library or in Python.
bool is_another_type(const Tree& parent, const Tree& child) {
  for (const char* key : {"type", "python"}) {
    const TreeEntry* named = child.find(key);
    if (named == nullptr) continue;
    const TreeEntry* before = parent.find(key);
    const bool other = parent.find(key == std::string_view("type") ? "python" : "type") != nullptr;
    if (before != nullptr ? named->value.text != before->value.text : other) return true;
  }
  return false;
}

void merge_node(Tree& parent, const TreeEntry& child) {
  const bool changes = is_another_type(parent, child.value);
  if (!parent.is_map() || !child.value.is_map() || changes) {
    parent = child.value;
    return;
  }
  drop_thread_settings(parent, child.value);
  merge_entries(parent, child.value, [](Tree& mine, const TreeEntry& entry) {
    if (entry.key == "cost" && mine.is_map() && entry.value.is_map()) {
      const std::vector<std::string> kinds{"constant", "per_contact", "trace"};
      const auto changed = [&](const auto& kind) {
        return entry.value.find(kind) != nullptr && mine.find(kind) == nullptr;
      };
      if (std::any_of(kinds.begin(), kinds.end(), changed)) mine = entry.value;
    }
    merge_value(mine, entry.value);
  });
}

// A null of the child takes the parent's entry out. A null that meets nothing stays, as an error to be found.
void merge_named(Tree& parent, const Tree& child, const Merge& merge, std::vector<std::string>* removed) {
  if (!parent.is_map() || !child.is_map()) {
    parent = child;
    return;
  }
  Tree kept = child;
  for (const TreeEntry& entry : child.entries) {
    if (!entry.value.is_null() || parent.find(entry.key) == nullptr) continue;
    erase(parent, entry.key);
    erase(kept, entry.key);
    if (removed != nullptr) removed->push_back(entry.key);
  }
  merge_entries(parent, kept, merge);
}

// Edges of the child from `into x.in` begin where the parent's edge into x.in does. Where that is the node at their own
// end, the child was laid over before: the parent's edge into it stays.
Tree with_sources(const Tree& child, const Tree& parent) {
  std::map<std::string, std::string> fed_from;
  for (const Tree& edge : parent.items) {
    if (const auto ends = edge_ends(edge)) fed_from[ends->to] = ends->from;
  }
  Tree result = child;
  std::erase_if(result.items, [&](Tree& edge) {
    const std::optional<EdgeEnds> ends = edge_ends(edge);
    const std::optional<std::string> input = ends ? fed_input(ends->from) : std::nullopt;
    const auto source = input ? fed_from.find(*input) : fed_from.end();
    if (source == fed_from.end()) return false;
    if (node_of(source->second) == node_of(ends->to) && fed_from.contains(ends->to)) return true;
    set_edge_ends(edge, {source->second, ends->to});
    return false;
  });
  return result;
}

void merge_edges(Tree& parent, const Tree& laid_over) {
  if (!parent.is_sequence() || !laid_over.is_sequence()) {
    parent = laid_over;
    return;
  }
  const Tree child = with_sources(laid_over, parent);
  std::set<std::string> inputs;
  for (const Tree& edge : child.items) {
    if (const auto ends = edge_ends(edge)) inputs.insert(ends->to);
  }
  std::set<std::string> replaced;
  std::erase_if(parent.items, [&](const Tree& edge) {
    const std::optional<EdgeEnds> ends = edge_ends(edge);
    if (!ends || !inputs.contains(ends->to)) return false;
    replaced.insert(ends->to);
    return true;
  });
  std::vector<Tree> added;
  for (const Tree& edge : child.items) {
    const std::optional<EdgeEnds> ends = edge_ends(edge);
    const bool takes_out = edge.is_map() && edge.entries.size() == 1 && edge.entries[0].value.is_null();
    if (!takes_out || !ends || !replaced.contains(ends->to)) added.push_back(edge);
  }
  parent.items.insert(parent.items.end(), added.begin(), added.end());
}

// What the parent said about nodes that the child took out goes with them.
void forget_nodes(Tree& graph, const std::vector<std::string>& nodes) {
  const auto gone = [&](const std::string& end) {
    return std::find(nodes.begin(), nodes.end(), node_of(end)) != nodes.end();
  };
  if (TreeEntry* edges = graph.find("edges")) {
    std::erase_if(edges->value.items, [&](const Tree& edge) {
      const std::optional<EdgeEnds> ends = edge_ends(edge);
      return ends && (gone(ends->from) || gone(ends->to));
    });
  }
  if (TreeEntry* record = graph.find("record")) {
    std::erase_if(record->value.items, [&](const Tree& stream) { return gone(stream.text); });
  }
}

}  // namespace

std::optional<EdgeEnds> edge_ends(const Tree& edge) {
  if (edge.is_scalar()) return split_arrow(edge.text);
  if (!edge.is_map()) return std::nullopt;
  if (edge.entries.size() == 1 && edge.entries[0].key.find("->") != std::string::npos) {
    return split_arrow(edge.entries[0].key);
  }
  const Tree* from = edge.value("from");
  const Tree* to = edge.value("to");
  if (from == nullptr || to == nullptr || !from->is_scalar() || !to->is_scalar()) return std::nullopt;
  return EdgeEnds{std::string(trimmed(from->text)), std::string(trimmed(to->text))};
}

void set_edge_ends(Tree& edge, const EdgeEnds& ends) {
  const std::string arrow = ends.from + " -> " + ends.to;
  if (edge.is_scalar()) {
    edge.text = arrow;
  } else if (TreeEntry* from = edge.find("from")) {
    from->value.text = ends.from;
    edge.find("to")->value.text = ends.to;
  } else {
    edge.entries[0].key = arrow;
  }
}

std::optional<std::string> fed_input(const std::string& from) {
  constexpr std::string_view into = "into ";
  if (!from.starts_with(into)) return std::nullopt;
  return std::string(trimmed(std::string_view(from).substr(into.size())));
}

std::string node_of(const std::string& end) {
  return end.substr(0, end.find('.'));
}

void merge_graph(Tree& parent, const Tree& child) {
  if (const TreeEntry* nodes = child.find("nodes")) {
    if (TreeEntry* mine = parent.find("nodes")) {
      std::vector<std::string> removed;
      merge_named(mine->value, nodes->value, merge_node, &removed);
      forget_nodes(parent, removed);
    }
  }
  merge_entries(parent, child, [](Tree& mine, const TreeEntry& entry) {
    if (entry.key == "nodes") return;
    if (entry.key == "edges") {
      merge_edges(mine, entry.value);
    } else if (entry.key == "live") {
      merge_live(mine, entry.value);
    } else if (entry.key == "scene" && mine.is_map() && entry.value.is_map()) {
      merge_entries(mine, entry.value, [](Tree& of_scene, const TreeEntry& part) {
        if (part.key == "bodies") {
          merge_named(of_scene, part.value, merge_body, nullptr);
        } else {
          merge_value(of_scene, part.value);
        }
      });
    } else {
      merge_value(mine, entry.value);
    }
  });
}

}  // namespace tactor
