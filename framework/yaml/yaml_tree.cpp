#include "framework/yaml/yaml_tree.hpp"

#include "framework/core/input_file.hpp"
#include "framework/yaml/file_finder.hpp"

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

void set_places(Tree& tree, const SourceLocation& place) {
  tree.place = place;
  for (Tree& item : tree.items) set_places(item, place);
  for (TreeEntry& entry : tree.entries) {
    entry.place = place;
    set_places(entry.value, place);
  }
}

std::optional<Tree> read_yaml(const fs::path& file, const std::string& name, const YamlFileKind& kind,
                              Diagnostics& diagnostics) {
  const SourceLocation whole{name, 0, 0};
  InputFile input = open_input(file);
  std::string text;
  if (!input.file || !input.read(text, max_yaml_bytes)) {
    const std::string error = input.is_missing ? input.error + looked_for({{}, {file}}) : input.error;
    diagnostics.error(whole, input.found.empty() ? error : "expected " + kind.noun + ", found " + input.found);
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
