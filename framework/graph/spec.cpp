#include "framework/graph/spec.hpp"
#include "framework/graph/format.hpp"

#include <algorithm>
#include <set>

#include "framework/core/plain_name.hpp"
#include "framework/core/text.hpp"
#include "framework/graph/compose.hpp"
#include "framework/graph/merge.hpp"
#include "framework/graph/readers.hpp"
#include "framework/graph/values.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

// Why a type is not known: a misspelt name, or a library that is not there.
std::string unknown_type(const Tree& tree, Registry& registry) {
  const std::string& type = tree.text;
  std::string message = "expected a node type, found " + describe(tree);
  try {
    registry.load_all();
  } catch (const InputError& e) {
    message += "; " + std::string(e.what());
  }
  const std::string prefix = node_of(type);
  std::vector<std::string> names;
  bool library = false;
  for (const NodeInfo* info : registry.types()) {
    names.push_back(info->type);
    library = library || node_of(info->type) == prefix;
  }
  const bool plausible = std::all_of(prefix.begin(), prefix.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  });
  if (!library && plausible && prefix.size() < type.size()) {
    message += "; " + registry.why_missing(prefix);
  }
  return message + did_you_mean(type, names);
}

/// `FILE.py:Class`, the file found as those that parameters name.
const NodeInfo* read_python(const Tree& tree, const std::string& path, Registry& registry, const FileFinder& files,
                            Diagnostics& diagnostics) {
  const std::string form = path + ".python: expected FILE.py:Class, a file and a class in it, found ";
  const std::size_t colon = tree.text.rfind(':');
  if (!tree.is_scalar() || colon == std::string::npos || colon == 0 || colon + 1 == tree.text.size()) {
    diagnostics.error(tree.place, form + describe(tree));
    return nullptr;
  }
  Tree file_name = tree;
  file_name.text = tree.text.substr(0, colon);
  const FileKind kind{.noun = "a Python file"};
  Diagnostics looked;
  std::optional<fs::path> file = files.find(file_name, path + ".python", kind, looked);
  // What a program or a command line lays over a graph has no folder of its own: it may name what is here.
  std::error_code ignored;
  const fs::path here = fs::absolute(file_name.text, ignored);
  if (!file && tree.place.line == 0 && fs::is_regular_file(here, ignored)) file = here.lexically_normal();
  for (const Diagnostic& one : looked.list()) {
    if (!file) diagnostics.error(one.place, one.message);
  }
  if (!file) return nullptr;
  try {
    return &registry.find_python(*file, tree.text.substr(colon + 1));
  } catch (const InputError& e) {
    diagnostics.error(tree.place, path + ".python: " + e.what());
    return nullptr;
  }
}

}  // namespace

const NodeInfo* read_type(const TreeEntry& entry, const std::string& path, Registry& registry, const FileFinder& files,
                          Diagnostics& diagnostics) {
  const Tree* type = entry.value.value("type");
  if (const TreeEntry* python = entry.value.find("python")) {
    if (type == nullptr) return read_python(python->value, path, registry, files, diagnostics);
    diagnostics.error(python->place, path + ": expected type or python, found both");
    return nullptr;
  }
  if (type == nullptr) {
    diagnostics.error(entry.place, path + ": expected the key type, or python for a class of your own, found neither");
    return nullptr;
  }
  if (!type->is_scalar() || type->text.empty()) {
    diagnostics.error(type->place,
                      path + ".type: expected a node type such as prediction.ar, found " + describe(*type));
    return nullptr;
  }
  try {
    if (const NodeInfo* info = registry.find(type->text)) return info;
  } catch (const InputError& e) {
    diagnostics.error(type->place, path + ".type: " + e.what());
    return nullptr;
  }
  diagnostics.error(type->place, path + ".type: " + unknown_type(*type, registry));
  return nullptr;
}

