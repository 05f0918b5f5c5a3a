#include "app/study/cluster/shard.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>

#include "app/study/cluster/own_files.hpp"
#include "app/study/run/job_fields.hpp"
#include "framework/core/check.hpp"
#include "framework/core/disk_cache.hpp"

namespace tactor {

namespace fs = std::filesystem;

void fields(auto& bytes, SameAs<ShardHead> auto& head) {
  bytes(head.plan, head.stage, head.chunk, head.ran_on);
}
void fields(auto& bytes, SameAs<ShardCost> auto& cost) {
  bytes(cost.cpu_s, cost.wall_s, cost.run_cpu_s);
}

namespace {

/// What a frame of a shard holds.
enum class FrameKind : char { head, record, spent, complete };

/// Before each payload: its size, and the hash of what it holds.
constexpr std::size_t hash_digits = 32;
constexpr std::size_t frame_head = sizeof(std::uint64_t) + hash_digits;

std::string frame_hash(std::string_view payload) {
  return content_key({"shard", payload});
}

struct Spent {
  ShardCost cost;
  std::vector<std::string> depends_on_processor;
};
void fields(auto& bytes, SameAs<Spent> auto& spent) {
  bytes(spent.cost, spent.depends_on_processor);
}

template <class T>
std::string payload_of(FrameKind kind, const T& value) {
  return std::string(1, static_cast<char>(kind)) + to_bytes(value);
}

[[noreturn]] void fail(const std::string& what, const fs::path& path) {
  throw RunError(fmt::format("cannot {} {}: {}", what, path.string(), std::strerror(errno)));
}

/// Takes a frame into the shard; throws RunError where it holds something else than it says.
void take_frame(Shard& shard, std::string_view payload, bool first) {
  const auto kind = static_cast<FrameKind>(payload.empty() ? '\xff' : payload.front());
  if (first != (kind == FrameKind::head)) throw RunError("its frames are in another order");
  payload.remove_prefix(1);
  switch (kind) {
    case FrameKind::head:
      shard.head = from_bytes<ShardHead>(payload);
      return;
    case FrameKind::record:
      shard.records.push_back(from_bytes<std::pair<std::size_t, std::string>>(payload));
      return;
    case FrameKind::spent: {
      Spent spent = from_bytes<Spent>(payload);
      shard.cost = spent.cost;
      shard.depends_on_processor = std::move(spent.depends_on_processor);
      return;
    }
    case FrameKind::complete:
      shard.complete = true;
      return;
  }
  throw RunError("it holds a frame of no kind");
}

void flush_folder(const fs::path& folder) {
  const FileDescriptor opened(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (opened) static_cast<void>(fsync(opened.number()));  // some file systems refuse, and then there is no more to do
}

/// A file beside `to` with these bytes, on the disk.
fs::path written_beside(std::string_view bytes, const fs::path& to) {
  static std::atomic<unsigned> number = 0;
  fs::path part = to;
  part += fmt::format(".{}-{}-{}.part", this_machine().node, getpid(), number++);
  // Whatever new files are given by default: what others may write is not read back.
  FileDescriptor file(open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  if (!file) fail("write", part);
  if (!file.write_all(bytes.data(), bytes.size()) || fsync(file.number()) != 0 || !file.close()) {
    const int error = errno;
    unlink(part.c_str());
    errno = error;
    fail("write", part);
  }
  return part;
}

std::string bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(stream), {});
  if (!stream) fail("read", file);
  return bytes;
}

}  // namespace

ShardWriter::ShardWriter(fs::path file, const ShardHead& head)
    : path_(std::move(file)), file_(open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644)) {
  if (!file_) fail("write", path_);
  append(payload_of(FrameKind::head, head));
}

void ShardWriter::append(std::string_view payload) {
  const std::uint64_t size = payload.size();
  std::string frame(reinterpret_cast<const char*>(&size), sizeof size);
  frame += frame_hash(payload);
  frame += payload;
  if (!file_.write_all(frame.data(), frame.size())) fail("write", path_);
}

void ShardWriter::add(std::size_t unit, const std::string& answer) {
  append(payload_of(FrameKind::record, std::pair(unit, answer)));
}

void ShardWriter::spent(const ShardCost& cost, const std::vector<std::string>& depends_on_processor) {
  append(payload_of(FrameKind::spent, Spent{cost, depends_on_processor}));
}

void ShardWriter::complete() {
  append(std::string(1, static_cast<char>(FrameKind::complete)));
}

Shard ShardWriter::written() const {
  return shard_of(bytes_of(path_));
}

Shard shard_of(const std::string& bytes) {
  Shard shard;
  std::string_view rest = bytes;
  for (bool first = true; !rest.empty(); first = false) {
    std::uint64_t size = 0;
    if (rest.size() >= frame_head) std::memcpy(&size, rest.data(), sizeof size);
    if (rest.size() < frame_head || size > rest.size() - frame_head) {
      shard.damage = "it ends in the middle of a record";
      break;
    }
    const std::string_view payload = rest.substr(frame_head, size);
    if (rest.substr(sizeof size, hash_digits) != frame_hash(payload)) {
      shard.damage = fmt::format("its bytes from {} on are damaged", bytes.size() - rest.size());
      break;
    }
    try {
      take_frame(shard, payload, first);
    } catch (const RunError& error) {
      shard.damage = error.what();
      break;
    }
    rest.remove_prefix(frame_head + size);
  }
  if (bytes.empty()) shard.damage = "it is empty";
  if (!shard.damage.empty()) shard.complete = false;
  return shard;
}

std::optional<Shard> read_shard(const fs::path& file) {
  const std::optional<std::string> bytes = own_bytes(file);
  return bytes ? std::optional(shard_of(*bytes)) : std::nullopt;
}

bool publish_first(const fs::path& from, const fs::path& to) {
  const fs::path part = written_beside(bytes_of(from), to);
  const bool linked = link(part.c_str(), to.c_str()) == 0;
  const int error = errno;
  // Over NFS a link may be made and its answer lost; asked again, it is there already. The file has two names then.
  std::error_code none;
  const bool linked_before = !linked && error == EEXIST && fs::hard_link_count(part, none) == 2;
  bool won = linked || linked_before;
  if (!won && error != EEXIST) {
    // A file system without hard links: two that come within this moment leave the later one, which is as good.
    std::error_code ignored;
    won = !fs::exists(to, ignored) && rename(part.c_str(), to.c_str()) == 0;
    if (!won && !fs::exists(to, ignored)) {
      unlink(part.c_str());
      errno = error;
      fail("write", to);
    }
  }
  unlink(part.c_str());
  flush_folder(to.parent_path());
  return won;
}

void publish_bytes(std::string_view bytes, const fs::path& to) {
  const fs::path part = written_beside(bytes, to);
  if (rename(part.c_str(), to.c_str()) != 0) {
    const int error = errno;
    unlink(part.c_str());
    errno = error;
    fail("write", to);
  }
  flush_folder(to.parent_path());
}

void publish_checked(std::string_view bytes, const fs::path& to) {
  publish_bytes(frame_hash(bytes) + std::string(bytes), to);
}

std::optional<std::string> read_checked(const fs::path& file) {
  const std::optional<std::string> bytes = own_bytes(file);
  if (!bytes || bytes->size() < hash_digits) return std::nullopt;
  std::string content = bytes->substr(hash_digits);
  if (bytes->compare(0, hash_digits, frame_hash(content)) != 0) return std::nullopt;
  return content;
}

void publish_last(const fs::path& from, const fs::path& to) {
  publish_bytes(bytes_of(from), to);
}

}  // namespace tactor
