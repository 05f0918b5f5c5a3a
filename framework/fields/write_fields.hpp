// Writes described structs (fields.hpp) as YAML that reads back the same.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "framework/core/spatial.hpp"
#include "framework/core/time.hpp"
#include "framework/fields/fields.hpp"
#include "framework/yaml/yaml_text.hpp"
#include "framework/yaml/yaml_values.hpp"

namespace tactor {

/// Keys and values in one line each; a visitor.
class FieldWriter {
 public:
  using Entry = std::pair<std::string, std::string>;
  std::vector<Entry> entries;

  template <class T>
  void field(const char* name, const T& member, const FieldRule& /*rule*/) {
    if (const std::string value = text(member); !value.empty()) add(name, value);
  }
  template <class E>
  void choice(const char* name, E member, const std::vector<std::string>& words, const FieldRule& /*rule*/) {
    add(name, words[static_cast<std::size_t>(member)]);
  }
  template <class Inner>
  void map(const char* name, const FieldRule& /*rule*/, const Inner& inner) {
    FieldWriter writer;
    inner(writer);
    add(name, writer.flow());
  }
  template <class Variant, class... Alternatives>
  void one_of(const Variant& member, const Alternatives&... alternatives) {
    (write_alternative(member, alternatives), ...);
  }
  template <class T>
  void list_or_one(const char* name, const std::vector<T>& member, const FieldRule& /*rule*/) {
    std::string list;
    for (const T& one : member) list += (list.empty() ? "" : ", ") + text(one);
    if (!list.empty()) add(name, "[" + list + "]");
  }
  template <class T>
  void by_name(const char* name, const std::vector<T>& member, const FieldRule& /*rule*/) {
    FieldWriter writer;
    for (std::size_t i = 0; i < member.size(); ++i) {
      if constexpr (requires { member[i].name; }) {
        writer.add(member[i].name, text(member[i]));
      } else {
        // `inclusions` has no names that matter: `inclusion_1`.
        std::string key = name;
        key.pop_back();
        writer.add(key + "_" + std::to_string(i + 1), text(member[i]));
      }
    }
    if (!member.empty()) add(name, writer.flow());
  }
  template <class Inner>
  void only(bool applies, std::string_view /*otherwise*/, const Inner& inner) {
    const bool before = std::exchange(applies_, applies_ && applies);
    inner();
    applies_ = before;
  }

  /// `{a: 1, b: 2}`.
  [[nodiscard]] std::string flow() const {
    std::string all;
    for (const auto& [key, value] : entries) all += (all.empty() ? "" : ", ") + key + ": " + value;
    return "{" + all + "}";
  }

  /// A value in one line; empty if it is absent.
  static std::string text(bool value) { return value ? "true" : "false"; }
  static std::string text(int value) { return std::to_string(value); }
  static std::string text(double value) { return number_text(value); }
  static std::string text(Duration value) { return number_text(value.seconds()); }
  static std::string text(const std::string& value) { return yaml_quoted(value); }
  static std::string text(const std::filesystem::path& value) { return yaml_quoted(value.string()); }
  static std::string text(const Vec3& value) { return text(std::array{value.x, value.y, value.z}); }
  template <std::size_t n>
  static std::string text(const std::array<double, n>& value) {
    return yaml_list({value.begin(), value.end()});
  }
  template <class T>
  static std::string text(const std::optional<T>& value) {
    return value ? text(*value) : std::string();
  }
  template <class T>
  requires(has_text<T> || Described<T>) static std::string text(const T& value) {
    if constexpr (has_text<T>) {
      return text(as_text(value));
    } else {
      FieldWriter writer;
      T copy = value;
      fields(writer, copy);
      return writer.flow();
    }
  }

 private:
  void add(std::string key, std::string value) {
    if (applies_) entries.emplace_back(std::move(key), std::move(value));
  }
  template <class Variant, class T>
  void write_alternative(const Variant& member, const Alternative<T>& alternative) {
    if (const T* value = std::get_if<T>(&member)) add(alternative.name, text(*value));
  }
  template <class Variant, class T, class Member>
  void write_alternative(const Variant& member, const MemberAlternative<T, Member>& alternative) {
    if (const T* value = std::get_if<T>(&member)) add(alternative.name, text(value->*alternative.member));
  }

  bool applies_ = true;
};

/// The keys and values of a described struct.
template <Described T>
std::vector<FieldWriter::Entry> written_fields(const T& value) {
  FieldWriter writer;
  T copy = value;
  fields(writer, copy);
  return writer.entries;
}

}  // namespace tactor
