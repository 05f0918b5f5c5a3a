// Stamped messages and the description of a message type that recorders and error texts read.
#pragma once

#include <cstddef>
#include <cstdint>
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

/// How a column of a message is stored.
enum class FieldKind : std::uint8_t { f64, i64, i32 };

/// One column of a message: `count` values of one kind at a byte offset.
struct Field {
  std::string_view name;
  std::string_view unit;  ///< "1" for plain numbers
  FieldKind kind;
  std::size_t offset;
  std::size_t count;
};

/// The description of a message type: what a recording writes and a replay reads back.
struct MessageType {
  std::string_view name;   ///< as graphs and error texts name it
  std::string_view frame;  ///< the frame its vectors are expressed in, or empty
  std::size_t size;        ///< bytes
  std::size_t alignment;   ///< bytes
  std::vector<Field> fields;
};

/// The description of T; every message type specialises it beside its struct.
template <class T>
const MessageType& message_type();

/// True for what may travel on an edge.
template <class T>
concept Message = std::is_trivially_copyable_v<T> && std::is_default_constructible_v<T>;

}  // namespace tactor
