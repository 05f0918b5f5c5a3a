// Tables and prose that fit the width of a terminal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tactor {

/// Columns of a terminal that texts fit where nobody says otherwise.
inline constexpr std::size_t usual_columns = 80;

/// Rows under heads, in columns as wide as their cells. What is too wide for the terminal is folded: texts are broken
/// at spaces inside of their cells, and columns of numbers that find no room stand in a second block under the first,
/// with the first column repeated.
class TextTable {
 public:
  enum class Align : std::uint8_t { left, right };
  struct Column {
    std::string head;
    Align align = Align::left;
  };
  explicit TextTable(std::vector<Column> columns);
  /// One cell a column; a column without a cell is empty.
  void add(std::vector<std::string> cells);
  /// The lines, each behind `indent` spaces and at most `columns` wide, but for a number that is wider alone.
  [[nodiscard]] std::string text(std::size_t columns, std::size_t indent = 2) const;

 private:
  struct Block {
    std::vector<std::size_t> columns;  // the first is that of the table
    std::vector<std::size_t> widths;
  };
  [[nodiscard]] std::vector<Block> blocks(std::size_t room) const;

  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
  bool has_heads_ = false;
};

/// Breaks every line of `text` that is wider than `columns` at spaces; what is broken off stands two columns further in
/// than the line began. A word that is wider alone stays whole.
std::string wrapped(std::string_view text, std::size_t columns);

/// How many columns a text of UTF-8 takes on a terminal, every character one.
std::size_t display_width(std::string_view text);

}  // namespace tactor
