// A table of texts and numbers that is written to HDF5 beside recordings.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tactor {

/// A column with what it says of itself: texts or numbers, one a row; the other is empty.
struct TableColumn {
  std::string name;
  std::vector<std::string> texts;
  std::vector<double> numbers;  ///< NaN where there is none
  std::vector<std::pair<std::string, std::string>> attributes{};
};

/// A table with what it says of itself. Every column has the same length.
struct TableFile {
  std::vector<std::pair<std::string, std::string>> attributes;
  std::vector<TableColumn> columns;
};

}  // namespace tactor
