// Values as bytes and back, field by field, so that doubles keep every bit.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/core/time.hpp"

namespace tactor {

/// A structure is written and read by one function, found beside it, that lists its fields:
///
///     void fields(auto& bytes, SameAs<Point> auto& p) { bytes(p.x, p.y); }
template <class T, class U>
concept SameAs = std::same_as<std::remove_const_t<T>, U>;

/// Numbers and enumerations are copied as they lie in memory: writer and reader are the same program.
template <class T>
concept Flat = (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) || std::is_enum_v<T>;

void fields(auto& bytes, SameAs<Duration> auto& d) {
  bytes(d.ns);
}

/// Appends values.
class ByteWriter {
 public:
  template <class... Values>
  void operator()(const Values&... values) {
    (put(values), ...);
  }
  std::string take() { return std::move(bytes_); }

 private:
  template <Flat T>
  void put(const T& value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void put(bool value) { bytes_ += value ? '\1' : '\0'; }
  void put(const std::string& text) {
    put(text.size());
    bytes_ += text;
  }
  void put(const std::filesystem::path& path) { put(path.string()); }
  template <class T>
  void put(const std::vector<T>& values) {
    put(values.size());
    if constexpr (Flat<T>) {
      bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    } else {
      for (const T& value : values) put(value);
    }
  }
  template <class T, std::size_t n>
  void put(const std::array<T, n>& values) {
    for (const T& value : values) put(value);
  }
  template <class K, class V, class C>
  void put(const std::map<K, V, C>& values) {
    put(values.size());
    for (const auto& [key, value] : values) (*this)(key, value);
  }
  template <class T>
  void put(const std::set<T>& values) {
    put(values.size());
    for (const T& value : values) put(value);
  }
  template <class T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  template <class A, class B>
  void put(const std::pair<A, B>& pair) {
    (*this)(pair.first, pair.second);
  }
  template <class... Kinds>
  void put(const std::variant<Kinds...>& value) {
    put(value.index());
    std::visit([this](const auto& one) { put(one); }, value);
  }
  template <class T>
  void put(const T& structure) {
    fields(*this, structure);
  }

  std::string bytes_;
};

/// Takes values out in the order in which they were written. Throws RunError where the bytes do not hold them.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}
  template <class... Values>
  void operator()(Values&... values) {
    (get(values), ...);
  }

 private:
  template <Flat T>
  void get(T& value) {
    std::memcpy(&value, next(sizeof value).data(), sizeof value);
  }
  /// A byte that is neither 0 nor 1 is no bool.
  void get(bool& value) {
    const char byte = next(1).front();
    if (byte != 0 && byte != 1) fail();
    value = byte != 0;
  }
  void get(std::string& text) { text = next(count(1)); }
  void get(std::filesystem::path& path) {
    std::string text;
    get(text);
    path = std::move(text);
  }
  template <class T>
  void get(std::vector<T>& values) {
    if constexpr (Flat<T>) {
      values.resize(count(sizeof(T)));
      const std::string_view from = next(values.size() * sizeof(T));
      if (!from.empty()) std::memcpy(values.data(), from.data(), from.size());
    } else {
      values.clear();
      // One by one: bytes that are not there must not cost what their values would.
      for (std::size_t left = count(1); left > 0; --left) get(values.emplace_back());
    }
  }
  template <class T, std::size_t n>
  void get(std::array<T, n>& values) {
    for (T& value : values) get(value);
  }
  template <class K, class V, class C>
  void get(std::map<K, V, C>& values) {
    for (std::size_t left = count(1); left > 0; --left) {
      K key{};
      get(key);
      get(values[key]);
    }
  }
  template <class T>
  void get(std::set<T>& values) {
    for (std::size_t left = count(1); left > 0; --left) {
      T value{};
      get(value);
      values.insert(std::move(value));
    }
  }
  template <class T>
  void get(std::optional<T>& value) {
    bool there = false;
    get(there);
    value.reset();
    if (there) get(value.emplace());
  }
  template <class A, class B>
  void get(std::pair<A, B>& pair) {
    (*this)(pair.first, pair.second);
  }
  template <class... Kinds>
  void get(std::variant<Kinds...>& value) {
    std::size_t index = 0;
    get(index);
    std::size_t kind = 0;
    const bool known = ((kind++ == index && (get(value.template emplace<Kinds>()), true)) || ...);
    if (!known) fail();
  }
  template <class T>
  void get(T& structure) {
    fields(*this, structure);
  }

  /// A count of things of at least `each` bytes.
  std::size_t count(std::size_t each) {
    std::size_t found = 0;
    get(found);
    if (found > bytes_.size() / each) fail();
    return found;
  }
  std::string_view next(std::size_t size) {
    if (size > bytes_.size()) fail();
    const std::string_view part = bytes_.substr(0, size);
    bytes_.remove_prefix(size);
    return part;
  }
  [[noreturn]] static void fail() { throw RunError("a message between processes is damaged"); }

  std::string_view bytes_;
};

template <class T>
std::string to_bytes(const T& value) {
  ByteWriter bytes;
  bytes(value);
  return bytes.take();
}

template <class T>
T from_bytes(std::string_view bytes) {
  T value{};
  ByteReader reader(bytes);
  reader(value);
  return value;
}

}  // namespace tactor
