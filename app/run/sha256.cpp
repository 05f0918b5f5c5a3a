#include "app/run/sha256.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>
#include <sys/stat.h>

#include <array>
#include <ctime>
#include <memory>

#include "framework/core/check.hpp"
#include "framework/core/disk_cache.hpp"
#include "framework/core/input_file.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t digest_digits = 64;

class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    TACTOR_DEMAND(context_ != nullptr && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1);
  }
  void add(std::string_view bytes) { TACTOR_DEMAND(EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()) == 1); }
  [[nodiscard]] std::string digits() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned size = 0;
    TACTOR_DEMAND(EVP_DigestFinal_ex(context_.get(), digest.data(), &size) == 1);
    std::string text;
    for (unsigned i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
    return text;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context_;
};

/// What tells a file from the same one with other bytes; empty where it has been changed just now, within what the
/// system's clock of files tells apart.
std::string state_of(const fs::path& file) {
  constexpr std::time_t settled = 2;  // s
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return "missing";
  if (std::time(nullptr) - status.st_ctim.tv_sec < settled) return {};
  return fmt::format("{} {} {} {}.{}", status.st_dev, status.st_ino, status.st_size, status.st_ctim.tv_sec,
                     status.st_ctim.tv_nsec);
}

}  // namespace

std::string sha256(std::string_view bytes) {
  Sha256 hash;
  hash.add(bytes);
  return hash.digits();
}

std::string sha256_of_file(const fs::path& file) {
  constexpr std::size_t block = std::size_t{1} << 18U;
  InputFile input = open_input(file);
  if (!input.file) return "missing";
  Sha256 hash;
  std::string bytes(block, '\0');
  while (true) {
    const std::optional<std::size_t> got = input.read_some(bytes.data(), bytes.size());
    if (!got) return "missing";
    if (*got == 0) return hash.digits();
    hash.add(std::string_view(bytes).substr(0, *got));
  }
}

std::vector<std::string> sha256_of_libraries(const std::vector<fs::path>& files, const fs::path& cache_folder) {
  std::string states;
  bool settled = true;
  for (const fs::path& file : files) {
    const std::string state = state_of(file);
    settled = settled && !state.empty();
    states += file.string() + "\n" + state + "\n";
  }
  const DiskCache cache("hashes", 1, cache_folder);
  const std::string key = content_key({states});
  std::vector<std::string> hashes;
  if (const DiskCache::Found found = settled ? cache.load(key) : DiskCache::Found{};
      found.bytes && found.bytes->view().size() == files.size() * digest_digits) {
    for (std::size_t i = 0; i < files.size(); ++i) {
      hashes.emplace_back(found.bytes->view().substr(i * digest_digits, digest_digits));
    }
    return hashes;
  }
  std::string kept;
  for (const fs::path& file : files) kept += hashes.emplace_back(sha256_of_file(file));
  // What cannot be kept is computed again.
  if (settled && kept.size() == files.size() * digest_digits) static_cast<void>(cache.store(key, kept));
  return hashes;
}

}  // namespace tactor
