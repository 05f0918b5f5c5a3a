// The reference runs that judge others: from the cache, or made and put there.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "framework/engine/reference.hpp"
#include "framework/graph/plan.hpp"

namespace tactor {

/// What looks for a reference run gets from its surroundings.
struct ReferenceOptions {
  std::filesystem::path cache_folder;
  std::function<bool(double share)> go_on;              ///< as in run_reference
  std::function<void(const std::string& note)> note{};  ///< told why what the cache held was not used
};

/// The reference run of a plan whose nodes need not be followed, from the cache, or made and put there; empty where no
/// sink asks for one. Trouble with keeping it is noted. `cached`, where not null, becomes whether it came from the
/// cache.
Reference cached_reference(const Plan& plan, const ReferenceOptions& options, bool* cached = nullptr);

/// Makes the reference run of a plan and puts it into the cache, where that can be done beforehand. Returns true if a
/// run was made. `reference`: the plan that it is the reference run of, or null for `plan` itself.
bool prepare_reference(const Plan& plan, const Plan* reference, const ReferenceOptions& options);

/// What the cache calls the reference run of a plan; empty where it asks for none.
std::string reference_id(const Plan& plan);

/// The program, the extension of Python where that has loaded this, libtactor with the libraries beside it, and the
/// node libraries that this process has loaded, in order of their paths. Of the libraries beside libtactor all count:
/// which of them a run loads depends on what the caches hold. Only that with the commit (see build_info.hpp) is left
/// out.
std::vector<std::filesystem::path> code_files();

/// The hash of the bytes of each such file, by its name.
std::map<std::string, std::string> code_hashes(const std::set<std::filesystem::path>& files);

/// One hash of such files, and of the code of nodes in Python.
std::string program_hash(const std::set<std::filesystem::path>& files, const std::set<std::string>& codes);

}  // namespace tactor
