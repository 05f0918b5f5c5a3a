#include "app/run/references.hpp"

#include <link.h>
#include <sys/auxv.h>

#include <algorithm>
#include <optional>
#include <system_error>
#include <vector>

#include "app/run/build_info.hpp"
#include "framework/core/disk_cache.hpp"
#include "framework/engine/plan_nodes.hpp"
#include "framework/node/plugin.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// A reference run that is asked for, and what the cache has of it.
struct Wanted {
  Plan plan;
  ReferenceCache cache;
  std::string key;
  ReferenceCache::Found found;
};

/// Nothing where no sink asks for one.
std::optional<Wanted> look_up(const Plan& plan, const fs::path& cache_folder) {
  Plan reference_plan = make_reference_plan(plan);
  if (reference_plan.nodes.empty()) return std::nullopt;
  ReferenceCache cache(cache_folder);
  std::string key = reference_key(reference_plan, code_files());
  ReferenceCache::Found found = cache.load(key, reference_plan);
  return Wanted{std::move(reference_plan), std::move(cache), std::move(key), std::move(found)};
}

void tell(const ReferenceOptions& options, const std::string& note) {
  if (options.note && !note.empty()) options.note(note);
}

}  // namespace

std::vector<fs::path> code_files() {
  std::vector<fs::path> files = plugin_files();
  const auto add = [](dl_phdr_info* info, std::size_t, void* data) {
    // The program itself has no name there.
    const bool is_program = *info->dlpi_name == '\0';
    const fs::path file = is_program ? reinterpret_cast<const char*>(getauxval(AT_EXECFN)) : info->dlpi_name;
    const std::string name = file.filename().string();
    // SLEEF has the sines of all of them.
    if (is_program || name.find("tactor") != std::string::npos || name.starts_with("libsleef")) {
      std::error_code ignored;
      static_cast<std::vector<fs::path>*>(data)->push_back(fs::canonical(file, ignored));
    }
    return 0;
  };
  dl_iterate_phdr(add, &files);
  // It tells the commit and computes nothing: another commit alone changes no result.
  std::erase_if(files, [](const fs::path& file) { return file.filename() == build_library_file; });
  std::sort(files.begin(), files.end());
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

Reference cached_reference(const Plan& plan, const ReferenceOptions& options, bool* cached) {
  std::optional<Wanted> wanted = look_up(plan, options.cache_folder);
  if (!wanted) return {};
  std::optional<Reference>& reference = wanted->found.reference;
  tell(options, wanted->found.note);
  if (cached != nullptr) *cached = reference.has_value();
  if (!reference) {
    reference = run_reference(wanted->plan, nullptr, options.go_on);
    tell(options, wanted->cache.store(wanted->key, *reference));
  }
  return std::move(*reference);
}

bool prepare_reference(const Plan& plan, const Plan* reference, const ReferenceOptions& options) {
  // The cache is asked first, because the next question takes an engine with its meshes and trees.
  const std::optional<Wanted> wanted = look_up(reference != nullptr ? *reference : plan, options.cache_folder);
  if (!wanted || wanted->found.reference) return false;
  // Whether a node must be followed is known from its parameters alone, so nodes that never run can be asked.
  if (must_be_followed(PlanNodes(plan))) return false;
  tell(options, wanted->found.note);
  // Where it cannot be kept, the run that asks for it makes it again and says so.
  static_cast<void>(wanted->cache.store(wanted->key, run_reference(wanted->plan, nullptr, options.go_on)));
  return true;
}

std::string reference_id(const Plan& plan) {
  const Plan reference_plan = make_reference_plan(plan);
  return reference_plan.nodes.empty() ? "" : reference_key(reference_plan, {});
}

std::map<std::string, std::string> code_hashes(const std::set<fs::path>& files) {
  std::map<std::string, std::string> hashes;
  for (const fs::path& file : files) hashes[file.filename().string()] = file_key(file);
  return hashes;
}

std::string program_hash(const std::set<fs::path>& files, const std::set<std::string>& codes) {
  std::string text;
  for (const auto& [name, hash] : code_hashes(files)) text += name + " " + hash + "\n";
  for (const std::string& code : codes) text += code + "\n";
  return content_key({text});
}

}  // namespace tactor
