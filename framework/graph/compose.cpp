#include "framework/graph/compose.hpp"

#include <algorithm>

#include "framework/graph/bind.hpp"
#include "framework/graph/format.hpp"
#include "framework/graph/merge.hpp"
#include "framework/graph/readers.hpp"
#include "framework/graph/values.hpp"
#include "framework/yaml/file_finder.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

// The keys of a graph that a path may begin with; any other first name is that of a node.
const std::vector<std::string> roots{"title", "clock", "duration", "seed", "rate", "live", "scene", "record", "nodes"};

constexpr std::size_t max_extends = 16;
constexpr std::size_t max_files = 64;  // in all: files that each extend several could be read without end

/// How a copy of a shipped graph names the shipped graphs that lay beside the original.
std::string shipped_instead(const std::string& name) {
  fs::path file(name);
  if (file.extension() != graph_files.ending) file += graph_files.ending;
  const std::vector<std::string> shipped = names_in_folders(file.filename(), graph_files);
  if (shipped.empty()) return {};
  return "; shipped graphs of this name are " + list_of(shipped) +
         "; in a copy of a shipped graph write the one that lay beside it, such as `extends: " + shipped.front() +
         "`, or extend the shipped graph itself instead of copying it";
}

struct GraphFiles {
  std::vector<fs::path> read;  // each once
  std::size_t extended = 0;    // how often a file was named by `extends`
};

// `chain` holds the files that lead to this one, `files` all that were read.
std::optional<Tree> load_chain(const fs::path& file, const Tree* named_by, std::vector<fs::path> chain,
                               GraphFiles& files, const TypeOfNode& type_of, Diagnostics& diagnostics) {
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
    if (++files.extended > max_files) {
      return complain("expected at most " + std::to_string(max_files) + " files in all, found more");
    }
  }
  chain.push_back(identity);
  if (std::find(files.read.begin(), files.read.end(), identity) == files.read.end()) files.read.push_back(identity);
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
      diagnostics.error(one.place, "extends: expected a graph file that exists, found " + describe(one) +
                                       looked_for(search) + shipped_instead(one.text));
      return std::nullopt;
    }
    std::optional<Tree> parent = load_chain(search.file, &one, chain, files, type_of, diagnostics);
    if (!parent) return std::nullopt;
    if (under) {
      if (!lay_over(*under, std::move(*parent), type_of, diagnostics)) return std::nullopt;
    } else {
      under = std::move(parent);
    }
  }
  if (under && !lay_over(*under, std::move(*tree), type_of, diagnostics)) return std::nullopt;
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

// Whether the path leads to something that may be set: to a node or a body that is there. `is_node`: the value is what
// may stand for a whole node, a map or null.
bool check_path(const Tree& graph, const std::vector<std::string>& path, bool is_node, const SourceLocation& place,
                Diagnostics& diagnostics) {
  const std::string form = assignment_form;
  if (path[0] == "nodes") {
    const std::vector<std::string> nodes = keys_of(graph.value("nodes"));
    if (path.size() < 3 && !(path.size() == 2 && is_node)) {
      diagnostics.error(place, form + ", found " + list_of(path) + did_you_mean(path.back(), roots));
      return false;
    }
    if (std::find(nodes.begin(), nodes.end(), path[1]) == nodes.end()) {
      std::vector<std::string> names = nodes;
      names.insert(names.end(), roots.begin(), roots.end());
      diagnostics.error(place, path[1] + ": expected a node of the graph (" + list_of(nodes) +
                                   "), found none of that name" + did_you_mean(path[1], names));
      return false;
    }
  }
  if (path[0] == "scene" && path.size() > 2 && path[1] == "bodies") {
    const Tree* scene = graph.value("scene");
    const std::vector<std::string> bodies = keys_of(scene == nullptr ? nullptr : scene->value("bodies"));
    if (std::find(bodies.begin(), bodies.end(), path[2]) == bodies.end()) {
      diagnostics.error(place, "scene.bodies." + path[2] + ": expected a body of the scene (" + list_of(bodies) +
                                   "), found none of that name" + did_you_mean(path[2], bodies));
      return false;
    }
  }
  if (path.size() + 1 > max_yaml_depth) {
    diagnostics.error(place, form + ", found too many dots");
    return false;
  }
  return true;
}

