#include "framework/graph/study.hpp"

#include <algorithm>
#include <limits>
#include <set>

#include "framework/graph/merge.hpp"
#include "framework/graph/values.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

std::vector<fs::path> read_files(const Tree& tree, const std::string& key, const FileFinder& files,
                                 Diagnostics& diagnostics) {
  std::vector<fs::path> found;
  if (!tree.is_sequence() || tree.items.empty()) {
    diagnostics.error(tree.place, key + ": expected a list of graph files, found " + describe(tree));
    return found;
  }
  std::set<std::string> names;
  for (const Tree& item : tree.items) {
    const std::optional<fs::path> file = files.find(item, key, diagnostics);
    if (!file) continue;
    // Rows of the table are told apart by it.
    if (!names.insert(file->stem().string()).second) {
      diagnostics.error(item.place,
                        key + ": expected files of different names, found " + file->stem().string() + " again");
    }
    found.push_back(*file);
  }
  return found;
}

/// A scalar or a list or map of them as the YAML that --set takes.
std::string yaml_of(const Tree& tree) {
  const auto quoted = [](const std::string& text) {
    std::string out;
    for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
    return "'" + out + "'";
  };
  std::string text;
  switch (tree.kind) {
    case Tree::Kind::null:
      return "~";
    case Tree::Kind::scalar:
      return tree.quoted ? quoted(tree.text) : tree.text;
    case Tree::Kind::sequence:
      for (const Tree& item : tree.items) text += (text.empty() ? "" : ", ") + yaml_of(item);
      return "[" + text + "]";
    case Tree::Kind::map:
      for (const TreeEntry& entry : tree.entries)
        text += (text.empty() ? "" : ", ") + entry.key + ": " + yaml_of(entry.value);
      return "{" + text + "}";
  }
  return text;
}

std::vector<std::string> split_paths(const std::string& key) {
  std::vector<std::string> paths;
  for (std::size_t begin = 0; begin <= key.size();) {
    const std::size_t end = std::min(key.find(',', begin), key.size());
    paths.push_back(trimmed(std::string_view(key).substr(begin, end - begin)));
    begin = end + 1;
  }
  return paths;
}

}  // namespace

StudySpec load_study(const fs::path& file) {
  Diagnostics diagnostics;
  StudySpec study;
  study.name = file.stem().string();
  const std::optional<Tree> tree = read_yaml(file, file.string(), graph_file, diagnostics);
  diagnostics.throw_if_any();
  check_keys(*tree, "study", "key of a study", {"title", "graphs", "methods", "set", "vary", "seeds", "first_seed"},
             diagnostics);
  const FileFinder files(fs::absolute(file).parent_path(), {});
  if (const Tree* title = tree->value("title")) study.title = read_text(*title, "title", diagnostics).value_or("");
  if (const Tree* graphs = tree->value("graphs")) {
    study.graphs = read_files(*graphs, "graphs", files, diagnostics);
  } else {
    diagnostics.error(tree->place, "study: expected the key graphs, found none");
  }
  if (const Tree* methods = tree->value("methods")) study.methods = read_files(*methods, "methods", files, diagnostics);
  // A value that another one replaces would stand in the table all the same.
  std::set<std::string> named;
  const auto named_once = [&](const std::string& path, const Place& place, const std::string& key) {
    if (!named.insert(path).second) diagnostics.error(place, key + "." + path + ": named twice in `set` and `vary`");
  };
  const Tree* set = tree->value("set");
  if (set != nullptr && expect_map(*set, "set", "a map of node.parameter to its value", diagnostics)) {
    for (const TreeEntry& entry : set->entries) {
      for (const std::string& path : split_paths(entry.key)) {
        named_once(path, entry.value.place, "set");
        study.set.push_back(path + "=" + yaml_of(entry.value));
      }
    }
  }
  const Tree* vary = tree->value("vary");
  if (vary != nullptr && expect_map(*vary, "vary", "a map of node.parameter to a list of values", diagnostics)) {
    for (const TreeEntry& entry : vary->entries) {
      if (!entry.value.is_sequence() || entry.value.items.empty()) {
        diagnostics.error(entry.value.place,
                          "vary." + entry.key + ": expected a list of values, found " + describe(entry.value));
        continue;
      }
      StudyAxis axis{split_paths(entry.key), {}};
      for (const std::string& path : axis.paths) named_once(path, entry.value.place, "vary");
      for (const Tree& item : entry.value.items) {
        const std::string value = yaml_of(item);
        if (std::find(axis.values.begin(), axis.values.end(), value) != axis.values.end()) {
          diagnostics.error(item.place, "vary." + entry.key + ": expected different values, found " + value + " again");
        }
        axis.values.push_back(value);
      }
      study.vary.push_back(std::move(axis));
    }
  }
  if (const Tree* seeds = tree->value("seeds")) {
    study.seeds = read_integer(*seeds, "seeds", 1, 10000, diagnostics).value_or(1);
  }
  if (const Tree* first = tree->value("first_seed")) {
    study.first_seed = read_seed(*first, "first_seed", diagnostics).value_or(1);
  }
  diagnostics.throw_if_any();
  return study;
}

}  // namespace tactor
