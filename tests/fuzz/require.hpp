// What a fuzz target expects of the parser it feeds.
#pragma once

#include <cstdio>
#include <cstdlib>

namespace tactor::fuzz {

/// Ends the program as a crash does where a property does not hold, so that libFuzzer keeps the input.
inline void require(bool holds, const char* property) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", property);
  std::abort();
}

}  // namespace tactor::fuzz
