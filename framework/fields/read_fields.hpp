// Reads described structs (fields.hpp) out of a YAML tree. Each error is told with its place. A struct that was read
// with an error is not to be used.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "framework/core/spatial.hpp"
#include "framework/fields/fields.hpp"
#include "framework/yaml/file_finder.hpp"
#include "framework/yaml/yaml_values.hpp"

namespace tactor {

/// The map that a struct was read from, for rules over several of its fields.
class FieldCheck {
 public:
  FieldCheck(const Tree& map, std::string path, bool good, Diagnostics& diagnostics)
      : map_(map), path_(std::move(path)), good_(good), diagnostics_(diagnostics) {}
  /// True if all of its fields were read without an error.
  [[nodiscard]] bool is_good() const { return good_; }
  [[nodiscard]] const Tree* value(std::string_view key) const { return map_.value(key); }
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] Diagnostics& diagnostics() const { return diagnostics_; }
  /// An error of the whole map, at the place of `key` if it has that.
  void error(std::string_view key, const std::string& text) const {
    const Tree* at = map_.value(key);
    diagnostics_.error(at != nullptr ? at->place : map_.place, path_ + text);
  }

 private:
  const Tree& map_;
  std::string path_;
  bool good_;
  Diagnostics& diagnostics_;
};

/// Reads the fields of one map; a visitor.
class FieldReader {
 public:
  /// All of these outlive it. `files` finds the files that are named.
  FieldReader(const Tree& map, std::string path, const FileFinder& files, Diagnostics& diagnostics)
      : map_(map), path_(std::move(path)), files_(files), diagnostics_(diagnostics), place_(map.place) {}

  template <class T>
  void field(const char* name, T& member, const FieldRule& rule) {
    if (const Tree* tree = wanted(name, rule)) read(*tree, at(name), member, rule);
  }
  template <class E>
  void choice(const char* name, E& member, const std::vector<std::string>& words, const FieldRule& rule) {
    const Tree* tree = wanted(name, rule);
    const auto text = tree ? read_choice(*tree, at(name), words, diagnostics_) : std::nullopt;
    if (text) member = static_cast<E>(std::find(words.begin(), words.end(), *text) - words.begin());
  }
  template <class Inner>
  void map(const char* name, const FieldRule& rule, const Inner& inner) {
    const Tree* tree = wanted(name, rule);
    if (tree == nullptr) return;
    FieldKeys keys;
    inner(keys);
    if (!is_map_of(*tree, at(name), keys.keys)) return;
    FieldReader reader(*tree, at(name), files_, diagnostics_);
    inner(reader);
  }
  template <class Variant, class... Alternatives>
  void one_of(Variant& member, const Alternatives&... alternatives) {
    std::vector<std::string> names, found;
    (names.emplace_back(alternatives.name), ...);
    std::copy_if(names.begin(), names.end(), std::back_inserter(found),
                 [this](const std::string& name) { return map_.value(name) != nullptr; });
    if (found.size() == 1) return (read_alternative(member, alternatives), ...);
    // It may be an unknown key, which is told already.
    if (found.empty() && has_unknown_keys_) return;
    diagnostics_.error(
        place_, path_ + ": expected one of " + list_of(names) + ", found " + (found.empty() ? "none" : list_of(found)));
  }
  template <class T>
  void list_or_one(const char* name, std::vector<T>& member, const FieldRule& rule) {
    const Tree* tree = wanted(name, rule);
    if (tree == nullptr) return;
    if (!tree->is_sequence() || tree->items.empty()) read(*tree, at(name), member.emplace_back(), {});
    for (std::size_t i = 0; i < tree->items.size(); ++i) {
      read(tree->items[i], at(name) + "[" + std::to_string(i) + "]", member.emplace_back(), {});
    }
  }
  template <class T>
  void by_name(const char* name, std::vector<T>& member, const FieldRule& rule) {
    const Tree* tree = wanted(name, rule);
    if (tree == nullptr || !expect_map(*tree, at(name), "a map by name", diagnostics_)) return;
    for (const TreeEntry& entry : tree->entries) {
      // A file that extends another takes one out by ~.
      if (entry.value.is_null()) continue;
      T& value = member.emplace_back();
      constexpr bool named = requires {
        value.name;
      };
      if constexpr (named) value.name = entry.key;
      read_map(entry.value, at(name) + "." + entry.key, value, named ? entry.place : entry.value.place);
    }
  }
  template <class Inner>
  void only(bool applies, std::string_view otherwise, const Inner& inner) {
    // What is around it may refuse it already.
    const std::string_view before = refused_;
    if (before.empty() && !applies) refused_ = otherwise;
    inner();
    refused_ = before;
  }

