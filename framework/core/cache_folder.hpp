// Where what was computed once is kept for later runs.
#pragma once

#include <filesystem>

namespace tactor {

/// TACTOR_CACHE, or XDG_CACHE_HOME/tactor, or ~/.cache/tactor.
std::filesystem::path default_cache_folder();

}  // namespace tactor
