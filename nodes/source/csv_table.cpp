#include "nodes/source/csv_table.hpp"

#include <zlib.h>

#include <array>
#include <charconv>
#include <cmath>
#include <memory>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

struct CloseGzip {
  void operator()(gzFile file) const { gzclose(file); }
};
using GzipFile = std::unique_ptr<gzFile_s, CloseGzip>;

std::string read_whole(const std::filesystem::path& path) {
  // Reads files that are not compressed as they are.
  const GzipFile file(std::filesystem::is_regular_file(path) ? gzopen(path.c_str(), "rb") : nullptr);
  if (!file) throw InputError("cannot read " + path.string() + ": a file of comma-separated values is expected there");
  std::string text;
  std::array<char, 1 << 16> block{};
  int got = 0;
  while ((got = gzread(file.get(), block.data(), block.size())) > 0) {
    text.append(block.data(), static_cast<std::size_t>(got));
  }
  int error = Z_OK;
  const char* message = gzerror(file.get(), &error);
  if (got < 0 || error != Z_OK) throw InputError(path.string() + " is damaged: " + std::string(message));
  return text;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// Calls `take(cell)` for each cell of a line.
template <class Take>
void for_cells(std::string_view line, Take take) {
  while (true) {
    const std::size_t comma = line.find(',');
    take(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
  }
}

CsvColumn parse_heading(std::string_view heading) {
  CsvColumn column{std::string(heading), std::string(heading), std::nullopt};
  if (const std::size_t open = heading.find('['); open != std::string_view::npos && heading.back() == ']') {
    column.unit = parse_unit(heading.substr(open + 1, heading.size() - open - 2));
    if (column.unit) column.name = trimmed(heading.substr(0, open));
  } else if (const std::size_t bar = heading.rfind('_'); bar != std::string_view::npos && bar > 0) {
    column.unit = parse_unit(heading.substr(bar + 1));
    if (column.unit) column.name = heading.substr(0, bar);
  }
  return column;
}

}  // namespace

std::optional<std::size_t> CsvTable::find(std::string_view text) const {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].heading == text) return i;
  }
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].name == text) return i;
  }
  return std::nullopt;
}

std::string CsvTable::place(std::size_t row) const {
  return path.string() + ":" + std::to_string(lines[row]);
}

CsvTable read_csv(const std::filesystem::path& path) {
  const std::string text = read_whole(path);
  CsvTable table;
  table.path = path;
  std::string_view rest = text;
  int line = 0;
  const auto refuse = [&](const std::string& why) {
    throw InputError(path.string() + ":" + std::to_string(line) + ": " + why);
  };
  while (!rest.empty()) {
    ++line;
    const std::size_t end = rest.find('\n');
    const std::string_view row = rest.substr(0, end);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    if (trimmed(row).empty()) {
      if (!trimmed(rest.substr(0, rest.find('\n'))).empty() || line == 1) refuse("an empty line is not allowed here");
      continue;
    }
    if (line == 1) {
      for_cells(row, [&](std::string_view cell) {
        if (cell.empty()) refuse("a heading is empty; the first line names every column, for example t_s,x_mm");
        if (table.find(cell)) refuse("the heading '" + std::string(cell) + "' stands twice");
        table.columns.push_back(parse_heading(cell));
      });
      continue;
    }
    std::size_t cells = 0;
    for_cells(row, [&](std::string_view cell) {
      double value = 0;
      const auto result = std::from_chars(cell.data(), cell.data() + cell.size(), value);
      if (result.ec != std::errc{} || result.ptr != cell.data() + cell.size() || !std::isfinite(value)) {
        const std::string heading = cells < table.columns.size() ? table.columns[cells].heading : "beyond the last";
        refuse("a number is expected in column " + heading + ", found '" + std::string(cell) + "'");
      }
      table.values.push_back(value);
      ++cells;
    });
    if (cells != table.columns.size()) {
      refuse("expected " + std::to_string(table.columns.size()) + " cells as in the first line, found " +
             std::to_string(cells));
    }
    table.lines.push_back(line);
  }
  if (table.rows() == 0) throw InputError(path.string() + " holds no rows; headings and at least one row are expected");
  return table;
}

}  // namespace tactor
