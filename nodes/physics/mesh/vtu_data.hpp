// The data arrays of VTK's XML files: what bytes an array has, however it is coded.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/read_budget.hpp"

namespace tactor {

/// How the arrays of a file are coded.
struct VtuCoding {
  ReadBudget& budget;        ///< of the file; several arrays may refer to the same data
  std::string file;          ///< for messages
  bool wide_header = false;  ///< sizes are UInt64 and not UInt32
  bool compressed = false;   ///< by zlib, in blocks
  bool little_endian = true;
  bool appended_as_text = false;  ///< the appended data is base64 and not raw
  std::string_view appended{};    ///< what follows `_`
};

/// An array as the file describes it.
struct VtuArray {
  std::string_view name, type, format, text;  ///< `text`: what stands between its tags
  std::uint64_t offset = 0;                   ///< into the appended data
  std::size_t line = 0;                       ///< of the text
};

/// The numbers of an array, each as double or as whole number. Throws InputError with the file and the name of the
/// array where it is not coded as it says, has another type, a number is none, or the budget does not hold it.
std::vector<double> real_values(const VtuCoding& coding, const VtuArray& array);
std::vector<std::int64_t> whole_values(const VtuCoding& coding, const VtuArray& array);

}  // namespace tactor
