#include "framework/yaml/yaml_tree.hpp"

#include <fstream>

#include "framework/yaml/nearby_files.hpp"

namespace tactor {

namespace fs = std::filesystem;

const TreeEntry* Tree::find(std::string_view key) const {
  for (const TreeEntry& entry : entries) {
    if (entry.key == key) return &entry;
  }
  return nullptr;
}

TreeEntry* Tree::find(std::string_view key) {
  for (TreeEntry& entry : entries) {
    if (entry.key == key) return &entry;
  }
  return nullptr;
}

const Tree* Tree::value(std::string_view key) const {
  const TreeEntry* entry = find(key);
  return entry == nullptr ? nullptr : &entry->value;
}

std::string describe(const Tree& tree) {
  switch (tree.kind) {
    case Tree::Kind::null:
      return "nothing";
    case Tree::Kind::sequence:
      return "a list";
    case Tree::Kind::map:
      return "a map";
    case Tree::Kind::scalar:
      break;
  }
  constexpr std::size_t longest = 60;
  std::string text;
  for (const char c : tree.text.substr(0, longest)) text += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  if (tree.text.size() > longest) text += "...";
  return tree.quoted || text.empty() ? "\"" + text + "\"" : text;
}

void set_places(Tree& tree, const Place& place) {
  tree.place = place;
  for (Tree& item : tree.items) set_places(item, place);
  for (TreeEntry& entry : tree.entries) {
    entry.place = place;
    set_places(entry.value, place);
  }
}

std::optional<Tree> read_yaml(const fs::path& file, const std::string& name, const YamlFileKind& kind,
                              Diagnostics& diagnostics) {
  std::error_code ignored;
  const Place whole{name, 0, 0};
  if (!fs::exists(file, ignored)) {
    diagnostics.error(whole, "there is no such file" + nearby_files({file}));
    return std::nullopt;
  }
  if (fs::is_directory(file, ignored)) {
    diagnostics.error(whole, "expected " + kind.noun + ", found a folder");
    return std::nullopt;
  }
  std::ifstream stream(file, std::ios::binary);
  // One byte past the bound tells too large a file without reading all of it.
  std::string text(max_yaml_bytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad() || (!stream && !stream.eof())) {
    diagnostics.error(whole, "the file cannot be read");
    return std::nullopt;
  }
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > max_yaml_bytes) {
    diagnostics.error(whole, "expected at most " + std::to_string(max_yaml_bytes) + " bytes, found a larger file");
    return std::nullopt;
  }
  std::optional<Tree> tree = parse_yaml(text, name, diagnostics);
  if (tree && !tree->is_map()) {
    const std::string found = tree->is_null() ? "an empty file" : describe(*tree);
    diagnostics.error(tree->place.line > 0 ? tree->place : whole,
                      "expected a map with the keys " + kind.keys + ", found " + found);
    return std::nullopt;
  }
  return tree;
}

}  // namespace tactor