namespace {

void read_params(NodeSpec& node, const TreeEntry& entry, const std::string& path, const FileFinder& files,
                 Diagnostics& diagnostics) {
  std::vector<std::string> keys(node_keys.begin(), node_keys.end());
  std::erase(keys, node.info->python.empty() ? "python" : "type");
  for (const ParamInfo& param : node.info->params) keys.push_back(param.name);
  Tree given = entry.value;
  for (const ParamInfo& param : node.info->params) {
    const TreeEntry* old = param.former.empty() ? nullptr : given.find(param.former);
    if (old == nullptr) continue;
    diagnostics.error(old->place, path + "." + old->key + renamed_text(param.name, old->place));
    std::erase_if(given.entries, [&](const TreeEntry& e) { return e.key == param.former; });
  }
  check_keys(given, path, "parameter of " + node.info->type, keys, diagnostics);
  for (std::size_t i = 0; i < node.info->params.size(); ++i) {
    ParamInfo param = node.info->params[i];
    if (i == node.info->rate_parameter) {
      param.min = std::max(param.min, lowest_rate);
      param.max = std::min(param.max, highest_rate);
      param.above_min = false;
    }
    const Tree* tree = entry.value.value(param.name);
    std::optional<ParamValue> value = param.default_value;
    if (tree != nullptr) {
      value = read_param(*tree, path + "." + param.name, param, files, diagnostics);
    } else if (!value) {
      diagnostics.error(entry.place,
                        path + ": expected the parameter " + param.name + " (" + param.doc + "), found none");
    }
    node.params.push_back(std::move(value).value_or(ParamValue(false)));
  }
}

/// Where the values of a map were written, by their paths below `path`; a map by its key.
void collect_places(const Tree& map, const std::string& path,
                    std::map<std::string, SourceLocation, std::less<>>& places) {
  for (const TreeEntry& entry : map.entries) {
    const std::string below = path.empty() ? entry.key : path + "." + entry.key;
    places[below] = entry.value.is_map() || entry.value.is_null() ? entry.place : entry.value.place;
    collect_places(entry.value, below, places);
  }
}

void read_nodes(GraphSpec& spec, std::set<std::string>& broken, const Tree& tree, Registry& registry,
                const FileFinder& files, Diagnostics& diagnostics) {
  if (!expect_map(tree, "nodes", "a map of nodes", diagnostics)) return;
  if (tree.entries.empty()) diagnostics.error(tree.place, "nodes: expected at least one node, found none");
  for (const TreeEntry& entry : tree.entries) {
    const std::string path = "nodes." + entry.key;
    check_name(entry, path, diagnostics);
    NodeSpec node;
    node.name = entry.key;
    node.place = entry.place;
    if (entry.value.is_null()) {
      diagnostics.error(entry.place,
                        path +
                            ": expected a node, found nothing; ~ takes out a node of the file that this one "
                            "extends, and there is none of that name");
    } else if (expect_map(entry.value, path, "a node: a map with type", diagnostics)) {
      node.info = read_type(entry, path, registry, files, diagnostics);
    }
    if (node.info == nullptr) {
      broken.insert(entry.key);
      continue;
    }
    read_params(node, entry, path, files, diagnostics);
    if (const Tree* cost = entry.value.value("cost")) {
      node.cost = read_cost(*cost, path + ".cost", files, diagnostics);
    }
    spec.nodes.push_back(std::move(node));
  }
  // When the libraries of all nodes are loaded, whose message types may be asked for.
  for (NodeSpec& node : spec.nodes) {
    try {
      if (!diagnostics.any()) node.info = &with_output_types(*node.info, node.params);
    } catch (const InputError&) {
      // The node says so itself when it is checked.
    }
  }
  read_lanes(spec.nodes, tree, registry, diagnostics);
}

}  // namespace

SourceLocation GraphSpec::place_of(std::string_view path) const {
  if (places != nullptr) {
    while (!path.empty()) {
      if (const auto found = places->find(path); found != places->end()) return found->second;
      path = path.substr(0, path.find_last_of('.') == std::string_view::npos ? 0 : path.find_last_of('.'));
    }
  }
  return {file.string(), 0, 0};
}

const NodeSpec* GraphSpec::node(std::string_view wanted) const {
  for (const NodeSpec& spec : nodes) {
    if (spec.name == wanted) return &spec;
  }
  return nullptr;
}

ParamValue parse_parameter(const NodeSpec& node, std::size_t param, const std::string& text, const std::string& where) {
  Diagnostics diagnostics;
  const std::optional<Tree> tree = parse_yaml(text, where, diagnostics);
  diagnostics.throw_if_any();
  const ParamInfo& info = node.info->params[param];
  Tree value = tree.value_or(Tree{});
  set_places(value, {where, 0, 0});
  const FileFinder files(fs::current_path());
  std::optional<ParamValue> read = read_param(value, node.name + "." + info.name, info, files, diagnostics);
  diagnostics.throw_if_any();
  return std::move(read).value();
}

std::string graph_name(const fs::path& file) {
  std::error_code ignored;
  const fs::path folder = fs::absolute(file, ignored).lexically_normal().parent_path();
  const std::string stem = file.stem().string();
  if (!fs::exists(folder / "scene.yaml", ignored)) return stem;
  return folder.filename().string() + (stem == "scene" ? "" : "_" + stem);
}

