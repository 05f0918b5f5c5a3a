#include "framework/graph/compose.hpp"

#include <algorithm>

#include "framework/core/text.hpp"
#include "framework/graph/format.hpp"
#include "framework/graph/merge.hpp"
#include "framework/graph/values.hpp"
#include "framework/yaml/file_finder.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t max_extends = 16;
constexpr std::size_t max_files = 64;  // in all: files that each extend several could be read without end

// `chain` holds the files that lead to this one, `files` counts all that were read.
std::optional<Tree> load_chain(const fs::path& file, const Tree* named_by, std::vector<fs::path> chain,
                               std::size_t& files, Diagnostics& diagnostics) {
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
    if (++files > max_files) {
      return complain("expected at most " + std::to_string(max_files) + " files in all, found more");
    }
  }
  chain.push_back(identity);
  std::optional<Tree> tree = read_yaml(file, file.string(), graph_file, diagnostics);
  if (!tree) return std::nullopt;
  take_format(*tree, diagnostics);
  const TreeEntry* extends = tree->find("extends");
  if (extends == nullptr) return tree;
  const Tree value = extends->value;
  std::erase_if(tree->entries, [](const TreeEntry& e) { return e.key == "extends"; });
  const std::vector<Tree> several = value.is_sequence() ? value.items : std::vector<Tree>{value};
  if (several.empty())
    diagnostics.error(value.place, "extends: expected the paths of graph files, found an empty list");
  std::optional<Tree> under;
  for (const Tree& one : several) {
    if (!one.is_scalar() || one.text.empty()) {
      diagnostics.error(one.place, "extends: expected the path of a graph file, found " + describe(one));
      return std::nullopt;
    }
    const FileSearch search = find_file(one.text, {file.parent_path()}, graph_files);
    if (search.file.empty()) {
      diagnostics.error(one.place,
                        "extends: expected a graph file that exists, found " + describe(one) + looked_for(search));
      return std::nullopt;
    }
    std::optional<Tree> parent = load_chain(search.file, &one, chain, files, diagnostics);
    if (!parent) return std::nullopt;
    if (under) {
      merge_graph(*under, *parent);
    } else {
      under = std::move(parent);
    }
  }
  if (under) merge_graph(*under, *tree);
  return under;
}

std::vector<std::string> keys_of(const Tree* map) {
  std::vector<std::string> keys;
  if (map == nullptr) return keys;
  for (const TreeEntry& entry : map->entries) keys.push_back(entry.key);
  return keys;
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
  static const std::vector<std::string> roots{"title", "clock", "duration", "seed", "rate",
                                              "live",  "scene", "record",   "nodes"};
  const SourceLocation place{"--set " + text, 0, 0};
  const std::string form = "expected node.parameter=value, scene.bodies.body.key=value, duration=... or seed=...";
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) {
    diagnostics.error(place, form + ", found no =");
    return;
  }
  std::vector<std::string> path = split_dots(std::string(trimmed(std::string_view(text).substr(0, equals))));
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
    const std::vector<std::string> nodes = keys_of(graph.value("nodes"));
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
    const Tree* scene = graph.value("scene");
    const std::vector<std::string> bodies = keys_of(scene == nullptr ? nullptr : scene->value("bodies"));
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

std::optional<Tree> compose(const fs::path& file, const Overrides& overrides, Diagnostics& diagnostics) {
  std::size_t files = 0;
  std::optional<Tree> graph = load_chain(file, nullptr, {}, files, diagnostics);
  if (!graph) return std::nullopt;
  const auto lay_file = [&](const fs::path& over) {
    // Methods are most often taken from the folder beside the graph, or beside the folder of its scene.
    std::error_code ignored;
    const fs::path beside = fs::absolute(file, ignored).parent_path();
    const FileSearch search =
        find_file(over, {"", beside, beside / "methods", beside.parent_path() / "methods"}, method_files);
    if (search.file.empty()) {
      diagnostics.error({over.string(), 0, 0}, "expected a graph file that exists" + looked_for(search));
      return false;
    }
    const std::optional<Tree> layer = load_chain(search.file, nullptr, {}, files, diagnostics);
    if (layer) merge_graph(*graph, *layer);
    return layer.has_value();
  };
  const auto lay = [&](const std::vector<Overlay>& layers) {
    for (const Overlay& layer : layers) {
      if (layer.tree) {
        merge_graph(*graph, *layer.tree);
      } else if (!lay_file(layer.file)) {
        return false;
      }
    }
    return true;
  };
  if (!lay(overrides.layers)) return std::nullopt;
  for (const fs::path& over : overrides.over) {
    if (!lay_file(over)) return std::nullopt;
  }
  for (const std::string& text : overrides.set) apply_set(*graph, text, diagnostics);
  if (overrides.seed) apply_scalar(*graph, "--seed", "seed", std::to_string(*overrides.seed));
  if (overrides.duration_s) apply_scalar(*graph, "--duration", "duration", number_text(*overrides.duration_s));
  if (!lay(overrides.top_layers)) return std::nullopt;
  for (const std::string& text : overrides.top_set) apply_set(*graph, text, diagnostics);
  return graph;
}

}  // namespace tactor
