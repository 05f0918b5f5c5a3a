// What a study on a cluster is: its runs, cut into stages of tasks, in a folder that all machines share.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/study/run/planned_cases.hpp"
#include "app/study/spec/study_spec.hpp"

namespace tactor {

/// The steps of a study on a cluster. Those before `intervals` and `runs` are cut into chunks, a task each.
enum class StageKind : std::uint8_t {
  warm,        ///< when each run is warm
  references,  ///< reference runs, into the cache that the tasks share
  intervals,   ///< one task: from when on each group is judged, by what `warm` found
  runs,        ///< the runs under test
  merge,       ///< one task: the table of runs, and what the study reports of it
};
inline constexpr std::array all_stages{StageKind::warm, StageKind::references, StageKind::intervals, StageKind::runs,
                                       StageKind::merge};
/// `warm`, `references`, ...
const char* name_of(StageKind stage);
/// Throws InputError where no stage has this name.
StageKind stage_of(const std::string& name);

/// A stage whose work is cut into chunks. Its units are the seeds of its cases: unit = place of the case * seeds +
/// seed.
struct Stage {
  StageKind kind = StageKind::runs;
  std::vector<std::size_t> cases;        ///< in ascending order
  std::vector<std::size_t> chunk_begin;  ///< first unit of each chunk, and one past the last unit of all

  [[nodiscard]] std::size_t units() const { return chunk_begin.empty() ? 0 : chunk_begin.back(); }
  [[nodiscard]] std::size_t chunks() const { return chunk_begin.empty() ? 0 : chunk_begin.size() - 1; }
};

/// What is known of the time that units take, in s.
struct UnitCosts {
  std::vector<double> warm, references, runs;  ///< by case
  [[nodiscard]] const std::vector<double>& of(StageKind stage) const;
};

struct ClusterPlan {
  StudySpec spec;
  PlannedCases planned;
  std::map<std::string, std::string> code;  ///< file name of program and libraries: hash of its bytes
  std::vector<Stage> stages;                ///< those with chunks, in order
  UnitCosts costs;
  std::vector<std::string> recordings;  ///< PlannedCases::recording_hash by run; empty where none judges
  /// What of its runs depends on the processor, as far as those that were measured tell; see processor_dependence().
  std::vector<std::string> depends_on_processor;
  double chunk_s = 120;
  bool exclusive = false;  ///< its tasks have nodes of their own
  std::string key;         ///< hash of all of these

  [[nodiscard]] const Stage* stage(StageKind kind) const;
  /// What the shards of a stage belong to. Those of runs belong to the judged intervals too, which must be known.
  [[nodiscard]] std::string shard_key(StageKind stage) const;
  /// The run that a unit of the stage is or is for.
  [[nodiscard]] std::size_t run_of(const Stage& stage, std::size_t unit) const;
};

/// Makes the stages of a plan whose cases, costs and chunk_s are set.
void cut_into_stages(ClusterPlan& plan);

/// What the name of a shard of a whole chunk ends with.
inline constexpr const char* shard_ending = ".shard";

/// Where the files of a study on a cluster are: OUT/cluster.
class ClusterFolder {
 public:
  explicit ClusterFolder(std::filesystem::path out) : out_(std::move(out)) {}
  [[nodiscard]] const std::filesystem::path& out() const { return out_; }
  [[nodiscard]] std::filesystem::path path() const { return out_ / "cluster"; }
  [[nodiscard]] std::filesystem::path plan() const { return path() / "plan.bin"; }
  [[nodiscard]] std::filesystem::path cache() const { return path() / "cache"; }
  /// The cache of reference runs for this machine: its own where they depend on the processor.
  [[nodiscard]] std::filesystem::path cache_of(const ClusterPlan& plan) const;
  [[nodiscard]] std::filesystem::path intervals() const { return path() / "intervals.bin"; }
  [[nodiscard]] std::filesystem::path jobs() const { return path() / "jobs"; }
  /// What the merge has printed, and its exit code: there when it has ended.
  [[nodiscard]] std::filesystem::path table() const { return path() / "table.txt"; }
  [[nodiscard]] std::filesystem::path merged() const { return path() / "merged.json"; }
  [[nodiscard]] std::filesystem::path shards(StageKind stage) const { return path() / name_of(stage); }
  /// The shard of a whole chunk.
  [[nodiscard]] std::filesystem::path shard(StageKind stage, std::size_t chunk) const;
  /// The shard of a chunk of which only a part is there.
  [[nodiscard]] std::filesystem::path part(StageKind stage, std::size_t chunk) const;
  /// The shard of a task that this process ran a second time and that came second.
  [[nodiscard]] std::filesystem::path my_twin(StageKind stage, std::size_t chunk) const;
  /// All twins of a stage, in the order of their names.
  [[nodiscard]] std::vector<std::filesystem::path> twins(StageKind stage) const;
  [[nodiscard]] bool is_twin_of(const std::filesystem::path& twin, std::size_t chunk) const;
  /// Why a reference run could not be made, where it took its worker with it; by the run that it was made for.
  [[nodiscard]] std::filesystem::path lost_reference(std::size_t run) const;
  /// Whether a study has been handed to a cluster from here.
  [[nodiscard]] bool is_there() const;

 private:
  std::filesystem::path out_;
};

/// Throws InputError where OUT or OUT/cluster, as far as they are there, are not of this user alone.
void demand_own(const ClusterFolder& folder);

/// Writes plan.bin, and manifest.json, which says the same to people: what is run, and hashes of all that it depends
/// on. Sets the plan's key.
void write_plan(ClusterPlan& plan, const ClusterFolder& folder);
/// Throws InputError where the file is missing, damaged, of another version of the program, or not this user's own.
ClusterPlan read_plan(const ClusterFolder& folder);

}  // namespace tactor
