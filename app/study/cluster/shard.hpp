// What one task of a study on a cluster has made: a file of records that tells where it ends and what is damaged.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/run/ran_on.hpp"
#include "framework/core/file_descriptor.hpp"

namespace tactor {

/// What the records of a shard belong to.
struct ShardHead {
  std::string plan;   ///< ClusterPlan::key
  std::string stage;  ///< its name
  std::size_t chunk = 0;
  RanOn ran_on;
  /// Whether the records are those of a chunk, whatever made them.
  [[nodiscard]] bool is_of(const std::string& plan_key, const std::string& stage_name, std::size_t number) const {
    return plan == plan_key && stage == stage_name && chunk == number;
  }
  bool operator==(const ShardHead&) const = default;
};

/// What a task spent, of all tries whose records are there.
struct ShardCost {
  double cpu_s = 0;
  double wall_s = 0;
  double run_cpu_s = 0;  ///< in jobs: without start, planning and files
};

struct Shard {
  ShardHead head;
  std::vector<std::pair<std::size_t, std::string>> records;  ///< unit and its answer, as a message
  ShardCost cost;                                            ///< as far as it has been written
  std::vector<std::string> depends_on_processor;             ///< as processor_dependence()
  bool complete = false;                                     ///< it ends with what its task wrote at the end
  std::string damage;  ///< what is wrong with the rest of the file; empty: nothing
};

/// Appends records to a new file. Each is framed by its size and a checksum, so that whatever ends the task costs the
/// record that was being written. All members throw RunError where the disk refuses.
class ShardWriter {
 public:
  ShardWriter(std::filesystem::path file, const ShardHead& head);
  void add(std::size_t unit, const std::string& answer);
  /// What the task has spent so far, in place of what was said before.
  void spent(const ShardCost& cost, const std::vector<std::string>& depends_on_processor);
  /// Says that all records of the chunk are there.
  void complete();
  [[nodiscard]] const std::filesystem::path& file() const { return path_; }
  /// Reads back the records that are on the disk.
  [[nodiscard]] Shard written() const;

 private:
  void append(std::string_view payload);
  std::filesystem::path path_;
  FileDescriptor file_;
};

/// What is whole of these bytes of a file.
Shard shard_of(const std::string& bytes);

/// Reads what is whole of a file; nothing where there is no such file. Damage is no error: it is told, and the records
/// before it count. Throws InputError where the file is not of this user alone (see own_bytes).
std::optional<Shard> read_shard(const std::filesystem::path& file);

/// Puts a copy of a finished file at `to`, which is on a file system that other machines share: written beside it,
/// flushed to the disk, then linked. The first one wins: returns false where `to` is there already. Throws RunError
/// where the disk refuses.
bool publish_first(const std::filesystem::path& from, const std::filesystem::path& to);
/// The same, but the last one wins: it replaces what is there.
void publish_last(const std::filesystem::path& from, const std::filesystem::path& to);
/// The same for bytes.
void publish_bytes(std::string_view bytes, const std::filesystem::path& to);
/// The same with a checksum in front, which read_checked takes off.
void publish_checked(std::string_view bytes, const std::filesystem::path& to);
/// Nothing where the file is missing or damaged. Throws InputError where it is not of this user alone.
std::optional<std::string> read_checked(const std::filesystem::path& file);

}  // namespace tactor
