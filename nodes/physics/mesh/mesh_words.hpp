// The words of a mesh file that is text, with the line each stands on.
#pragma once

#include <charconv>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "framework/core/check.hpp"
#include "framework/core/read_budget.hpp"
#include "nodes/physics/mesh/polygon_soup.hpp"

namespace tactor {

/// A word of a file as it may stand in a message: short and printable.
std::string shown_word(std::string_view word);

/// Goes through a text word by word. `#` begins a comment that ends with the line.
class MeshWords {
 public:
  /// `file` and `first_line` name the place in messages; `format` is what the file ought to be, `an ASCII OFF file`.
  /// Each word is a step of `budget`, which outlives this.
  MeshWords(ReadBudget& budget, std::string file, std::string format, std::string_view text, std::size_t first_line = 1)
      : budget_(&budget), file_(std::move(file)), format_(std::move(format)), text_(text), line_(first_line) {}

  /// The next word, on this line or a later one, or an empty one at the end of the text.
  std::string_view next();
  /// The next word of the line that the last one stood on, or an empty one at its end. A backslash continues a line.
  std::string_view next_in_line();
  /// Leaves the rest of the line out.
  void skip_line();

  /// The number that a word stands for. Throws InputError if it is not a number.
  template <class T>
  T number(std::string_view word, const char* expected) const {
    std::string_view digits = word;
    if (digits.size() > 1 && digits[0] == '+' && digits[1] != '-') digits.remove_prefix(1);
    T value{};
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (digits.empty() || error != std::errc() || end != digits.data() + digits.size()) fail(expected, word);
    return value;
  }
  /// The number that the next word is.
  template <class T>
  T number(const char* expected) {
    return number<T>(next(), expected);
  }
  /// The point that the next three words are. Throws InputError where it is not usable.
  Vec3 point();
  /// The same of three words of this line.
  Vec3 point_in_line();

  /// Charges bytes for what stands here to the budget.
  void take(std::uint64_t bytes) const {
    if (!budget_->holds(bytes)) throw InputError(place() + ": " + budget_->refusal());
  }

  /// `FILE:LINE: expected ..., found ...` and the remedy.
  [[noreturn]] void fail(const std::string& expected, std::string_view found) const;

 private:
  Vec3 checked(const Vec3& point) const;
  [[nodiscard]] std::string place() const { return file_ + ":" + std::to_string(line_); }

  ReadBudget* budget_;
  std::string file_, format_;
  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_;
};

}  // namespace tactor
