#include "framework/record/hdf5_layout.hpp"

#include <algorithm>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/record/packed_layout.hpp"

namespace tactor::layout {

namespace {

Handle copied(hid_t type) {
  return {H5Tcopy(type), H5Tclose};
}

Handle scalar_type(FieldKind kind, bool in_file) {
  switch (kind) {
    case FieldKind::i8:
      return copied(in_file ? H5T_STD_I8LE : H5T_NATIVE_INT8);
    case FieldKind::u8:
      return copied(in_file ? H5T_STD_U8LE : H5T_NATIVE_UINT8);
    case FieldKind::i16:
      return copied(in_file ? H5T_STD_I16LE : H5T_NATIVE_INT16);
    case FieldKind::u16:
      return copied(in_file ? H5T_STD_U16LE : H5T_NATIVE_UINT16);
    case FieldKind::i32:
      return copied(in_file ? H5T_STD_I32LE : H5T_NATIVE_INT32);
    case FieldKind::u32:
      return copied(in_file ? H5T_STD_U32LE : H5T_NATIVE_UINT32);
    case FieldKind::i64:
      return copied(in_file ? H5T_STD_I64LE : H5T_NATIVE_INT64);
    case FieldKind::u64:
      return copied(in_file ? H5T_STD_U64LE : H5T_NATIVE_UINT64);
    case FieldKind::f32:
      return copied(in_file ? H5T_IEEE_F32LE : H5T_NATIVE_FLOAT);
    case FieldKind::f64:
      return copied(in_file ? H5T_IEEE_F64LE : H5T_NATIVE_DOUBLE);
    case FieldKind::record:
      break;
  }
  return {};
}

/// An enumeration over the integer `base`, whose values it takes as that integer.
Handle enumeration_type(const Handle& base, const std::vector<Enumerator>& values) {
  Handle type(H5Tenum_create(base.get()), H5Tclose);
  for (const Enumerator& one : values) {
    std::int64_t value = one.value;
    TACTOR_DEMAND(H5Tconvert(H5T_NATIVE_INT64, base.get(), 1, &value, nullptr, H5P_DEFAULT) >= 0);
    TACTOR_DEMAND(H5Tenum_insert(type.get(), one.name.c_str(), &value) >= 0);
  }
  return type;
}

/// A compound under construction, without padding.
class Compound {
 public:
  void add(const std::string& name, Handle type) {
    size_ += H5Tget_size(type.get());
    members_.push_back({name, std::move(type)});
  }
  [[nodiscard]] Handle type() const {
    Handle compound(H5Tcreate(H5T_COMPOUND, size_), H5Tclose);
    std::size_t offset = 0;
    for (const Member& member : members_) {
      TACTOR_DEMAND(H5Tinsert(compound.get(), member.name.c_str(), offset, member.type.get()) >= 0);
      offset += H5Tget_size(member.type.get());
    }
    return compound;
  }

 private:
  struct Member {
    std::string name;
    Handle type;
  };
  std::vector<Member> members_;
  std::size_t size_ = 0;
};

Handle field_type(const Field& field, bool in_file) {
  if (field.changes_size) {
    Compound range;
    range.add("first", scalar_type(FieldKind::u64, in_file));
    range.add("count", scalar_type(FieldKind::u64, in_file));
    return range.type();
  }
  Handle one;
  if (field.kind == FieldKind::record) {
    Compound record;
    for (const Field& part : field.fields) record.add(part.name, field_type(part, in_file));
    one = record.type();
  } else {
    one = scalar_type(field.kind, in_file);
    if (!field.enumerators.empty()) one = enumeration_type(one, field.enumerators);
  }
  if (field.shape.empty()) return one;
  const std::vector<hsize_t> dimensions(field.shape.begin(), field.shape.end());
  return {H5Tarray_create2(one.get(), static_cast<unsigned>(dimensions.size()), dimensions.data()), H5Tclose};
}

/// Fixed-length, so that no heap with bytes of its own is in the file.
Handle text_type(std::size_t size) {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.get(), std::max<std::size_t>(size, 1));
  H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  return type;
}

bool write_attribute(hid_t object, const char* name, hid_t file_type, hid_t memory_type, hid_t space,
                     const void* value) {
  const Handle attribute(H5Acreate2(object, name, file_type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return attribute && H5Awrite(attribute.get(), memory_type, value) >= 0;
}

bool write_scalar(hid_t object, const char* name, hid_t file_type, hid_t memory_type, const void* value) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  return write_attribute(object, name, file_type, memory_type, space.get(), value);
}

}  // namespace

std::uint64_t chunk_rows(std::size_t row_bytes) {
  return std::clamp<std::uint64_t>(chunk_bytes / row_bytes, 1, 1024);
}

Handle row_type(const MessageType& type, bool in_file) {
  Compound row;
  row.add("valid_ns", scalar_type(FieldKind::i64, in_file));
  row.add("produced_ns", scalar_type(FieldKind::i64, in_file));
  row.add("sequence", scalar_type(FieldKind::u64, in_file));
  for (const Field& field : type.fields) row.add(field.name, field_type(field, in_file));
  return row.type();
}

Handle element_type(const Field& field, bool in_file) {
  return field_type(element_of(field), in_file);
}

bool write_text(hid_t object, const char* name, std::string_view text) {
  const Handle type = text_type(text.size());
  const std::string padded = text.empty() ? std::string(1, '\0') : std::string(text);
  return write_scalar(object, name, type.get(), type.get(), padded.data());
}

bool write_integer(hid_t object, const char* name, std::int64_t value) {
  return write_scalar(object, name, H5T_STD_I64LE, H5T_NATIVE_INT64, &value);
}

bool write_unsigned(hid_t object, const char* name, std::uint64_t value) {
  return write_scalar(object, name, H5T_STD_U64LE, H5T_NATIVE_UINT64, &value);
}

std::optional<std::string> read_text(hid_t object, const char* name) {
  const Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  if (!attribute) return std::nullopt;
  const Handle type(H5Aget_type(attribute.get()), H5Tclose);
  const Handle space(H5Aget_space(attribute.get()), H5Sclose);
  if (!type || H5Tget_class(type.get()) != H5T_STRING || H5Tis_variable_str(type.get()) != 0) return std::nullopt;
  if (!space || H5Sget_simple_extent_npoints(space.get()) != 1) return std::nullopt;
  constexpr std::size_t most = std::size_t{1} << 26U;
  const std::size_t size = H5Tget_size(type.get());
  // A text that the file does not hold is not worth the memory for it.
  if (size > most || size > H5Aget_storage_size(attribute.get())) return std::nullopt;
  std::string text(size, '\0');
  if (H5Aread(attribute.get(), type.get(), text.data()) < 0) return std::nullopt;
  text.resize(std::min(text.size(), text.find('\0')));
  return text;
}

std::optional<std::uint64_t> read_unsigned(hid_t object, const char* name) {
  const Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  if (!attribute) return std::nullopt;
  const Handle type(H5Aget_type(attribute.get()), H5Tclose);
  const Handle space(H5Aget_space(attribute.get()), H5Sclose);
  if (!type || H5Tget_class(type.get()) != H5T_INTEGER) return std::nullopt;
  if (!space || H5Sget_simple_extent_npoints(space.get()) != 1) return std::nullopt;
  std::uint64_t value = 0;
  if (H5Aread(attribute.get(), H5T_NATIVE_UINT64, &value) < 0) return std::nullopt;
  return value;
}

}  // namespace tactor::layout
