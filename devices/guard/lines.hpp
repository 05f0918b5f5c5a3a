// The lines that a guard can open.
#pragma once

#include <memory>
#include <string>

#include "devices/hardware/link.hpp"

namespace tactor {

/// The link of the kind `line` that an engine described by `bytes` (see HardwareParts::guardable). Throws RunError for
/// a kind that this build does not have, and for bytes that hold no such link.
std::unique_ptr<Link> make_link(const std::string& line, const std::string& bytes);

}  // namespace tactor
