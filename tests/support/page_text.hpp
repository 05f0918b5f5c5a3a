// Looks for texts in pages.
#pragma once

#include <boost/test/unit_test.hpp>
#include <string>

namespace tactor::test {

/// The text of a page, without its elements.
inline std::string text_of(const std::string& html) {
  std::string out;
  bool inside = false;
  for (const char c : html) {
    if (c == '<') inside = true;
    if (!inside) out += c;
    if (c == '>') inside = false;
  }
  return out;
}

inline void says(const std::string& text, const std::string& part) {
  BOOST_TEST(text.find(part) != std::string::npos, part << " in " << text);
}

inline void says_not(const std::string& text, const std::string& part) {
  BOOST_TEST(text.find(part) == std::string::npos, part << " in " << text);
}

}  // namespace tactor::test
