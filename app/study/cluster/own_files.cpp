#include "app/study/cluster/own_files.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <system_error>

#include "app/output.hpp"
#include "framework/core/input_file.hpp"
#include "framework/core/kept_folder.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// `use(folder)`, where there is such a folder. Tries once more where that fails: over a network, a file that another
/// node replaces may be gone for a moment.
template <class Use>
void with_own_folder(const fs::path& path, KeptFolder::Decides decides, const Use& use) {
  for (const bool is_last : {false, true}) {
    try {
      if (const auto kept = KeptFolder::find(path, decides)) use(*kept);
      return;
    } catch (const RunError& error) {
      if (!is_last) continue;
      throw InputError(fmt::format(
          "{}; nothing more is done, because the files of a study on a cluster decide what is run", error.what()));
    }
  }
}

}  // namespace

std::optional<std::string> own_bytes(const fs::path& file) {
  std::optional<std::string> bytes;
  with_own_folder(file.parent_path(), KeptFolder::Decides::nothing, [&](const KeptFolder& kept) {
    std::optional<FileDescriptor> opened = kept.open(file.filename().string());
    if (!opened) return;
    InputFile input{.file = std::move(*opened)};
    bytes.emplace();
    if (!input.read(*bytes, std::numeric_limits<std::int64_t>::max()))
      throw RunError(file.string() + ": " + input.error);
  });
  return bytes;
}

void demand_own(const fs::path& folder) {
  with_own_folder(folder, KeptFolder::Decides::programs, [](const KeptFolder&) {});
}

void make_own_folder(const fs::path& folder) {
  constexpr fs::perms others = fs::perms::group_write | fs::perms::others_write;
  const fs::path above = folder.parent_path();
  if (!above.empty()) make_folder(above);
  std::error_code error;
  const bool is_made = fs::create_directory(folder, error);
  if (is_made) fs::permissions(folder, others, fs::perm_options::remove, error);
  if (error) throw InputError("--out " + folder.string() + ": cannot make this folder: " + error.message());
  // Somebody else may have made it since it was looked for.
  if (!is_made) demand_own(folder);
}

}  // namespace tactor
