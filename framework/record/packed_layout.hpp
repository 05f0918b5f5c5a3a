// How the bytes of a message lie in a recording: its fields one after the other, without the padding of the struct.
#pragma once

#include <cstddef>
#include <cstring>
#include <string>
#include <vector>

#include "framework/core/message.hpp"
#include "framework/core/shared_array.hpp"

namespace tactor {

/// Copies messages, or elements of an array, between memory and their packed bytes. In place of a SharedArray the
/// packed bytes hold two u64: the number of its first element among all elements that the stream has at this field, and
/// how many they are.
class PackedLayout {
 public:
  explicit PackedLayout(const std::vector<Field>& fields);

  /// Packed bytes of a message.
  [[nodiscard]] std::size_t size() const { return size_; }
  /// The fields that change size, in the order in which the description names them.
  [[nodiscard]] const std::vector<const Field*>& arrays() const { return arrays_; }
  /// The path of each, such as `scan.points`.
  [[nodiscard]] const std::vector<std::string>& array_paths() const { return paths_; }

  /// Writes the packed bytes of `message` to `to`. `add(array, elements)` takes in a SharedArray and returns the number
  /// of its first element; `array` is an index into `arrays()`.
  template <class Add>
  void pack(const std::byte* message, std::byte* to, const Add& add) const {
    for (const Part& part : parts_) {
      if (part.size > 0) {
        std::memcpy(to, message + part.offset, part.size);
        to += part.size;
        continue;
      }
      const auto& elements = *reinterpret_cast<const SharedBytes*>(message + part.offset);
      const std::uint64_t range[2]{add(part.array, elements), elements.count()};
      std::memcpy(to, range, sizeof range);
      to += sizeof range;
    }
  }
  /// The same backwards. `get(array, first, count)` returns the elements as SharedBytes.
  template <class Get>
  void unpack(const std::byte* from, std::byte* message, const Get& get) const {
    for (const Part& part : parts_) {
      if (part.size > 0) {
        std::memcpy(message + part.offset, from, part.size);
        from += part.size;
        continue;
      }
      std::uint64_t range[2];
      std::memcpy(range, from, sizeof range);
      from += sizeof range;
      *reinterpret_cast<SharedBytes*>(message + part.offset) = get(part.array, range[0], range[1]);
    }
  }

 private:
  /// Bytes that lie together on both sides, or one SharedArray.
  struct Part {
    std::size_t offset = 0;  // in the message
    std::size_t size = 0;    // bytes; 0: a SharedArray
    std::size_t array = 0;
  };

  void add_fields(const std::vector<Field>& fields, std::size_t begin, const std::string& path);
  void add_bytes(std::size_t offset, std::size_t size);
  std::size_t array_index(const Field& field, const std::string& path);

  std::vector<Part> parts_;
  std::vector<const Field*> arrays_;
  std::vector<std::string> paths_;
  std::size_t size_ = 0;
};

/// A field that changes size, as a field that holds one of its elements; at offset 0.
Field element_of(const Field& field);

}  // namespace tactor
