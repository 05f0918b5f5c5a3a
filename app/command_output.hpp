// Runs another command and reads what it prints.
#pragma once

#include <string>
#include <vector>

namespace tactor {

/// What a command printed. Throws RunError where it cannot be started, or ends with another code than 0: with what it
/// wrote to standard error.
std::string output_of(const std::vector<std::string>& words);

}  // namespace tactor
