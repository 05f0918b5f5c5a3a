#include "framework/core/shell_word.hpp"

#include <algorithm>

#include "framework/core/check.hpp"
#include "framework/core/control_characters.hpp"

namespace tactor {

void refuse_control_characters(const std::string& text, const std::string& what) {
  if (!has_control_characters(text)) return;
  throw InputError(what + ": expected a text without control characters, which scripts cannot hold, found \"" +
                   with_visible_controls(text) + "\"; choose another");
}

namespace {

std::string in_quotes(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

bool is_letter_or_digit(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

}  // namespace

std::string shell_word(const std::string& text, const std::string& what) {
  refuse_control_characters(text, what);
  return in_quotes(text);
}

std::string as_typed(const std::string& text) {
  const auto is_plain = [](char c) {
    return is_letter_or_digit(c) || std::string_view("./-+,:@%").find(c) != std::string_view::npos;
  };
  return !text.empty() && std::all_of(text.begin(), text.end(), is_plain) ? text
                                                                          : in_quotes(with_visible_controls(text));
}

bool is_variable_name(std::string_view text) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  return !text.empty() && !is_digit(text.front()) && std::all_of(text.begin(), text.end(), is_letter_or_digit);
}

}  // namespace tactor
