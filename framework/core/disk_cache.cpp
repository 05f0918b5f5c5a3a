#include "framework/core/disk_cache.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <system_error>
#include <utility>

#include "framework/core/check.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

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

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int number() const { return number_; }
  [[nodiscard]] bool close() { return ::close(std::exchange(number_, -1)) == 0; }

 private:
  int number_;
};

bool read_all(int file, void* data, std::size_t size) {
  auto* at = static_cast<char*>(data);
  while (size > 0) {
    const ssize_t n = ::read(file, at, size);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    at += n, size -= static_cast<std::size_t>(n);
  }
  return true;
}

bool write_all(int file, const void* data, std::size_t size) {
  const auto* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t n = ::write(file, at, size);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return false;
    at += n, size -= static_cast<std::size_t>(n);
  }
  return true;
}

constexpr const char* part_infix = ".part.";

/// Removes what writers of this kind of entry that were killed have left; nothing takes a day to write.
void remove_stale_parts(const fs::path& folder, const std::string& kind) {
  const auto limit = fs::file_time_type::clock::now() - std::chrono::hours(24);
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code of_file;
    if (it->path().filename().string().find("." + kind + part_infix) == std::string::npos) continue;
    const fs::file_time_type written = it->last_write_time(of_file);
    if (!of_file && written < limit) fs::remove(it->path(), of_file);
  }
}

}  // namespace

std::string content_key(std::initializer_list<std::string_view> parts) {
  Hash hash;
  for (const std::string_view part : parts) {
    hash.add(part.size());
    hash.add(part);
  }
  std::string text;
  for (const unsigned char byte : hash.digest()) {
    text += "0123456789abcdef"[byte >> 4U];
    text += "0123456789abcdef"[byte & 15U];
  }
  return text;
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
  const Descriptor in(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (in.number() < 0) {
    // ENOTDIR: the folder of the cache is a file, which `store` tells.
    if (errno == ENOENT || errno == ENOTDIR) return {};
    return {{}, path.string() + ": the cache cannot be read: " + std::strerror(errno) + "; computed again"};
  }
  const auto broken = [&] {
    return Found{{}, path.string() + ": the cached file is damaged; computed again and replaced"};
  };
  struct stat status {};
  Header header{};
  if (::fstat(in.number(), &status) != 0 || !S_ISREG(status.st_mode)) return broken();
  if (!read_all(in.number(), &header, sizeof header) || header.magic != file_magic) return broken();
  if (header.version != version_) return {};
  if (header.zero != 0 || header.size != static_cast<std::uint64_t>(status.st_size) - sizeof header) return broken();
  std::string bytes(header.size, '\0');
  if (!read_all(in.number(), bytes.data(), bytes.size())) return broken();
  if (header.sum != checksum(kind_, key, version_, bytes)) return broken();
  return {std::move(bytes), {}};
}

std::string DiskCache::store(const std::string& key, std::string_view bytes) const {
  const fs::path path = file(key);
  const auto failed = [&](const std::string& why) {
    return folder_.string() + ": the cache cannot be written: " + why +
           "; the next run computes the same again; set TACTOR_CACHE to a folder that can be written";
  };
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error) return failed(error.message());
  remove_stale_parts(folder_, kind_);
  // Not mkstemp, whose files only their owner may read: the umask decides who shares the cache.
  static std::atomic<unsigned> made{0};
  std::string part;
  int number = -1;
  do {
    part = path.string() + part_infix + std::to_string(::getpid()) + "." + std::to_string(made++);
    number = ::open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (number < 0 && errno == EEXIST);
  if (number < 0) return failed(std::strerror(errno));
  Descriptor out(number);
  Header header{file_magic, version_, 0, bytes.size(), checksum(kind_, key, version_, bytes)};
  const bool written = write_all(out.number(), &header, sizeof header) &&
                       write_all(out.number(), bytes.data(), bytes.size()) && ::fsync(out.number()) == 0 &&
                       out.close() && std::rename(part.c_str(), path.c_str()) == 0;
  if (written) return {};
  const int reason = errno;
  ::unlink(part.c_str());
  return failed(std::strerror(reason));
}

}  // namespace tactor
