// A run made again from its results, and compared with them.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "app/run/compare_results.hpp"
#include "app/run/provenance.hpp"

namespace tactor {

/// What the files that took part are now.
struct FilesNow {
  std::size_t same = 0;
  std::vector<std::string> others;  ///< a line for each that is not the same: `differs: duck.off (scene.tool)`
};

struct Verification {
  Provenance was, now;
  std::vector<std::string> notes;  ///< what else is not as it was, such as the definitions of metrics
  FilesNow files, libraries;
  ResultComparison results;
};

struct VerifyOptions {
  std::filesystem::path cache_folder;
  std::function<bool(double share, const char* what)> progress{};  ///< as in RunOptions
  std::function<bool()> stop_asked = [] { return false; };
  std::function<void(const std::string& note)> note{};  ///< as in RunOptions
};

/// Makes the run whose results are in `folder` again, from its graph.yaml, in a temporary folder, and compares.
/// `result` is that folder or its summary.json. Throws InputError, which says why, where it cannot be made again: it
/// was live, it was ended early, a program drove it, a file is missing, or its results do not tell their provenance.
/// RunError where the run fails now.
Verification verify_run(const std::filesystem::path& result, Registry& registry, const VerifyOptions& options);

/// What `tactor verify` prints.
std::string verification_text(const Verification& found);

}  // namespace tactor
