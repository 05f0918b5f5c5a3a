#include "framework/node/abi.hpp"

#include <algorithm>
#include <boost/interprocess/file_mapping.hpp>
#include <boost/interprocess/mapped_region.hpp>
#include <cctype>
#include <cstring>
#include <string_view>

#include "framework/core/check.hpp"
#include "framework/core/installation.hpp"
#include "tactor_abi.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view before_hash = "tactor abi ";
constexpr std::size_t hash_digits = 16;

bool is_hash(std::string_view text) {
  return text.size() == hash_digits &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isxdigit(c) != 0; });
}

}  // namespace

std::string framework_abi() {
  return TACTOR_ABI;
}

std::string stated_abi(const fs::path& file) {
  namespace ipc = boost::interprocess;
  std::error_code error;
  if (fs::file_size(file, error) == 0 || error) return {};
  try {
    const ipc::file_mapping mapping(file.c_str(), ipc::read_only);
    const ipc::mapped_region region(mapping, ipc::read_only);
    const char* next = static_cast<const char*>(region.get_address());
    const char* const end = next + region.get_size();
    // The same words may stand elsewhere in the file without a hash after them.
    while (true) {
      const auto left = static_cast<std::size_t>(end - next);
      const void* found = memmem(next, left, before_hash.data(), before_hash.size());
      if (found == nullptr) return {};
      next = static_cast<const char*>(found) + before_hash.size();
      const std::string_view hash(next, std::min(hash_digits, static_cast<std::size_t>(end - next)));
      if (is_hash(hash)) return std::string(hash);
    }
  } catch (const ipc::interprocess_exception& refused) {
    throw InputError("cannot read " + file.string() + ": " + refused.what());
  }
}

void check_abi(const fs::path& file) {
  const std::string stated = stated_abi(file);
  if (stated == framework_abi()) return;
  if (stated.empty()) {
    throw InputError(file.string() +
                     ": expected a library built for Tactor, found one that states no layout; node libraries have "
                     "TACTOR_NODES in one of their sources");
  }
  throw InputError(file.string() + ": built for the layout " + stated +
                   " of Tactor's messages and nodes, and the libtactor in " + library_folder().string() +
                   " has the layout " + framework_abi() +
                   "; it was not loaded. Build it again with the headers of this Tactor");
}

}  // namespace tactor
