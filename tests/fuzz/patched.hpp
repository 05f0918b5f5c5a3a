// Bytes for a loader that refuses what is not nearly right: a good entry with some of its bytes replaced.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

namespace tactor::fuzz {

/// Where the first byte of the input is odd, the rest of it as it is. Else `good` with patches of nine bytes each: four
/// say where, one whether four or eight are replaced, or all after that place cut off, and four by what.
inline std::string patched(const std::string& good, const std::uint8_t* data, std::size_t size) {
  if (size == 0) return good;
  const std::uint8_t* const end = data + size;
  if ((*data++ & 1) != 0) return {reinterpret_cast<const char*>(data), static_cast<std::size_t>(end - data)};
  std::string bytes = good;
  for (; end - data >= 9 && bytes.size() >= 8; data += 9) {
    std::uint32_t place = 0, value = 0;
    std::memcpy(&place, data, 4);
    std::memcpy(&value, data + 5, 4);
    const std::size_t at = place % (bytes.size() - 7);
    std::memcpy(bytes.data() + at, &value, 4);
    if (data[4] % 3 == 1) std::memset(bytes.data() + at + 4, (value & 0x80000000U) != 0 ? 0xff : 0, 4);
    if (data[4] % 3 == 2) bytes.resize(at);
  }
  return bytes;
}

}  // namespace tactor::fuzz
