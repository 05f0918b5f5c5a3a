#include "framework/record/hdf5_layout.hpp"

#include <algorithm>
#include <cstring>

namespace tactor::layout {

namespace {

struct FieldTypes {
  hid_t file;
  hid_t memory;
};

FieldTypes types_of(FieldKind kind) {
  switch (kind) {
    case FieldKind::f64:
      return {H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE};
    case FieldKind::i64:
      return {H5T_STD_I64LE, H5T_NATIVE_INT64};
    case FieldKind::i32:
      return {H5T_STD_I32LE, H5T_NATIVE_INT32};
  }
  return {-1, -1};
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

std::size_t field_size(const Field& field) {
  return field.count * (field.kind == FieldKind::i32 ? 4 : 8);
}

std::size_t record_size(const MessageType& type) {
  std::size_t size = stamp_size;
  for (const Field& field : type.fields) size += field_size(field);
  return size;
}

std::uint64_t chunk_rows(const MessageType& type) {
  return std::clamp<std::uint64_t>(chunk_bytes / record_size(type), 1, 1024);
}

Handle record_type(const MessageType& type, bool in_file) {
  Handle record(H5Tcreate(H5T_COMPOUND, record_size(type)), H5Tclose);
  H5Tinsert(record.get(), "valid_ns", 0, in_file ? H5T_STD_I64LE : H5T_NATIVE_INT64);
  H5Tinsert(record.get(), "produced_ns", 8, in_file ? H5T_STD_I64LE : H5T_NATIVE_INT64);
  H5Tinsert(record.get(), "sequence", 16, in_file ? H5T_STD_U64LE : H5T_NATIVE_UINT64);
  std::size_t offset = stamp_size;
  for (const Field& field : type.fields) {
    const hid_t scalar = in_file ? types_of(field.kind).file : types_of(field.kind).memory;
    const std::string name(field.name);
    if (field.count == 1) {
      H5Tinsert(record.get(), name.c_str(), offset, scalar);
    } else {
      const hsize_t count = field.count;
      const Handle array(H5Tarray_create2(scalar, 1, &count), H5Tclose);
      H5Tinsert(record.get(), name.c_str(), offset, array.get());
    }
    offset += field_size(field);
  }
  return record;
}

void pack(const MessageType& type, const Stamp& stamp, const void* payload, std::vector<std::byte>& records) {
  std::size_t at = records.size();
  records.resize(at + record_size(type));
  const auto put = [&](const void* from, std::size_t size) {
    std::memcpy(records.data() + at, from, size);
    at += size;
  };
  put(&stamp.valid.ns, 8);
  put(&stamp.produced.ns, 8);
  put(&stamp.sequence, 8);
  for (const Field& field : type.fields) put(static_cast<const std::byte*>(payload) + field.offset, field_size(field));
}

void unpack(const MessageType& type, const std::byte* record, Stamp& stamp, std::byte* payload) {
  const auto take = [&record](void* to, std::size_t size) {
    std::memcpy(to, record, size);
    record += size;
  };
  take(&stamp.valid.ns, 8);
  take(&stamp.produced.ns, 8);
  take(&stamp.sequence, 8);
  std::memset(payload, 0, type.size);
  for (const Field& field : type.fields) take(payload + field.offset, field_size(field));
}

bool write_text(hid_t object, const char* name, std::string_view text) {
  const Handle type = text_type(text.size());
  const std::string padded = text.empty() ? std::string(1, '\0') : std::string(text);
  return write_scalar(object, name, type.get(), type.get(), padded.data());
}

bool write_texts(hid_t object, const char* name, const std::vector<std::string_view>& texts) {
  std::size_t width = 1;
  for (const std::string_view text : texts) width = std::max(width, text.size());
  std::string padded;
  for (const std::string_view text : texts) padded.append(text).append(width - text.size(), '\0');
  const Handle type = text_type(width);
  const hsize_t count = texts.size();
  const Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose);
  return write_attribute(object, name, type.get(), type.get(), space.get(), padded.data());
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
