#include "framework/core/disk_cache.hpp"

#include <sys/stat.h>
#include <xxhash.h>

#include <array>
#include <memory>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/core/input_file.hpp"
#include "framework/core/kept_folder.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// Of one entry with its header, so that a damaged size asks for no memory that is not there.
constexpr std::uint64_t most_bytes = std::uint64_t{1} << 31U;

constexpr std::array<char, 8> file_magic{'t', 'a', 'c', 't', 'o', 'r', 'c', '1'};

/// What stands before the bytes. Numbers are the machine's own; those of another byte order fail the checksum.
struct Header {
  std::array<char, 8> magic;
  std::uint32_t version;
  std::uint32_t zero;
  std::uint64_t size;
  std::array<unsigned char, 16> sum;
};
static_assert(sizeof(Header) == 40);

class Hash {
 public:
  Hash() : state_(XXH3_createState()) { XXH3_128bits_reset(state_.get()); }
  void add(std::string_view bytes) { XXH3_128bits_update(state_.get(), bytes.data(), bytes.size()); }
  void add(std::uint64_t number) {
    std::array<unsigned char, 8> bytes{};
    for (unsigned char& byte : bytes) byte = static_cast<unsigned char>(number), number >>= 8U;
    XXH3_128bits_update(state_.get(), bytes.data(), bytes.size());
  }
  [[nodiscard]] std::array<unsigned char, 16> digest() const {
    XXH128_canonical_t canonical;
    XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(state_.get()));
    return std::to_array(canonical.digest);
  }
  /// In hexadecimal digits.
  [[nodiscard]] std::string text() const {
    std::string text;
    for (const unsigned char byte : digest()) {
      text += "0123456789abcdef"[byte >> 4U];
      text += "0123456789abcdef"[byte & 15U];
    }
    return text;
  }

 private:
  struct Free {
    void operator()(XXH3_state_t* state) const { XXH3_freeState(state); }
  };
  std::unique_ptr<XXH3_state_t, Free> state_;
};

std::array<unsigned char, 16> checksum(const std::string& kind, const std::string& key, std::uint32_t version,
                                       std::string_view bytes) {
  Hash hash;
  for (const std::string_view text : {std::string_view(kind), std::string_view(key)}) {
    hash.add(text.size());
    hash.add(text);
  }
  hash.add(version);
  hash.add(bytes.size());
  hash.add(bytes);
  return hash.digest();
}

}  // namespace

std::string content_key(std::initializer_list<std::string_view> parts) {
  Hash hash;
  for (const std::string_view part : parts) {
    hash.add(part.size());
    hash.add(part);
  }
  return hash.text();
}

std::string file_key(const fs::path& file) {
  const std::string missing = "missing";
  InputFile input = open_input(file);
  if (!input.file) return missing;
  Hash hash;
  std::string block(std::size_t{1} << 18U, '\0');
  while (true) {
    const std::optional<std::size_t> size = input.read_some(block.data(), block.size());
    if (!size) return missing;
    if (*size == 0) return hash.text();
    hash.add(std::string_view(block).substr(0, *size));
  }
}

DiskCache::DiskCache(std::string kind, std::uint32_t version, fs::path folder)
    : kind_(std::move(kind)), version_(version), folder_(std::move(folder)) {
  TACTOR_DEMAND(!kind_.empty() && kind_.find_first_not_of("abcdefghijklmnopqrstuvwxyz") == std::string::npos);
}

fs::path DiskCache::file(const std::string& key) const {
  TACTOR_DEMAND(!key.empty() && key.find_first_not_of("0123456789abcdef") == std::string::npos);
  return folder_ / (key + "." + kind_);
}

DiskCache::Found DiskCache::load(const std::string& key) const {
  const fs::path path = file(key);
  std::optional<KeptFolder> folder;
  try {
    folder = KeptFolder::find(folder_);
  } catch (const RunError&) {
    // `store` finds the same and tells it.
  }
  if (!folder) return {};
  std::optional<FileDescriptor> in;
  try {
    in = folder->open(path.filename().string());
  } catch (const RunError& error) {
    return {{}, std::string(error.what()) + "; computed again"};
  }
  if (!in) return {};
  const auto broken = [&] {
    return Found{{}, path.string() + ": the cached file is damaged; computed again and replaced"};
  };
  struct stat status {};
  Header header{};
  if (::fstat(in->number(), &status) != 0 || status.st_size > static_cast<off_t>(most_bytes)) return broken();
  if (!in->read_all(&header, sizeof header) || header.magic != file_magic) return broken();
  if (header.version != version_) return {};
  if (header.zero != 0 || header.size != static_cast<std::uint64_t>(status.st_size) - sizeof header) return broken();
  Bytes bytes(header.size);
  if (!in->read_all(bytes.data(), header.size)) return broken();
  if (header.sum != checksum(kind_, key, version_, bytes.view())) return broken();
  return {std::move(bytes), {}};
}

std::string DiskCache::store(const std::string& key, std::string_view bytes) const {
  const fs::path path = file(key);
  const auto failed = [&](const std::string& why) {
    return (folder_.empty() ? std::string() : folder_.string() + ": ") + "the cache cannot be written: " + why +
           "; the next run computes the same again; set TACTOR_CACHE to a folder of your own that can be written";
  };
  if (bytes.size() + sizeof(Header) > most_bytes) {
    return failed("the entry has " + std::to_string(bytes.size() >> 20U) + " MiB, one may have " +
                  std::to_string(most_bytes >> 20U));
  }
  const Header header{file_magic, version_, 0, bytes.size(), checksum(kind_, key, version_, bytes)};
  try {
    KeptFolder::make(folder_).write(path.filename().string(),
                                    {{reinterpret_cast<const char*>(&header), sizeof header}, bytes});
  } catch (const RunError& error) {
    return failed(error.what());
  }
  return {};
}

}  // namespace tactor
