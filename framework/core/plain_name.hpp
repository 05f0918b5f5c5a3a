// Texts as parts of file names.
#pragma once

#include <string>

namespace tactor {

/// The text with `_` for each byte that is no letter, digit, `-` or `.` of ASCII.
inline std::string plain_name(std::string text) {
  for (char& c : text) {
    const bool plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '.';
    if (!plain) c = '_';
  }
  return text;
}

}  // namespace tactor
