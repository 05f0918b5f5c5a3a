#include "framework/core/message_json.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::pair<FieldKind, std::string_view>, 11> kinds{{{FieldKind::i8, "i8"},
                                                                        {FieldKind::u8, "u8"},
                                                                        {FieldKind::i16, "i16"},
                                                                        {FieldKind::u16, "u16"},
                                                                        {FieldKind::i32, "i32"},
                                                                        {FieldKind::u32, "u32"},
                                                                        {FieldKind::i64, "i64"},
                                                                        {FieldKind::u64, "u64"},
                                                                        {FieldKind::f32, "f32"},
                                                                        {FieldKind::f64, "f64"},
                                                                        {FieldKind::record, "record"}}};

/// Bounds of what a text may describe, so that no text asks for more memory than a message has.
constexpr int most_depth = 8;
constexpr std::size_t most_fields = 4096;
constexpr std::size_t most_message_bytes = std::size_t{16} << 20U;

enum class Docs { left_out, included };

Json fields_json(const std::vector<Field>& fields, Docs docs) {
  Json list = Json::array();
  for (const Field& field : fields) {
    Json one;
    one["name"] = field.name;
    one["unit"] = field.unit;
    if (!field.frame.empty()) one["frame"] = field.frame;
    one["kind"] = name_of(field.kind);
    if (!field.shape.empty()) one["shape"] = field.shape;
    if (field.changes_size) one["changes_size"] = true;
    for (const Enumerator& value : field.enumerators) one["enumerators"][value.name] = value.value;
    if (field.kind == FieldKind::record) {
      one["record"] = field.record;
      one["fields"] = fields_json(field.fields, docs);
    }
    if (docs == Docs::included) {
      if (!field.doc.empty()) one["doc"] = field.doc;
      for (const Enumerator& value : field.enumerators) {
        if (!value.doc.empty()) one["docs"][value.name] = value.doc;
      }
    }
    list.push_back(std::move(one));
  }
  return list;
}

std::string json_text(const MessageType& type, Docs docs) {
  Json object;
  object["name"] = type.name;
  object["frame"] = type.frame;
  object["fields"] = fields_json(type.fields, docs);
  if (docs == Docs::included && !type.doc.empty()) object["doc"] = type.doc;
  // Prose of a library may be in another encoding than UTF-8, a name may not.
  return object.dump(-1, ' ', false,
                     docs == Docs::included ? Json::error_handler_t::replace : Json::error_handler_t::strict);
}

[[noreturn]] void refuse_message(const std::string& where, const std::string& why) {
  throw InputError("the description of message type " + where + ": " + why);
}

std::string text_of(const Json& object, const char* key, const std::string& where, const char* otherwise = nullptr) {
  const auto found = object.find(key);
  if (found == object.end() && otherwise != nullptr) return otherwise;
  if (found == object.end() || !found->is_string()) refuse_message(where, std::string(key) + " is missing or no text");
  return found->get<std::string>();
}

/// Reads fields, and counts what they ask for.
class FieldReader {
 public:
  std::vector<Field> read(const Json& object, const std::string& where, int depth, bool in_array) {
    const auto list = object.find("fields");
    if (list == object.end() || !list->is_array() || list->empty())
      refuse_message(where, "fields is missing or no list");
    if (depth > most_depth) refuse_message(where, "records are nested too deeply");
    std::vector<Field> fields;
    std::set<std::string> names;
    for (const Json& one : *list) {
      if (++count_ > most_fields) refuse_message(where, "it has too many fields");
      if (!one.is_object()) refuse_message(where, "a field is no object");
      fields.push_back(read_field(one, where, depth, in_array));
      if (!names.insert(fields.back().name).second)
        refuse_message(where, "two fields are called " + fields.back().name);
    }
    return fields;
  }

