// Numbers as text.
#pragma once

#include <array>
#include <charconv>
#include <string>

namespace tactor {

/// The shortest text that reads back to the same number.
inline std::string shortest(double value) {
  std::array<char, 32> digits{};
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr};
}

}  // namespace tactor
