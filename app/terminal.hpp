// The terminal that the command writes to.
#pragma once

#include <cstddef>

namespace tactor {

/// How many columns standard output has: those of its terminal; else what COLUMNS says; else 80. At least 40.
std::size_t terminal_columns();

}  // namespace tactor
