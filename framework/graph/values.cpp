#include "framework/graph/values.hpp"

#include <algorithm>
#include <charconv>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

std::optional<Table> read_table(const Tree& tree, const std::string& path, const ParamInfo& param,
                                Diagnostics& diagnostics) {
  std::vector<std::string> names;
  for (const ColumnInfo& column : param.columns) names.push_back(column.name);
  const std::string expected = "expected a list of rows, each a map or a list of " + list_of(names);
  if (!tree.is_sequence()) {
    diagnostics.error(tree.place, path + ": " + expected + ", found " + describe(tree));
    return std::nullopt;
  }
  Table table{param.columns.size(), {}};
  bool good = true;
  for (std::size_t r = 0; r < tree.items.size(); ++r) {
    const Tree& row = tree.items[r];
    const std::string row_path = path + "[" + std::to_string(r) + "]";
    if (!row.is_map() && !(row.is_sequence() && row.items.size() == param.columns.size())) {
      const std::string found = row.is_sequence() ? "a list of " + std::to_string(row.items.size()) : describe(row);
      diagnostics.error(row.place, row_path + ": expected a map or a list of " + list_of(names) + ", found " + found);
      good = false;
      continue;
    }
    if (row.is_map()) check_keys(row, row_path, "column", names, diagnostics);
    for (std::size_t c = 0; c < param.columns.size(); ++c) {
      const ColumnInfo& column = param.columns[c];
      const TreeEntry* entry = row.is_map() ? row.find(column.name) : nullptr;
      const Tree* cell = row.is_sequence() ? &row.items[c] : entry != nullptr ? &entry->value : nullptr;
      std::optional<double> value;
      if (cell != nullptr) {
        value = read_number(*cell, row_path + "." + column.name, {.unit = column.unit}, diagnostics);
      } else if (column.default_value) {
        value = column.default_value;
      } else {
        diagnostics.error(row.place, row_path + ": expected the column " + column.name + ", found none");
      }
      good = good && value.has_value();
      table.values.push_back(value.value_or(0));
    }
  }
  return good ? std::optional(std::move(table)) : std::nullopt;
}

std::optional<Mapping> read_mapping(const Tree& tree, const std::string& path, Diagnostics& diagnostics) {
  if (!expect_map(tree, path, "a map of names to texts", diagnostics)) return std::nullopt;
  Mapping mapping;
  bool good = true;
  for (const TreeEntry& entry : tree.entries) {
    std::optional<std::string> text = read_text(entry.value, path + "." + entry.key, diagnostics);
    good = good && text.has_value();
    mapping.emplace_back(entry.key, std::move(text).value_or(""));
  }
  return good ? std::optional(std::move(mapping)) : std::nullopt;
}

template <class T>
std::optional<ParamValue> as_param(std::optional<T> value) {
  if (!value) return std::nullopt;
  return ParamValue(std::move(*value));
}

}  // namespace

std::optional<std::uint64_t> read_seed(const Tree& tree, const std::string& path, Diagnostics& diagnostics) {
  std::uint64_t value = 0;
  if (tree.is_scalar() && !tree.quoted && is_decimal(tree.text)) {
    const auto result = std::from_chars(tree.text.data(), tree.text.data() + tree.text.size(), value);
    if (result.ec == std::errc{} && result.ptr == tree.text.data() + tree.text.size()) return value;
  }
  diagnostics.error(tree.place,
                    path + ": expected a whole number from 0 to 18446744073709551615, found " + describe(tree));
  return std::nullopt;
}

std::optional<ParamValue> read_param(const Tree& tree, const std::string& path, const ParamInfo& param,
                                     const FileFinder& files, Diagnostics& diagnostics) {
  const NumberRule rule{param.unit, param.min, param.max, param.above_min};
  switch (param.kind) {
    case ParamKind::boolean:
      return as_param(read_boolean(tree, path, diagnostics));
    case ParamKind::integer:
      return as_param(read_integer(tree, path, static_cast<std::int64_t>(param.min),
                                   static_cast<std::int64_t>(param.max), diagnostics));
    case ParamKind::real:
      return as_param(read_number(tree, path, rule, diagnostics));
    case ParamKind::text:
      return as_param(read_text(tree, path, diagnostics));
    case ParamKind::choice:
      return as_param(read_choice(tree, path, param.choices, diagnostics));
    case ParamKind::reals:
      return as_param(read_numbers(tree, path, param.size, rule, diagnostics));
    case ParamKind::table:
      return as_param(read_table(tree, path, param, diagnostics));
    case ParamKind::mapping:
      return as_param(read_mapping(tree, path, diagnostics));
    case ParamKind::file:
      break;
  }
  if (tree.is_scalar() && tree.text.empty() && param.default_value) return ParamValue(std::string());
  const auto file = files.find(tree, path, param.file, diagnostics);
  if (!file) return std::nullopt;
  return ParamValue(file->string());
}

bool check_name(const TreeEntry& entry, const std::string& path, Diagnostics& diagnostics) {
  static const std::vector<std::string> reserved{
      "title", "extends", "bind", "clock", "duration", "seed",  "rate",   "live", "scene", "nodes", "edges", "record",
      "none",  "null",    "true", "false", "world",    "queue", "latest", "from", "to",    "delay", "all"};
  constexpr std::size_t longest = 64;
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto rest = [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '_'; };
  const std::string& name = entry.key;
  if (name.empty() || name.size() > longest || !letter(name[0]) || !std::all_of(name.begin(), name.end(), rest)) {
    Tree text;
    text.kind = Tree::Kind::scalar;
    text.quoted = true;
    text.text = name;
    diagnostics.error(entry.place,
                      path + ": expected a name of at most 64 letters, digits and _ that begins with a letter, found " +
                          describe(text));
    return false;
  }
  if (std::find(reserved.begin(), reserved.end(), name) == reserved.end()) return true;
  diagnostics.error(entry.place, path + ": \"" + name + "\" is a reserved word; choose another name");
  return false;
}

}  // namespace tactor
