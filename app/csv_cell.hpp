// Cells of a table of comma-separated values.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

namespace tactor {

/// In quotes where a reader would take it for more than one cell.
inline std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

/// With all its digits; empty where it is not finite.
inline std::string csv_cell(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : std::string();
}

}  // namespace tactor
