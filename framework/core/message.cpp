#include "framework/core/message.hpp"

#include <xxhash.h>

#include <algorithm>
#include <deque>
#include <map>
#include <mutex>
#include <utility>

#include "framework/core/shared_array.hpp"

namespace tactor {

namespace {

struct Extent {
  std::size_t size = 0;
  std::size_t alignment = 1;
};

std::size_t rounded_up(std::size_t size, std::size_t alignment) {
  return (size + alignment - 1) / alignment * alignment;
}

std::size_t alignment_of(const Field& field) {
  if (field.changes_size) return alignof(SharedBytes);
  if (field.kind != FieldKind::record) return scalar_size(field.kind);
  std::size_t alignment = 1;
  for (const Field& part : field.fields) alignment = std::max(alignment, alignment_of(part));
  return alignment;
}

Extent lay_out_fields(std::vector<Field>& fields) {
  Extent extent;
  for (Field& field : fields) {
    if (field.kind == FieldKind::record) lay_out_fields(field.fields);
    const std::size_t alignment = alignment_of(field);
    const std::size_t size = field.changes_size ? sizeof(SharedBytes) : count_of(field) * element_size(field);
    field.offset = rounded_up(extent.size, alignment);
    extent.size = field.offset + size;
    extent.alignment = std::max(extent.alignment, alignment);
  }
  extent.size = rounded_up(extent.size, extent.alignment);
  return extent;
}

void find_arrays(const std::vector<Field>& fields, std::size_t begin, std::vector<std::size_t>& arrays) {
  for (const Field& field : fields) {
    const std::size_t at = begin + field.offset;
    if (field.changes_size) {
      arrays.push_back(at);
    } else if (field.kind == FieldKind::record) {
      const std::size_t stride = element_size(field);
      for (std::size_t i = 0; i < count_of(field); ++i) find_arrays(field.fields, at + i * stride, arrays);
    }
  }
}

/// Parts of a description, each with its length, so that no two descriptions read the same.
class DescriptionText {
 public:
  void add(std::string_view text) { text_.append(std::to_string(text.size())).append(":").append(text); }
  void add(std::int64_t value) { add(std::to_string(value)); }
  void add(const std::vector<Field>& fields) {
    add(static_cast<std::int64_t>(fields.size()));
    for (const Field& field : fields) {
      add(field.name), add(field.unit), add(field.frame), add(field.record);
      add(static_cast<std::int64_t>(field.kind));
      add(static_cast<std::int64_t>(field.changes_size));
      add(static_cast<std::int64_t>(field.shape.size()));
      for (const std::size_t n : field.shape) add(static_cast<std::int64_t>(n));
      add(static_cast<std::int64_t>(field.enumerators.size()));
      for (const Enumerator& one : field.enumerators) add(one.name), add(one.value);
      add(field.fields);
    }
  }
  [[nodiscard]] std::uint64_t hash() const { return XXH3_64bits(text_.data(), text_.size()); }

 private:
  std::string text_;
};

}  // namespace

std::size_t count_of(const Field& field) {
  std::size_t count = 1;
  for (const std::size_t n : field.shape) count *= n;
  return count;
}

std::size_t scalar_size(FieldKind kind) {
  switch (kind) {
    case FieldKind::i8:
    case FieldKind::u8:
      return 1;
    case FieldKind::i16:
    case FieldKind::u16:
      return 2;
    case FieldKind::i32:
    case FieldKind::u32:
    case FieldKind::f32:
      return 4;
    case FieldKind::i64:
    case FieldKind::u64:
    case FieldKind::f64:
      return 8;
    case FieldKind::record:
      break;
  }
  return 0;
}

std::size_t element_size(const Field& field) {
  if (field.kind != FieldKind::record) return scalar_size(field.kind);
  std::size_t end = 0;
  std::size_t alignment = 1;
  for (const Field& part : field.fields) {
    end = part.offset + (part.changes_size ? sizeof(SharedBytes) : count_of(part) * element_size(part));
    alignment = std::max(alignment, alignment_of(part));
  }
  return rounded_up(end, alignment);
}

void lay_out(MessageType& type) {
  const Extent extent = lay_out_fields(type.fields);
  type.size = extent.size;
  type.alignment = extent.alignment;
  type.arrays.clear();
  find_arrays(type.fields, 0, type.arrays);
  DescriptionText text;
  text.add(type.name), text.add(type.frame), text.add(type.fields);
  type.layout_hash = text.hash();
}

const MessageType& any_message() {
  static const MessageType type{.name = "any"};
  return type;
}

namespace {
struct KnownTypes {
  std::mutex mutex;
  std::map<std::string, const MessageType*, std::less<>> types;
};
KnownTypes& known_types() {
  static KnownTypes known;
  return known;
}
}  // namespace

void make_known(const MessageType& type) {
  const std::scoped_lock lock(known_types().mutex);
  known_types().types.try_emplace(type.name, &type);
}

const MessageType* known_message_type(std::string_view name) {
  const std::scoped_lock lock(known_types().mutex);
  const auto found = known_types().types.find(name);
  return found == known_types().types.end() ? nullptr : found->second;
}

const MessageType& keep_message_type(MessageType type) {
  static std::mutex mutex;
  static std::deque<MessageType> kept;
  const std::scoped_lock lock(mutex);
  for (const MessageType& one : kept) {
    if (same_type(one, type)) return one;
  }
  return kept.emplace_back(std::move(type));
}

}  // namespace tactor
