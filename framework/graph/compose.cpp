#include "framework/graph/compose.hpp"

#include <algorithm>
#include <functional>
#include <set>

#include "framework/graph/values.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t max_extends = 16;

std::string trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\n\r");
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(" \t\n\r") - first + 1));
}

std::optional<EdgeEnds> split_arrow(const std::string& text) {
  const std::size_t arrow = text.find("->");
  if (arrow == std::string::npos) return std::nullopt;
  return EdgeEnds{trimmed(std::string_view(text).substr(0, arrow)), trimmed(std::string_view(text).substr(arrow + 2))};
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
    if (TreeEntry* mine = parent.find(entry.key)) {
      mine->place = entry.place;
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

// Of these keys one is there at most: the one the child names takes the place of the parent's.
void drop_alternatives(Tree& parent, const Tree& child, const std::vector<std::string>& keys) {
  const bool named = std::any_of(keys.begin(), keys.end(), [&](const auto& key) { return child.find(key) != nullptr; });
  if (!named) return;
  for (const std::string& key : keys) {
    if (child.find(key) == nullptr) erase(parent, key);
  }
}

void merge_body(Tree& parent, const TreeEntry& child) {
  if (!parent.is_map() || !child.value.is_map()) {
    parent = child.value;
    return;
  }
  drop_alternatives(parent, child.value, {"mesh", "sphere"});
  if (const TreeEntry* pose = child.value.find("pose")) {
    if (TreeEntry* mine = parent.find("pose")) drop_alternatives(mine->value, pose->value, {"rpy", "quaternion"});
  }
  merge_maps(parent, child.value);
}

void merge_node(Tree& parent, const TreeEntry& child) {
  const TreeEntry* type = child.value.find("type");
  const TreeEntry* before = parent.find("type");
  const bool changes = type != nullptr && before != nullptr && type->value.text != before->value.text;
  if (!parent.is_map() || !child.value.is_map() || changes) {
    parent = child.value;
    return;
  }
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

void merge_edges(Tree& parent, const Tree& child) {
  if (!parent.is_sequence() || !child.is_sequence()) {
    parent = child;
    return;
  }
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

std::optional<Tree> load_chain(const fs::path& file, const Tree* named_by, std::vector<fs::path>& chain,
                               Diagnostics& diagnostics) {
  std::error_code ignored;
  const fs::path identity = fs::weakly_canonical(file, ignored);
  if (named_by != nullptr) {
    const auto complain = [&](const std::string& message) {
      diagnostics.error(named_by->place, "extends: " + message);
      return std::optional<Tree>();
    };
    if (std::find(chain.begin(), chain.end(), identity) != chain.end()) {
      std::string names;
      for (const fs::path& link : chain) names += link.filename().string() + " -> ";
      return complain("expected files that end somewhere, found a cycle: " + names + file.filename().string());
    }
    if (chain.size() > max_extends) {
      return complain("expected at most " + std::to_string(max_extends) + " files one over the other, found more");
    }
    if (!fs::is_regular_file(file, ignored)) {
      return complain("expected a graph file that exists, found " + describe(*named_by) + "; looked for " +
                      file.string());
    }
  }
  chain.push_back(identity);
  std::optional<Tree> tree = read_yaml(file, file.string(), diagnostics);
  if (!tree) return std::nullopt;
  const TreeEntry* extends = tree->find("extends");
  if (extends == nullptr) return tree;
  const Tree value = extends->value;
  erase(*tree, "extends");
  if (!value.is_scalar() || value.text.empty()) {
    diagnostics.error(value.place, "extends: expected the path of a graph file, found " + describe(value));
    return std::nullopt;
  }
  std::optional<Tree> parent =
      load_chain((file.parent_path() / value.text).lexically_normal(), &value, chain, diagnostics);
  if (!parent) return std::nullopt;
  merge_graph(*parent, *tree);
  return parent;
}

std::vector<std::string> keys_of(const Tree* map) {
  std::vector<std::string> keys;
  if (map == nullptr) return keys;
  for (const TreeEntry& entry : map->entries) keys.push_back(entry.key);
  return keys;
}

const Tree* value_at(const Tree& tree, std::string_view key) {
  const TreeEntry* entry = tree.find(key);
  return entry == nullptr ? nullptr : &entry->value;
}

std::vector<std::string> split_dots(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == '.') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

// `text` is `path=value`; the value becomes a tree of one branch that is merged over the graph like an extending file.
void apply_set(Tree& graph, const std::string& text, Diagnostics& diagnostics) {
  static const std::vector<std::string> roots{"title", "clock", "duration", "seed", "scene", "record", "nodes"};
  const Place place{"--set " + text, 0, 0};
  const std::string form = "expected node.parameter=value, scene.bodies.body.key=value, duration=... or seed=...";
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) {
    diagnostics.error(place, form + ", found no =");
    return;
  }
  std::vector<std::string> path = split_dots(trimmed(text.substr(0, equals)));
  if (std::any_of(path.begin(), path.end(), [](const std::string& part) { return part.empty(); })) {
    diagnostics.error(place, form + ", found an empty name");
    return;
  }
  Diagnostics of_value;
  std::optional<Tree> value = parse_yaml(text.substr(equals + 1), place.file, of_value);
  for (const Diagnostic& d : of_value.list()) diagnostics.error(place, d.message);
  if (!value || of_value.any()) return;
  set_places(*value, place);
  if (std::find(roots.begin(), roots.end(), path[0]) == roots.end()) path.insert(path.begin(), "nodes");

  if (path[0] == "nodes") {
    const std::vector<std::string> nodes = keys_of(value_at(graph, "nodes"));
    if (path.size() < 3 && !(path.size() == 2 && value->is_null())) {
      diagnostics.error(place, form + ", found " + list_of(path) + did_you_mean(path.back(), roots));
      return;
    }
    if (std::find(nodes.begin(), nodes.end(), path[1]) == nodes.end()) {
      std::vector<std::string> names = nodes;
      names.insert(names.end(), roots.begin(), roots.end());
      diagnostics.error(place, path[1] + ": expected a node of the graph (" + list_of(nodes) +
                                   "), found none of that name" + did_you_mean(path[1], names));
      return;
    }
  }
  if (path[0] == "scene" && path.size() > 2 && path[1] == "bodies") {
    const Tree* scene = value_at(graph, "scene");
    const std::vector<std::string> bodies = keys_of(scene == nullptr ? nullptr : value_at(*scene, "bodies"));
    if (std::find(bodies.begin(), bodies.end(), path[2]) == bodies.end()) {
      diagnostics.error(place, "scene.bodies." + path[2] + ": expected a body of the scene (" + list_of(bodies) +
                                   "), found none of that name" + did_you_mean(path[2], bodies));
      return;
    }
  }
  if (path.size() + 1 > max_yaml_depth) {
    diagnostics.error(place, form + ", found too many dots");
    return;
  }
  Tree branch = std::move(*value);
  for (auto part = path.rbegin(); part != path.rend(); ++part) {
    Tree map;
    map.kind = Tree::Kind::map;
    map.place = place;
    map.entries.push_back({*part, place, std::move(branch)});
    branch = std::move(map);
  }
  merge_graph(graph, branch);
}

void apply_scalar(Tree& graph, const std::string& option, const std::string& key, const std::string& text) {
  Tree map;
  map.kind = Tree::Kind::map;
  Tree value;
  value.kind = Tree::Kind::scalar;
  value.text = text;
  map.entries.push_back({key, {}, std::move(value)});
  set_places(map, {option + " " + text, 0, 0});
  merge_graph(graph, map);
}

}  // namespace

std::optional<EdgeEnds> edge_ends(const Tree& edge) {
  if (edge.is_scalar()) return split_arrow(edge.text);
  if (!edge.is_map()) return std::nullopt;
  if (edge.entries.size() == 1 && edge.entries[0].key.find("->") != std::string::npos) {
    return split_arrow(edge.entries[0].key);
  }
  const Tree* from = value_at(edge, "from");
  const Tree* to = value_at(edge, "to");
  if (from == nullptr || to == nullptr || !from->is_scalar() || !to->is_scalar()) return std::nullopt;
  return EdgeEnds{trimmed(from->text), trimmed(to->text)};
}

std::string node_of(const std::string& end) {
  return end.substr(0, end.find('.'));
}

std::optional<Tree> compose(const fs::path& file, const Overrides& overrides, Diagnostics& diagnostics) {
  std::vector<fs::path> chain;
  std::optional<Tree> graph = load_chain(file, nullptr, chain, diagnostics);
  if (!graph) return std::nullopt;
  for (const std::string& text : overrides.set) apply_set(*graph, text, diagnostics);
  if (overrides.seed) apply_scalar(*graph, "--seed", "seed", std::to_string(*overrides.seed));
  if (overrides.duration_s) apply_scalar(*graph, "--duration", "duration", number_text(*overrides.duration_s));
  return graph;
}

}  // namespace tactor
