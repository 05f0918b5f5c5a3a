// A YAML file as a plain tree with places, after aliases are expanded and what we do not allow is refused.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "framework/yaml/diagnostics.hpp"

namespace tactor {

struct TreeEntry;

/// A value of a YAML file.
struct Tree {
  enum class Kind : std::uint8_t { null, scalar, sequence, map };
  Kind kind = Kind::null;
  SourceLocation place;
  std::string text;                ///< of a scalar, without quotes
  bool quoted = false;             ///< of a scalar
  std::vector<Tree> items;         ///< of a sequence
  std::vector<TreeEntry> entries;  ///< of a map, in the order of the file, keys unique

  [[nodiscard]] bool is_null() const { return kind == Kind::null; }
  [[nodiscard]] bool is_scalar() const { return kind == Kind::scalar; }
  [[nodiscard]] bool is_sequence() const { return kind == Kind::sequence; }
  [[nodiscard]] bool is_map() const { return kind == Kind::map; }
  /// The entry of a map by its key; null where there is none or this is no map.
  [[nodiscard]] const TreeEntry* find(std::string_view key) const;
  [[nodiscard]] TreeEntry* find(std::string_view key);
  /// The value of that entry, or null.
  [[nodiscard]] const Tree* value(std::string_view key) const;
};

/// A key and its value.
struct TreeEntry {
  std::string key;
  SourceLocation place;
  Tree value;
};

/// What is there, for error texts: `"text"`, `3 mm`, `a map`, `a list`, `nothing`.
std::string describe(const Tree& tree);

/// Sets every place of the tree to `place`.
void set_places(Tree& tree, const SourceLocation& place);

/// Bounds on what a file may be; beyond them nothing sensible is meant.
inline constexpr std::uintmax_t max_yaml_bytes = std::uintmax_t{1} << 20;
inline constexpr std::size_t max_yaml_values = 100'000;  ///< after aliases are expanded
inline constexpr std::size_t max_yaml_keys = 2'000;      ///< of one map
inline constexpr std::size_t max_yaml_depth = 64;

/// Reads text of one YAML document; `file` is the name for error texts. Errors go to `diagnostics`; nothing is returned
/// where the text is no YAML or breaks a bound, while duplicate keys, tags and merge keys leave a tree to check
/// further.
std::optional<Tree> parse_yaml(const std::string& text, const std::string& file, Diagnostics& diagnostics);

/// What a file is, for error texts.
struct YamlFileKind {
  std::string noun;  ///< `a graph file`
  std::string keys;  ///< of its map: `nodes, edges, duration, ...`
};

/// The same for a file, which must hold a map; `name` is what errors call it.
std::optional<Tree> read_yaml(const std::filesystem::path& file, const std::string& name, const YamlFileKind& kind,
                              Diagnostics& diagnostics);

}  // namespace tactor
