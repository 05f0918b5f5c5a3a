#include "framework/graph/text_table.hpp"

#include <algorithm>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

constexpr std::size_t gap = 2;            // between columns
constexpr std::size_t longest_word = 26;  // that is never broken

/// The bytes of the first `columns` characters.
std::size_t bytes_of(std::string_view text, std::size_t columns) {
  std::size_t bytes = 0;
  while (bytes < text.size() && columns > 0) {
    ++bytes;
    while (bytes < text.size() && (static_cast<unsigned char>(text[bytes]) & 0xc0U) == 0x80U) ++bytes;
    --columns;
  }
  return bytes;
}

/// The lines of a cell that is `width` wide: broken at spaces, and inside of a word that is wider alone.
std::vector<std::string> lines_of(std::string_view text, std::size_t width) {
  std::vector<std::string> lines;
  while (display_width(text) > width) {
    const std::size_t full = bytes_of(text, width);
    std::size_t end = text.rfind(' ', full);
    const bool at_space = end != std::string_view::npos && end > 0;
    if (!at_space) end = full;
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(at_space ? end + 1 : end);
  }
  if (!text.empty() || lines.empty()) lines.emplace_back(text);
  return lines;
}

/// The widest word of a text.
std::size_t word_width(std::string_view text) {
  std::size_t widest = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    widest = std::max(widest, display_width(text.substr(0, end)));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return widest;
}

std::string padded(const std::string& text, std::size_t width, TextTable::Align align) {
  const std::size_t used = display_width(text);
  const std::string space(width - std::min(width, used), ' ');
  return align == TextTable::Align::right ? space + text : text + space;
}

}  // namespace

std::size_t display_width(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80U; }));
}

TextTable::TextTable(std::vector<Column> columns) : columns_(std::move(columns)) {
  TACTOR_DEMAND(!columns_.empty());
  has_heads_ = std::any_of(columns_.begin(), columns_.end(), [](const Column& c) { return !c.head.empty(); });
}

void TextTable::add(std::vector<std::string> cells) {
  TACTOR_DEMAND(cells.size() <= columns_.size());
  cells.resize(columns_.size());
  rows_.push_back(std::move(cells));
}

std::vector<TextTable::Block> TextTable::blocks(std::size_t room) const {
  std::vector<std::size_t> natural, least;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    std::size_t width = display_width(columns_[c].head);
    std::size_t word = word_width(columns_[c].head);
    for (const auto& row : rows_) {
      width = std::max(width, display_width(row[c]));
      word = std::max(word, word_width(row[c]));
    }
    natural.push_back(width);
    least.push_back(columns_[c].align == Align::left ? std::min(word, longest_word) : width);
  }
  std::vector<Block> found;
  std::size_t used = 0;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (found.empty() || used + gap + least[c] > room) {
      found.push_back({{0}, {}});
      used = least[0];
      if (c == 0) continue;
    }
    found.back().columns.push_back(c);
    used += gap + least[c];
  }
  for (Block& block : found) {
    std::size_t total = gap * (block.columns.size() - 1);
    for (const std::size_t c : block.columns) total += natural[c], block.widths.push_back(natural[c]);
    // The widest text gives way first.
    for (; total > room; --total) {
      std::size_t widest = block.columns.size();
      for (std::size_t i = 0; i < block.columns.size(); ++i) {
        const bool gives = block.widths[i] > least[block.columns[i]];
        if (gives && (widest == block.columns.size() || block.widths[i] > block.widths[widest])) widest = i;
      }
      if (widest == block.columns.size()) break;
      --block.widths[widest];
    }
  }
  return found;
}

std::string TextTable::text(std::size_t columns, std::size_t indent) const {
  std::string out;
  for (const Block& block : blocks(columns - std::min(columns, indent))) {
    if (!out.empty()) out += "\n";
    const auto add_row = [&](const auto& cell_of) {
      std::vector<std::vector<std::string>> cells;
      std::size_t height = 0;
      for (std::size_t i = 0; i < block.columns.size(); ++i) {
        cells.push_back(lines_of(cell_of(block.columns[i]), block.widths[i]));
        height = std::max(height, cells.back().size());
      }
      for (std::size_t line = 0; line < height; ++line) {
        std::string text(indent, ' ');
        for (std::size_t i = 0; i < cells.size(); ++i) {
          if (i > 0) text += std::string(gap, ' ');
          const std::string& cell = line < cells[i].size() ? cells[i][line] : std::string();
          text += padded(cell, block.widths[i], columns_[block.columns[i]].align);
        }
        text.erase(text.find_last_not_of(' ') + 1);
        out += text + "\n";
      }
    };
    if (has_heads_) add_row([&](std::size_t c) -> const std::string& { return columns_[c].head; });
    for (const auto& row : rows_) add_row([&](std::size_t c) -> const std::string& { return row[c]; });
  }
  return out;
}

std::string wrapped(std::string_view text, std::size_t columns) {
  std::string out;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    const bool broken_by_text = end < text.size();
    text.remove_prefix(broken_by_text ? end + 1 : end);
    const std::size_t begin = std::min(line.find_first_not_of(' '), line.size());
    const std::string further(begin + 2, ' ');
    std::string before;
    while (display_width(line) + before.size() > columns) {
      const std::size_t full = bytes_of(line, columns - std::min(columns, before.size()));
      const std::size_t first = before.empty() ? begin : 0;
      std::size_t space = line.rfind(' ', full);
      // A word that is wider alone goes over the edge.
      if (space == std::string_view::npos || space <= first) space = line.find(' ', first + 1);
      if (space == std::string_view::npos) break;
      out += before + std::string(line.substr(0, line.find_last_not_of(' ', space) + 1)) + "\n";
      line.remove_prefix(std::min(line.find_first_not_of(' ', space), line.size()));
      before = further;
    }
    out += before + std::string(line);
    if (broken_by_text) out += '\n';
  }
  return out;
}

}  // namespace tactor
