#include "nodes/source/csv_table.hpp"

#include <zlib.h>

#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/core/input_file.hpp"
#include "framework/core/read_budget.hpp"
#include "framework/core/text.hpp"

namespace tactor {

namespace {

struct CloseGzip {
  void operator()(gzFile file) const { gzclose(file); }
};
using GzipFile = std::unique_ptr<gzFile_s, CloseGzip>;

/// Hands out the lines of a file, which may be compressed, and holds no more than one of them.
class Lines {
 public:
  explicit Lines(const std::filesystem::path& path) : path_(path) {
    InputFile input = open_input(path);
    if (!input.file) throw InputError(path.string() + ": " + input.error);
    size_ = input.size;
    FileDescriptor opened = std::move(input.file);
    file_.reset(gzdopen(opened.number(), "rb"));
    if (!file_) throw InputError(path.string() + ": " + "cannot be read: there is no memory for it");
    static_cast<void>(opened.release());
  }

  /// Bytes of the file as it is on the disk.
  [[nodiscard]] std::uint64_t size() const { return size_; }

  /// The next line without its end; nothing after the last one. It holds until the next call.
  std::optional<std::string_view> next() {
    std::size_t looked = at_;
    while (true) {
      if (const std::size_t end = text_.find('\n', looked); end != std::string::npos) return take(end, end + 1);
      looked = text_.size() - at_;
      text_.erase(0, std::exchange(at_, 0));
      if (text_.size() > csv_limits::line_bytes) {
        throw InputError(path_.string() + ":" + std::to_string(number_ + 1) + ": expected a line of at most " +
                         std::to_string(csv_limits::line_bytes) + " bytes, found a longer one");
      }
      if (!read_more()) break;
    }
    if (text_.empty()) return std::nullopt;
    return take(text_.size(), text_.size());
  }

 private:
  std::string_view take(std::size_t end, std::size_t next) {
    const std::string_view line = std::string_view(text_).substr(at_, end - at_);
    at_ = next;
    ++number_;
    return line;
  }

  bool read_more() {
    const int got = gzread(file_.get(), block_.data(), block_.size());
    int error = Z_OK;
    const char* message = gzerror(file_.get(), &error);
    if (got < 0 || error != Z_OK) throw InputError(path_.string() + " is damaged: " + std::string(message));
    text_.append(block_.data(), static_cast<std::size_t>(got));
    return got > 0;
  }

  std::filesystem::path path_;
  std::uint64_t size_ = 0;
  GzipFile file_;
  std::array<char, 1 << 16> block_{};
  std::string text_;        // what was read and not handed out
  std::size_t at_ = 0;      // of the next line in it
  std::size_t number_ = 0;  // of the line handed out last
};

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
  // The first line holds the headings, and empty lines stand at the end alone.
  return path.string() + ":" + std::to_string(row + 2);
}

namespace {

/// Bytes that a row takes besides its numbers.
constexpr std::uint64_t row_bytes = 64;

CsvTable read_lines(const std::filesystem::path& path) {
  Lines lines(path);
  CsvTable table;
  table.path = path;
  ReadBudget budget(path.string(), lines.size());
  std::size_t line = 0, empty_line = 0;
  const auto refuse = [&](const std::string& why) {
    throw InputError(path.string() + ":" + std::to_string(line) + ": " + why);
  };
  while (const std::optional<std::string_view> row = lines.next()) {
    ++line;
    // A quarter of the text, because an honest file may pack a hundredfold, and the message that a row becomes.
    if (!budget.holds(row->size() / 4 + row_bytes)) refuse(budget.refusal());
    if (trimmed(*row).empty()) {
      empty_line = line;
      if (line == 1) refuse("an empty line is not allowed here");
      if (line > csv_limits::rows + 2) refuse("expected the end of the file, found too many empty lines");
      continue;
    }
    if (empty_line > 0) {
      line = empty_line;
      refuse("an empty line is not allowed here");
    }
    if (line == 1) {
      for_cells(*row, [&](std::string_view cell) {
        if (cell.empty()) refuse("a heading is empty; the first line names every column, for example t_s,x_mm");
        if (table.find(cell)) refuse("the heading '" + std::string(cell) + "' stands twice");
        if (table.columns.size() == csv_limits::columns) {
          refuse("expected at most " + std::to_string(csv_limits::columns) + " columns, found more");
        }
        table.columns.push_back(parse_heading(cell));
      });
      continue;
    }
    if (line > csv_limits::rows + 1 || table.values.size() + table.columns.size() > csv_limits::values) {
      refuse("expected at most " + std::to_string(csv_limits::rows) + " rows and " +
             std::to_string(csv_limits::values) + " numbers, found more; cut the file or leave out samples or columns");
    }
    if (!budget.holds(table.columns.size() * sizeof(double))) refuse(budget.refusal());
    std::size_t cells = 0;
    for_cells(*row, [&](std::string_view cell) {
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
  }
  if (table.rows() == 0) throw InputError(path.string() + " holds no rows; headings and at least one row are expected");
  return table;
}

}  // namespace

CsvTable read_csv(const std::filesystem::path& path) {
  return within_memory(path, [&] { return read_lines(path); });
}

}  // namespace tactor