  /// Reads a value; false where it is wrong.
  bool read(const Tree& tree, const std::string& path, double& value, const FieldRule& rule) {
    return keep(value, read_number(tree, path, number_rule(rule), diagnostics_));
  }
  bool read(const Tree& tree, const std::string& path, int& value, const FieldRule& rule) {
    return keep(value, read_integer(tree, path, static_cast<std::int64_t>(rule.min),
                                    static_cast<std::int64_t>(rule.max), diagnostics_));
  }
  bool read(const Tree& tree, const std::string& path, bool& value, const FieldRule& /*rule*/) {
    return keep(value, read_boolean(tree, path, diagnostics_));
  }
  bool read(const Tree& tree, const std::string& path, std::string& value, const FieldRule& /*rule*/) {
    return keep(value, read_text(tree, path, diagnostics_));
  }
  bool read(const Tree& tree, const std::string& path, Duration& value, const FieldRule& rule) {
    return keep(value, read_duration(tree, path, rule.above_min, diagnostics_));
  }
  bool read(const Tree& tree, const std::string& path, std::filesystem::path& value, const FieldRule& rule) {
    return keep(value, files_.find(tree, path, *rule.files, diagnostics_));
  }
  bool read(const Tree& tree, const std::string& path, Vec3& value, const FieldRule& rule) {
    const auto numbers = read_numbers(tree, path, 3, number_rule(rule), diagnostics_);
    if (numbers) value = {(*numbers)[0], (*numbers)[1], (*numbers)[2]};
    return numbers.has_value();
  }
  template <std::size_t n>
  bool read(const Tree& tree, const std::string& path, std::array<double, n>& value, const FieldRule& rule) {
    const auto numbers = read_numbers(tree, path, n, number_rule(rule), diagnostics_);
    if (numbers) std::copy(numbers->begin(), numbers->end(), value.begin());
    return numbers.has_value();
  }
  template <class T>
  bool read(const Tree& tree, const std::string& path, std::optional<T>& value, const FieldRule& rule) {
    T inner{};
    const bool good = read(tree, path, inner, rule);
    if (good) value = std::move(inner);
    return good;
  }
  template <class T>
  requires(has_text<T> || Described<T>) bool read(const Tree& tree, const std::string& path, T& value,
                                                  const FieldRule& rule) {
    if constexpr (has_text<T>) {
      TextOf<T> text{};
      const bool good = read(tree, path, text, rule);
      if (good) value = from_text(text);
      return good;
    } else {
      return read_map(tree, path, value, tree.place);
    }
  }

 private:
  static NumberRule number_rule(const FieldRule& rule) {
    return {std::string(rule.unit), rule.min, rule.max, rule.above_min, rule.reason};
  }
  template <class T, class Read>
  static bool keep(T& value, const std::optional<Read>& read) {
    if (read) value = static_cast<T>(*read);
    return read.has_value();
  }
  [[nodiscard]] std::string at(std::string_view name) const { return path_ + "." + std::string(name); }

  /// The value of the key, if there is one and it may be read.
  const Tree* wanted(const char* name, const FieldRule& rule) {
    const Tree* tree = map_.value(name);
    if (tree == nullptr && rule.required && refused_.empty()) {
      diagnostics_.error(place_, path_ + ": expected the key " + name + ", found none");
    }
    if (tree == nullptr || refused_.empty()) return tree;
    diagnostics_.error(tree->place, at(name) + ": " + std::string(refused_));
    return nullptr;
  }
  /// Reads a struct; `place` is that of errors of the whole.
  template <Described T>
  bool read_map(const Tree& tree, const std::string& path, T& value, const SourceLocation& place) {
    const std::size_t before = diagnostics_.list().size();
    if (!is_map_of(tree, path, keys_of<T>())) return false;
    FieldReader reader(tree, path, files_, diagnostics_);
    reader.place_ = place;
    reader.has_unknown_keys_ = diagnostics_.list().size() > before;
    fields(reader, value);
    if constexpr (requires { check(value, std::declval<const FieldCheck&>()); }) {
      check(value, FieldCheck(tree, path, diagnostics_.list().size() == before, diagnostics_));
    }
    return diagnostics_.list().size() == before;
  }
  bool is_map_of(const Tree& tree, const std::string& path, const std::vector<std::string>& keys) {
    const std::string expected = keys.empty() ? "a map without keys: {}" : "a map with " + list_of(keys);
    if (!expect_map(tree, path, expected, diagnostics_)) return false;
    check_keys(tree, path, "key", keys, diagnostics_);
    return true;
  }
  template <class Variant, class T>
  void read_alternative(Variant& member, const Alternative<T>& alternative) {
    if (map_.value(alternative.name) == nullptr) return;
    field(alternative.name, member.template emplace<T>(), alternative.rule);
  }
  template <class Variant, class T, class Member>
  void read_alternative(Variant& member, const MemberAlternative<T, Member>& alternative) {
    if (map_.value(alternative.name) == nullptr) return;
    field(alternative.name, member.template emplace<T>().*alternative.member, alternative.rule);
  }

  const Tree& map_;
  std::string path_;
  const FileFinder& files_;
  Diagnostics& diagnostics_;
  SourceLocation place_;  // of errors of the whole map
  bool has_unknown_keys_ = false;
  std::string_view refused_;  // why the keys that are visited do not belong here; empty: they do
};

/// Reads a described struct.
template <Described T>
void read_fields(const Tree& tree, const std::string& path, T& value, const FileFinder& files,
                 Diagnostics& diagnostics) {
  FieldReader(tree, path, files, diagnostics).read(tree, path, value, {});
}

}  // namespace tactor
