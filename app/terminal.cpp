#include "app/terminal.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <string_view>

#include "framework/graph/text_table.hpp"

namespace tactor {

std::size_t terminal_columns() {
  std::size_t columns = usual_columns;
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) {
    columns = size.ws_col;
  } else if (const char* text = std::getenv("COLUMNS")) {
    const std::string_view digits(text);
    std::size_t said = 0;
    const auto parsed = std::from_chars(digits.data(), digits.data() + digits.size(), said);
    if (parsed.ec == std::errc{} && parsed.ptr == digits.data() + digits.size()) columns = said;
  }
  constexpr std::size_t narrowest = 40;
  return std::max(columns, narrowest);
}

}  // namespace tactor
