// Stamped messages, and descriptions of message types as data, which recordings, exports and other programs read
// instead of a C++ struct.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "framework/core/time.hpp"

namespace tactor {

/// The stamps of a message.
struct Stamp {
  Time valid;                  ///< the time the value holds for
  Time produced;               ///< the time it became visible to its readers
  std::uint64_t sequence = 0;  ///< counts the messages of one output, from 0
};

/// A value with its stamps.
template <class T>
struct Stamped {
  Stamp stamp;
  T value;
};

/// What a field holds.
enum class FieldKind : std::uint8_t { i8, u8, i16, u16, i32, u32, i64, u64, f32, f64, record };

/// A value of an enumeration.
struct Enumerator {
  std::string name;
  std::int64_t value = 0;
  std::string doc;  ///< sentences; empty where the name says it
};

/// A field of a message type, or of a record in it.
struct Field {
  std::string name;
  std::string unit = "1";               ///< SI; "1" for plain numbers; "ns" for times
  std::string frame;                    ///< the frame its vectors are expressed in; empty: that of the message
  FieldKind kind = FieldKind::f64;      ///< of one element
  std::vector<std::size_t> shape;       ///< elements by dimension, row-major; empty: one element
  bool changes_size = false;            ///< a SharedArray of elements, each of `shape`
  std::vector<Enumerator> enumerators;  ///< of an enumeration: its values; `kind` is then an integer
  std::string record;                   ///< of kind `record`: the name of its type
  std::vector<Field> fields;            ///< of kind `record`: its fields
  std::size_t offset = 0;               ///< bytes from the beginning of the message or record; see `lay_out`
  std::string doc;                      ///< sentences: direction, sign, point of reference, order of the elements
};

/// A message type as data. In memory a message is the C struct of these fields in this order.
struct MessageType {
  std::string name;           ///< as graphs and error texts name it; a library's own: `library.Name`
  std::string frame;          ///< the frame its vectors are expressed in, or empty
  std::vector<Field> fields;  ///< at least one
  std::size_t size = 0;       ///< bytes
  std::size_t alignment = 1;  ///< bytes
  /// Hash over name, frame and fields, but no doc: two types with the same hash have the same bytes.
  std::uint64_t layout_hash = 0;
  std::vector<std::size_t> arrays;  ///< the offset of each SharedArray in a message
  std::string doc;                  ///< sentences: what it is, and what its stamp means
};

/// The number of elements of a field of fixed size, and of one element of an array.
std::size_t count_of(const Field& field);
/// Bytes in memory of one scalar of the kind; 0 for records.
std::size_t scalar_size(FieldKind kind);
/// Bytes in memory of one element, without `shape`.
std::size_t element_size(const Field& field);

/// Sets offsets, size, alignment, hash and arrays as a C++ compiler lays the struct out.
void lay_out(MessageType& type);

/// The description of T; every message type and every record specialises it by Describe. The meaning of its fields is
/// told there and nowhere else, so that the reference, the schema and Python's help show it.
template <class T>
const MessageType& message_type();

/// True if both describe the same messages, even if they come from two libraries or from a file.
inline bool same_type(const MessageType& a, const MessageType& b) {
  return &a == &b || (a.layout_hash == b.layout_hash && a.name == b.name);
}

/// A placeholder for the type of an output that is not known yet; no message has it.
const MessageType& any_message();

/// Lets `known_message_type` find the type, which must live as long as the process; the first of a name stays.
void make_known(const MessageType& type);
/// The message type of that name among those of the node types that were declared so far; null where there is none.
const MessageType* known_message_type(std::string_view name);

/// Keeps a description that was read from a file until the process ends; equal ones are kept once.
const MessageType& keep_message_type(MessageType type);

/// True for types that may travel on an edge: values of fixed size, and SharedArrays.
template <class T>
concept Message = std::is_default_constructible_v<T> && std::is_nothrow_copy_assignable_v<T>;

/// Counts the bytes at `value` as one more copy of the message: its SharedArrays live on.
void retain(const MessageType& type, const void* value) noexcept;
/// Ends such a copy, and leaves its SharedArrays empty.
void release(const MessageType& type, void* value) noexcept;

}  // namespace tactor
