// Small operations on text.
#pragma once

#include <string_view>

namespace tactor {

/// The text without spaces and line breaks around it; a view of the same characters.
inline std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blank = " \t\n\r";
  const std::size_t first = text.find_first_not_of(blank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blank) - first + 1);
}

}  // namespace tactor
