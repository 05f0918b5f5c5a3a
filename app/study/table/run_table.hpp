// The results of many runs in one crash-safe file: what tells them apart, and every metric of each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "app/run/provenance.hpp"
#include "app/run/ran_on.hpp"
#include "app/run/run.hpp"

namespace tactor {

/// How a run of a table ended.
enum class RunStatus : std::uint8_t {
  done,
  failed,   ///< while running
  refused,  ///< it could not begin: bad input
};

/// One run of a table, by its number.
struct RunRecord {
  std::size_t number = 0;
  RunStatus status = RunStatus::done;
  std::string message;        ///< why it failed or was refused
  bool may_differ = false;    ///< it failed, and not by itself alone: the machine or a time limit ended it
  RunResult result;           ///< run times are medians over the repeats
  std::vector<double> cpu_s;  ///< CPU time of each repeat, in their order
  /// CPU time of a fixed computation just before: how noisy the machine is. NaN where nobody could tell, as of a run
  /// whose worker ended.
  double control_us = std::numeric_limits<double>::quiet_NaN();
  RanOn ran_on;          ///< empty where its worker ended
  std::string finished;  ///< when, in UTC: `2026-11-26 11:45:57`
};

/// What a run is, to find it again.
struct RunName {
  std::string graph;
  std::string configuration;
  std::uint64_t seed = 0;
  std::string content;  ///< hash of the resolved graph and the bytes of its files, or of why it is refused; or empty:
                        ///< not known, which agrees with any
};

/// What the runs of a table were made for; tables of another one are not gone on with.
struct TableIdentity {
  std::string title;
  std::string study;    ///< hash of the study file
  std::string options;  ///< hash of what the command line lays over it
  std::string program;  ///< hash of the code
};

enum class TableMode : std::uint8_t {
  create,     ///< an existing table is an error
  resume,     ///< continues an existing one, if there is one, and removes the runs that may end differently now
  overwrite,  ///< begins anew
};

/// An SQLite file in WAL mode. What depends on graph and seed alone is in other tables (names, runs, metrics, declared,
/// costs, curves) than what took how long and where (run_times, repeat_times, step_times). It has one transaction a
/// run: the death of the process at any time loses no run that was added, and a loss of power leaves a whole table. One
/// process at a time writes it. Used by one thread at a time.
class RunTable {
 public:
  /// Throws InputError where the mode forbids the file that is there, where it is no table, or where it was made for
  /// other runs, naming what has changed; RunError where the disk refuses.
  RunTable(std::filesystem::path path, TableMode mode, const TableIdentity& identity, const std::vector<RunName>& runs);
  ~RunTable();
  RunTable(const RunTable&) = delete;
  RunTable& operator=(const RunTable&) = delete;

  /// Whether the runs begin anew in it, because there was no table yet, or an empty one.
  [[nodiscard]] bool is_new() const { return is_new_; }
  /// Whether the run of that number is there, by number.
  [[nodiscard]] std::vector<bool> finished() const;
  /// Adds a run that is not there yet. Throws RunError where the disk refuses.
  void add(const RunRecord& record) { add(std::span(&record, 1)); }
  /// Adds several in one transaction: all or none.
  void add(std::span<const RunRecord> records);
  /// All runs there are, by number; without what they declare.
  [[nodiscard]] std::vector<RunRecord> read() const;
  /// What the runs that are done may report.
  [[nodiscard]] MetricMap declared() const;
  /// Keeps the provenance of the runs that were added, beside those of earlier commands, in the table `identity`.
  void tell(const Provenance& provenance);
  /// Writes the table to a new file, without journal and in order: tables with the same runs become the same bytes.
  /// Throws RunError where the disk refuses.
  void save_as(const std::filesystem::path& file) const;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  struct Database;
  std::filesystem::path path_;
  std::unique_ptr<Database> db_;
  bool is_new_ = false;
};

}  // namespace tactor
