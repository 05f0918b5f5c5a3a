// When, where, by which program and from which files a result was made: what summary.json, recordings, reports and
// tables carry.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "app/run/ran_on.hpp"
#include "framework/graph/plan.hpp"

namespace tactor {

/// A file that took part, by its bytes then.
struct HashedFile {
  std::string of;              ///< `graph`, `scene.tool`, `device.profile`; empty: a library, or a file of a study
  std::filesystem::path file;  ///< absolute
  std::string sha256;          ///< 64 hexadecimal digits; `missing` where it could not be read
};

/// A file that a plan is made from, and what names it.
struct InputOfPlan {
  std::string of;
  std::filesystem::path file;
};

/// All files that the results of a plan depend on: those of the graph, meshes, traces of costs, classes in Python, and
/// the files of parameters (profiles, models, firmware, recordings) with what these include. Throws InputError where
/// one that includes others cannot be read.
std::vector<InputOfPlan> input_files(const Plan& plan);

/// `of` of the recording that judged a run instead of a reference run.
inline constexpr std::string_view reference_option = "--reference";

/// One a run or a study.
struct Provenance {
  std::string date;  ///< when it began, UTC: `2026-11-26T11:45:57Z`
  RanOn host;
  std::string version;  ///< of Tactor
  std::string commit;   ///< as BuildLibrary has it, with the three that follow
  bool dirty = false;
  std::string compiler;
  std::string flags;
  std::vector<HashedFile> files;      ///< inputs
  std::vector<HashedFile> libraries;  ///< the program and the shared libraries, ours and those of others

  [[nodiscard]] bool empty() const { return date.empty(); }
};

/// The provenance of a run that begins now. Call it when the nodes are made, so that their libraries are loaded. Throws
/// like input_files.
Provenance provenance_of(const Plan& plan, const std::filesystem::path& cache_folder);

/// The program and all shared libraries that this process has loaded, without symbolic links.
std::set<std::filesystem::path> loaded_code();

/// That of what is made from these files by these programs and libraries.
Provenance provenance_of(const std::vector<InputOfPlan>& files, const std::set<std::filesystem::path>& code,
                         const std::filesystem::path& cache_folder);

nlohmann::ordered_json to_json(const Provenance& provenance);

/// The same in one line, for files that hold it as a text; empty for an empty one.
std::string provenance_text(const Provenance& provenance);

/// The reverse of to_json. Throws InputError, beginning with `where`, where something is missing or of another kind.
Provenance provenance_from_json(const nlohmann::ordered_json& json, const std::string& where);

}  // namespace tactor
