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

/// A table of numbers as they stand in the file, not converted.
struct CsvTable {
  std::filesystem::path path;
  std::vector<CsvColumn> columns;
  std::vector<double> values;  ///< row by row
  std::vector<int> lines;      ///< of each row in the file

  [[nodiscard]] std::size_t rows() const { return lines.size(); }
  [[nodiscard]] double at(std::size_t row, std::size_t column) const { return values[row * columns.size() + column]; }
  /// The column whose heading or name is `text`; nothing where there is none.
  [[nodiscard]] std::optional<std::size_t> find(std::string_view text) const;
  /// `file:line` of a row, for error texts.
  [[nodiscard]] std::string place(std::size_t row) const;
};

/// Reads the file: a line of headings, then numbers, with a decimal point in any locale. Empty lines at the end are
/// allowed. Throws InputError with file and line for everything else: an empty or repeated heading, a row of another
/// length, a cell that is no finite number, a broken compression.
CsvTable read_csv(const std::filesystem::path& path);

}  // namespace tactor
