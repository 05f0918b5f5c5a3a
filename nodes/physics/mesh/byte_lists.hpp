// Lists of numbers as bytes in the layout of this machine, for the cache.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

namespace tactor {

inline void put_number(std::string& out, std::uint64_t n) {
  out.append(reinterpret_cast<const char*>(&n), sizeof n);
}

/// Its length, then its values.
template <class Container>
void put_list(std::string& out, const Container& data) {
  static_assert(std::is_trivially_copyable_v<typename Container::value_type>);
  put_number(out, data.size());
  out.append(reinterpret_cast<const char*>(data.data()), data.size() * sizeof(data[0]));
}

/// Takes what was put; after there was less than that, `ok` is false.
struct ByteTaker {
  std::string_view rest;
  bool ok = true;

  void bytes(void* to, std::uint64_t size) {
    if (size > rest.size()) ok = false;
    if (!ok || size == 0) return;
    std::memcpy(to, rest.data(), size);
    rest.remove_prefix(size);
  }
  std::uint64_t number() {
    std::uint64_t n = 0;
    bytes(&n, sizeof n);
    return n;
  }
  template <class Container>
  void list(Container& data) {
    const std::uint64_t n = number();
    if (n > rest.size() / sizeof(data[0])) ok = false;
    if (!ok) return;
    data.resize(n);
    bytes(data.data(), n * sizeof(data[0]));
  }
};

}  // namespace tactor