namespace {

/// `, here with prediction.type = prediction.kalman`: what a title cannot know, because a single value replaces a node.
std::string replaced_nodes(const Overrides& overrides) {
  std::string text;
  for (const Patch& patch : overrides) {
    const Assignment* assignment = patch.assignment();
    if (assignment == nullptr || !assignment->path.ends_with(".type")) continue;
    // The last one counts.
    if (find_assignment(overrides, assignment->path) != &patch) continue;
    text +=
        (text.empty() ? ", here with " : " and ") + assignment->path + " = " + std::string(trimmed(assignment->value));
  }
  return text;
}

/// The stem of a file as a part of a name: short, of letters, digits, `-`, `.` and `_`.
std::string plain_stem(const fs::path& file) {
  constexpr std::size_t longest = 40;
  return plain_name(file.stem().string().substr(0, longest));
}

/// `_local` for each file that is laid over a graph: what the graph's own name does not tell.
std::string overlay_names(const Overrides& overrides) {
  std::string names;
  for (const Patch& patch : overrides) {
    if (patch.file() != nullptr) names += "_" + plain_stem(*patch.file());
  }
  return names;
}

/// `, here with mine`: the files laid over the graph that did not bring its title.
std::string overlays_of_title(const Tree& title, const fs::path& graph, const Overrides& overrides) {
  std::string names;
  for (const Patch& patch : overrides) {
    if (patch.file() == nullptr) continue;
    std::error_code ignored;
    if (fs::equivalent(title.place.file, find_over(*patch.file(), graph).file, ignored)) continue;
    names += (names.empty() ? ", here with " : " and ") + plain_stem(*patch.file());
  }
  return names;
}

/// A time, or until_stopped, which no virtual clock can reach.
Duration read_run_duration(const Tree& tree, Clock clock, Diagnostics& diagnostics) {
  if (!tree.is_scalar() || tree.text != until_stopped_text) {
    return read_duration(tree, "duration", true, diagnostics).value_or(Duration{});
  }
  if (clock == Clock::virtual_) {
    diagnostics.error(tree.place, "duration: expected a time (s) with clock: virtual, found " + describe(tree) +
                                      "; only clock: real can run until it is stopped");
  }
  return until_stopped;
}

}  // namespace

GraphSpec load_graph(const fs::path& file, Registry& registry, const Overrides& overrides) {
  Diagnostics diagnostics;
  std::vector<fs::path> read;
  const std::optional<Tree> tree = compose(file, overrides, registry, diagnostics, read);
  if (!tree) diagnostics.throw_if_any();
  TACTOR_DEMAND(tree.has_value());

  GraphSpec spec;
  std::error_code ignored;
  spec.file = fs::absolute(file, ignored).lexically_normal();
  spec.files = std::move(read);
  spec.name = graph_name(file) + overlay_names(overrides);
  std::map<std::string, SourceLocation, std::less<>> places;
  collect_places(*tree, "", places);
  spec.places = std::make_shared<const std::map<std::string, SourceLocation, std::less<>>>(std::move(places));
  const FileFinder files(file.parent_path());
  check_keys(
      *tree, "", "key",
      {"format", "title", "extends", "clock", "duration", "seed", "rate", "live", "scene", "nodes", "edges", "record"},
      diagnostics);
  if (const Tree* title = tree->value("title")) {
    spec.title = read_text(*title, "title", diagnostics).value_or("");
    if (spec.title.find('\n') != std::string::npos) {
      diagnostics.error(title->place, "title: expected one line, found several");
    }
    if (find_assignment(overrides, "title") == nullptr)
      spec.title += overlays_of_title(*title, file, overrides) + replaced_nodes(overrides);
  }
  if (const Tree* clock = tree->value("clock")) {
    if (read_choice(*clock, "clock", {"virtual", "real"}, diagnostics) == "real") spec.clock = Clock::real;
  }
  if (const Tree* duration = tree->value("duration")) {
    spec.duration = read_run_duration(*duration, spec.clock, diagnostics);
  } else {
    diagnostics.error(tree->place, "expected the key duration, found none");
  }
  if (const Tree* seed = tree->value("seed")) {
    spec.seed = read_seed(*seed, "seed", diagnostics).value_or(spec.seed);
  }
  if (const Tree* live = tree->value("live")) spec.live = read_live(*live, files, diagnostics);
  if (const Tree* scene = tree->value("scene")) spec.scene = read_scene(*scene, files, diagnostics);
  std::set<std::string> broken;
  if (const Tree* nodes = tree->value("nodes")) {
    read_nodes(spec, broken, *nodes, registry, files, diagnostics);
    read_haptic_rate(spec, *tree, diagnostics);
    read_shared_parameters(spec, *tree, files, diagnostics);
    if (const Tree* edges = tree->value("edges")) {
      spec.edges = read_edges(*edges, spec.nodes, broken, diagnostics);
      check_realtime_edges(spec, diagnostics);
    }
    if (const Tree* record = tree->value("record")) {
      spec.record = read_record(*record, spec.nodes, broken, diagnostics);
      if (spec.duration == until_stopped && !spec.record.empty()) {
        diagnostics.error(record->place,
                          "record: expected no output with duration: until stopped, because the recording would grow "
                          "until the disk is full, found " +
                              list_of(spec.record) + "; write record: [], or give a duration");
      }
    }
  } else {
    diagnostics.error(tree->place, "expected the key nodes, found none");
  }
  diagnostics.throw_if_any();
  take_own_tool(spec);
  return spec;
}

}  // namespace tactor
