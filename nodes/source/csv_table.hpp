// Reads tables of numbers from comma-separated files, plain or compressed by gzip, whose header names units.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/units.hpp"

namespace tactor {

/// A column of a file: `x [mm]` and `x_mm` both have the name `x` and the unit mm.
struct CsvColumn {
  std::string heading;       ///< as the file has it
  std::string name;          ///< without the unit
  std::optional<Unit> unit;  ///< absent where the heading names none
};

/// The bounds of a table, so that a small compressed file cannot fill the memory.
namespace csv_limits {
inline constexpr std::size_t rows = 1'000'000;     ///< more than a quarter of an hour at 1 kHz
inline constexpr std::size_t values = 32'000'000;  ///< a quarter of a gigabyte, and several times that as messages
inline constexpr std::size_t columns = 1000;
inline constexpr std::size_t line_bytes = 1 << 20;
}  // namespace csv_limits

/// A table of numbers as they stand in the file, not converted.
struct CsvTable {
  std::filesystem::path path;
  std::vector<CsvColumn> columns;
  std::vector<double> values;  ///< row by row

  [[nodiscard]] std::size_t rows() const { return columns.empty() ? 0 : values.size() / columns.size(); }
  [[nodiscard]] double at(std::size_t row, std::size_t column) const { return values[row * columns.size() + column]; }
  /// The column whose heading or name is `text`; nothing where there is none.
  [[nodiscard]] std::optional<std::size_t> find(std::string_view text) const;
  /// `file:line` of a row, for error texts.
  [[nodiscard]] std::string place(std::size_t row) const;
};

/// Reads the file line by line, up to the bounds above: a line of headings, then numbers, with a decimal point in any
/// locale. Empty lines at the end are allowed. Throws InputError with file and line for everything else: an empty or
/// repeated heading, a row of another length, a cell that is no finite number, a broken compression, what is no file,
/// more than the bounds allow.
CsvTable read_csv(const std::filesystem::path& path);

}  // namespace tactor
