// Messages as numpy has them: structured dtypes of the C structs' own layout, and values to and from Python objects.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/message.hpp"

namespace tactor::python {

/// The fields that stand before those of the value in an array of messages, as in recordings: int64, int64, uint64.
inline constexpr const char* stamp_fields[]{"valid_ns", "produced_ns", "sequence"};

/// One message, which owns its SharedArrays: what a Python object was made into, to be sent.
class OwnedValue {
 public:
  explicit OwnedValue(const MessageType& type) : type_(&type), bytes_(type.size) {}
  OwnedValue(const OwnedValue&) = delete;
  OwnedValue& operator=(const OwnedValue&) = delete;
  OwnedValue(OwnedValue&& other) noexcept : type_(other.type_), bytes_(std::move(other.bytes_)) {
    other.bytes_.clear();
  }
  OwnedValue& operator=(OwnedValue&&) = delete;
  ~OwnedValue() {
    if (!bytes_.empty()) release(*type_, bytes_.data());
  }
  [[nodiscard]] const MessageType& type() const { return *type_; }
  [[nodiscard]] const std::byte* data() const { return bytes_.data(); }
  [[nodiscard]] std::byte* data() { return bytes_.data(); }

 private:
  const MessageType* type_;
  std::vector<std::byte> bytes_;
};

/// Turns messages of one type into numpy arrays, and Python objects into messages.
///
/// A value's dtype has the offsets of the struct, so that values are copied whole: records are nested dtypes, an
/// enumeration is its integer, a time is an int64 in ns, a vector is a subarray. A SharedArray is an object: an array
/// of its elements with memory of its own. Units and frames are in the type's description (see to_json).
///
/// Every call needs the interpreter's lock.
class MessageArrays {
 public:
  /// `type` outlives the object.
  explicit MessageArrays(const MessageType& type);

  [[nodiscard]] const MessageType& type() const { return *type_; }
  /// Of one value.
  [[nodiscard]] const pybind11::dtype& value_dtype() const { return value_; }
  /// Of one message: `stamp_fields`, then those of the value. The bytes are those of Stamped<T>.
  [[nodiscard]] const pybind11::dtype& message_dtype() const { return message_; }
  /// Bytes of a message, and where its value begins.
  [[nodiscard]] std::size_t message_size() const { return message_size_; }
  [[nodiscard]] std::size_t value_offset() const { return value_offset_; }

  /// A copy of one value, as an array of no dimensions; `[()]` makes it a numpy.void of the same memory.
  [[nodiscard]] pybind11::array copy(const std::byte* value) const;
  /// The value itself, read-only and without a copy, as an array of no dimensions; for as long as `owner` keeps the
  /// value. Of a type with SharedArrays a copy.
  [[nodiscard]] pybind11::array view(const std::byte* value, const pybind11::object& owner) const;
  /// An array of messages out of their bytes, one behind the other as in `message_dtype`, whose memory it takes over;
  /// without a copy, except of SharedArrays. The messages' copies of those are released.
  [[nodiscard]] pybind11::array take(std::vector<std::byte>&& messages) const;

  /// The message that `object` stands for: a numpy.void or an array of one structured element, or a mapping, with all
  /// fields of the type by name (and perhaps the stamps, which are left out). Numbers must fit the field, vectors must
  /// have its shape, an enumeration is an integer or a name, and no count or index may lead a reader out of an array.
  /// Throws InputError, which begins with `where` and the field's path, with what was expected and what was found.
  [[nodiscard]] OwnedValue value_of(const pybind11::object& object, const std::string& where) const;

 private:
  void copy_to(const std::byte* value, std::byte* element) const;

  const MessageType* type_;
  pybind11::dtype value_, message_;
  std::size_t value_offset_, message_size_;
  bool copied_whole_ = false;               // any bytes are a value: no SharedArrays, no enumerations
  std::vector<const Field*> array_fields_;  // of each entry of MessageType::arrays
};

/// Where the value begins in a message, and the bytes of one, as Stamped<T> has them.
std::size_t value_offset(const MessageType& type);
std::size_t message_size(const MessageType& type);
/// The field of each entry of MessageType::arrays; they live as long as the type.
std::vector<const Field*> array_fields(const MessageType& type);

/// The dtype of one element of a field, without its shape.
pybind11::dtype element_dtype(const Field& field);

}  // namespace tactor::python
