// The columns that a message type has in a CSV file.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "framework/core/message.hpp"

namespace tactor {

/// A column: one number of a message, or one number of each element of a SharedArray.
struct CsvValue {
  std::string heading;           ///< `contact[3].distance [m]`
  const Field* field = nullptr;  ///< whose number it is
  std::size_t offset = 0;        ///< bytes from the message, or from the element
  bool in_array = false;         ///< of each element of the array at `array_offset`
  std::size_t array_offset = 0;  ///< bytes from the message to the SharedArray
  std::size_t array_stride = 0;  ///< bytes from element to element
};

/// A message may describe millions of numbers, and each column has a heading.
inline constexpr std::size_t most_csv_columns = 65'536;

/// In the order of the description. `type` must outlive them. Throws InputError if there are more columns than that.
std::vector<CsvValue> csv_values(const MessageType& type);

}  // namespace tactor