 private:
  Field read_field(const Json& one, const std::string& owner, int depth, bool in_array) {
    Field field;
    field.name = text_of(one, "name", owner);
    if (field.name.empty() || field.name.find_first_of("/. ,[]") != std::string::npos) {
      refuse_message(owner, "a field is called \"" + field.name + "\"");
    }
    const std::string where = owner + "." + field.name;
    field.unit = text_of(one, "unit", where);
    field.frame = text_of(one, "frame", where, "");
    const std::string kind = text_of(one, "kind", where);
    const auto known = std::find_if(kinds.begin(), kinds.end(), [&](const auto& k) { return k.second == kind; });
    if (known == kinds.end()) refuse_message(where, "there is no kind \"" + kind + "\"");
    field.kind = known->first;
    read_shape(one, where, field);
    if (const auto changes = one.find("changes_size"); changes != one.end()) {
      if (!changes->is_boolean()) refuse_message(where, "changes_size is neither true nor false");
      field.changes_size = changes->get<bool>();
      if (field.changes_size && in_array) refuse_message(where, "an array of changing size is in another one");
    }
    read_enumerators(one, where, field);
    if (field.kind == FieldKind::record) {
      field.record = text_of(one, "record", where);
      field.fields = read(one, where, depth + 1, in_array || field.changes_size);
    }
    return field;
  }

  static void read_shape(const Json& one, const std::string& where, Field& field) {
    const auto shape = one.find("shape");
    if (shape == one.end()) return;
    if (!shape->is_array() || shape->empty() || shape->size() > most_depth)
      refuse_message(where, "shape is no short list");
    std::size_t count = 1;
    for (const Json& n : *shape) {
      if (!n.is_number_unsigned() || n.get<std::uint64_t>() == 0 ||
          n.get<std::uint64_t>() > most_message_bytes / count) {
        refuse_message(where, "shape holds a value that is not a size");
      }
      field.shape.push_back(n.get<std::size_t>());
      count *= field.shape.back();
    }
  }

  static void read_enumerators(const Json& one, const std::string& where, Field& field) {
    const auto values = one.find("enumerators");
    if (values == one.end()) return;
    const bool whole = field.kind != FieldKind::f32 && field.kind != FieldKind::f64 && field.kind != FieldKind::record;
    if (!values->is_object() || values->empty() || !whole)
      refuse_message(where, "enumerators are of whole numbers alone");
    std::set<std::int64_t> seen;
    for (const auto& [name, value] : values->items()) {
      if (name.empty() || name.find_first_of(" ,;\n") != std::string::npos || !value.is_number_integer() ||
          !seen.insert(value.get<std::int64_t>()).second) {
        refuse_message(where, "the enumerator \"" + name + "\" has no name or no number of its own");
      }
      field.enumerators.push_back({name, value.get<std::int64_t>()});
    }
  }

  std::size_t count_ = 0;
};

/// Bytes of a message, without overflow; more than `most_message_bytes` where it is too large.
std::size_t bounded_size(const std::vector<Field>& fields) {
  std::size_t sum = 0;
  for (const Field& field : fields) {
    const std::size_t element = field.kind == FieldKind::record ? bounded_size(field.fields) + 8 : 8;
    const std::size_t count = count_of(field);
    if (element > most_message_bytes || count > most_message_bytes / element) return most_message_bytes + 1;
    sum += element * count;
    if (sum > most_message_bytes) return sum;
  }
  return sum;
}

}  // namespace

std::string_view name_of(FieldKind kind) {
  return std::find_if(kinds.begin(), kinds.end(), [&](const auto& k) { return k.first == kind; })->second;
}

std::string to_json(const MessageType& type) {
  return json_text(type, Docs::left_out);
}

std::string to_documented_json(const MessageType& type) {
  return json_text(type, Docs::included);
}

MessageType message_type_from_json(std::string_view text) {
  const Json object = Json::parse(text, nullptr, false);
  if (!object.is_object()) throw InputError("the description of a message type is not a JSON object");
  MessageType type;
  type.name = text_of(object, "name", "without a name");
  type.frame = text_of(object, "frame", type.name);
  type.fields = FieldReader().read(object, type.name, 0, false);
  if (bounded_size(type.fields) > most_message_bytes)
    refuse_message(type.name, "a message would be larger than 16 MiB");
  lay_out(type);
  return type;
}

}  // namespace tactor
