// How much the test program has allocated, to show that a step allocates nothing.
#pragma once

#include <cstdint>

namespace tactor::test {

/// Calls of operator new since the program began, by any thread.
std::uint64_t allocations();

}  // namespace tactor::test
