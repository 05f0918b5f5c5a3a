// How a struct describes its fields, once, to all that reads, writes and documents it: by a function template
// `fields(visit, value)` that calls a function of the visitor for each key (see FieldKeys, and scene_fields.hpp). Rules
// over several fields stand in `void check(T&, const FieldCheck&)`, which a reader calls (read_fields.hpp).
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/file_lookup.hpp"

namespace tactor {

/// What a field may hold, and what it means.
struct FieldRule {
  std::string_view doc = {};
  std::string_view unit = "1";  ///< of numbers, SI
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool above_min = false;             ///< true: larger than `min`
  bool required = false;              ///< it has no default
  std::string_view reason = {};       ///< for the bounds, if they need one
  const FileKind* files = &any_file;  ///< of files
};

/// A type of a variant and its key. Its value is a map of the type's fields.
template <class T>
struct Alternative {
  const char* name;
  FieldRule rule;
};
/// The same for a type of which the value is one member.
template <class T, class Member>
struct MemberAlternative {
  const char* name;
  Member T::*member;
  FieldRule rule;
};

/// A struct that is described in another form (`Text as_text(const T&)`, `T from_text(const Text&)`) names it here.
template <class T>
struct DescribedAs {
  using Text = T;
};
template <class T>
using TextOf = typename DescribedAs<T>::Text;
template <class T>
inline constexpr bool has_text = !std::is_same_v<T, TextOf<T>>;

/// Collects the keys of a described struct. It is the simplest visitor, and tells what a visitor has.
class FieldKeys {
 public:
  std::vector<std::string> keys;
  /// A number, text, list, file or other described struct. An optional member may be absent.
  void field(const char* name, const auto& /*member*/, const FieldRule& /*rule*/) { keys.emplace_back(name); }
  /// An enumeration; `words` are in the order of its values.
  void choice(const char* name, const auto& /*member*/, const auto& /*words*/, const FieldRule& /*rule*/) {
    keys.emplace_back(name);
  }
  /// A map whose keys `inner(visitor)` describes.
  void map(const char* name, const FieldRule& /*rule*/, const auto& /*inner*/) { keys.emplace_back(name); }
  /// A variant: exactly one of several keys, each an Alternative.
  void one_of(const auto& /*member*/, const auto&... alternatives) { (keys.emplace_back(alternatives.name), ...); }
  /// A list of described values, or one of them alone.
  void list_or_one(const char* name, const auto& /*member*/, const FieldRule& /*rule*/) { keys.emplace_back(name); }
  /// A map of described values by name.
  void by_name(const char* name, const auto& /*member*/, const FieldRule& /*rule*/) { keys.emplace_back(name); }
  /// The keys that `inner()` describes belong to this value only if `applies`. Otherwise a writer leaves them out, and
  /// a reader refuses them with `otherwise`, unless that is empty.
  void only(bool /*applies*/, std::string_view /*otherwise*/, const auto& inner) { inner(); }
};

template <class T>
concept Described = requires(FieldKeys& keys, T& value) {
  fields(keys, value);
};

/// The keys of a described struct, in the order of its description.
template <Described T>
std::vector<std::string> keys_of() {
  FieldKeys visit;
  T value;
  fields(visit, value);
  return visit.keys;
}

}  // namespace tactor
