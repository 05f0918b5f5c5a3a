// Characters that no name needs and that scripts, terminals and tables obey: line breaks, escapes, tabs.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace tactor {

inline bool is_control_character(char c) {
  return static_cast<unsigned char>(c) < ' ' || c == '\x7f';
}

inline bool has_control_characters(std::string_view text) {
  return std::any_of(text.begin(), text.end(), is_control_character);
}

/// The text with `\x0a` in place of a line break, and so on.
inline std::string with_visible_controls(std::string_view text) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string out;
  for (const char c : text) {
    if (!is_control_character(c)) {
      out += c;
      continue;
    }
    const auto code = static_cast<unsigned char>(c);
    out += {'\\', 'x', digits[code / 16U], digits[code % 16U]};
  }
  return out;
}

}  // namespace tactor