// The value as a tree of one branch. Maps that the graph has keep the places that they have there.
Tree branch_of(const Tree& graph, const std::vector<std::string>& path, Tree value, const SourceLocation& place) {
  std::vector<SourceLocation> places;
  const Tree* at = &graph;
  for (std::size_t i = 0; i < path.size(); ++i) {
    at = at == nullptr ? nullptr : at->value(path[i]);
    const bool is_there = at != nullptr && i + 1 < path.size();
    places.push_back(is_there ? SourceLocation{place.file, 0, 0} : place);
  }
  Tree branch = std::move(value);
  for (std::size_t i = path.size(); i-- > 0;) {
    Tree map;
    map.kind = Tree::Kind::map;
    map.place = i == 0 ? SourceLocation{place.file, 0, 0} : places[i - 1];
    map.entries.push_back({path[i], places[i], std::move(branch)});
    branch = std::move(map);
  }
  return branch;
}

// Lays a value over the graph like a file that extends it and says nothing else.
void assign(Tree& graph, const Assignment& assignment, const SourceLocation& place, Diagnostics& diagnostics) {
  std::vector<std::string> path = split_dots(assignment.path);
  if (std::any_of(path.begin(), path.end(), [](const std::string& part) { return part.empty(); })) {
    diagnostics.error(place, std::string(assignment_form) + ", found an empty name");
    return;
  }
  Diagnostics of_value;
  std::optional<Tree> value = parse_yaml(assignment.value, place.file, of_value);
  for (const Diagnostic& d : of_value.list()) diagnostics.error(place, d.message);
  if (!value || of_value.any()) return;
  set_places(*value, place);
  if (std::find(roots.begin(), roots.end(), path[0]) == roots.end()) path.insert(path.begin(), "nodes");
  if (!check_path(graph, path, value->is_null() || value->is_map(), place, diagnostics)) return;
  merge_graph(graph, branch_of(graph, path, std::move(*value), place));
}

}  // namespace

FileSearch find_over(const fs::path& over, const fs::path& graph) {
  // Methods are most often taken from the folder beside the graph, or beside the folder of its scene.
  std::error_code ignored;
  const fs::path beside = fs::absolute(graph, ignored).parent_path();
  return find_file(over, {"", beside, beside / "methods", beside.parent_path() / "methods"}, method_files);
}

std::optional<Tree> compose(const fs::path& file, const Overrides& overrides, Registry& registry,
                            Diagnostics& diagnostics, std::vector<fs::path>& read) {
  const FileFinder finder(file.parent_path());
  const TypeOfNode type_of = [&](const TreeEntry& node) {
    // What is wrong with a type is told where the nodes are read.
    Diagnostics ignored;
    return node.value.is_map() ? read_type(node, "", registry, finder, ignored) : nullptr;
  };
  GraphFiles files;
  std::optional<Tree> graph = load_chain(file, nullptr, {}, files, type_of, diagnostics);
  if (!graph) return std::nullopt;
  for (const Patch& patch : overrides) {
    if (const Assignment* assignment = patch.assignment()) {
      assign(*graph, *assignment, patch.place, diagnostics);
    } else if (const fs::path* over = patch.file()) {
      const FileSearch search = find_over(*over, file);
      if (search.file.empty()) {
        diagnostics.error(patch.place, "expected a graph file that exists" + looked_for(search));
        return std::nullopt;
      }
      std::optional<Tree> layer = load_chain(search.file, nullptr, {}, files, type_of, diagnostics);
      if (!layer) return std::nullopt;
      if (!lay_over(*graph, std::move(*layer), type_of, diagnostics)) return std::nullopt;
    } else if (!lay_over(*graph, std::get<Tree>(patch.change), type_of, diagnostics)) {
      return std::nullopt;
    }
  }
  read = std::move(files.read);
  return is_bound(*graph, file, diagnostics) ? std::move(graph) : std::nullopt;
}

}  // namespace tactor
