// What a worker is asked to do and what it answers: data that holds all there is to know, for a process anywhere.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "app/run/run_metrics.hpp"
#include "app/study/table/run_table.hpp"
#include "framework/engine/warmth.hpp"
#include "framework/graph/patch.hpp"

namespace tactor {

enum class JobKind : std::uint8_t {
  plan,       ///< read and check the graph; answered by a CaseCheck
  warm_up,    ///< run it until all nodes are warm; answered by a WarmUp
  reference,  ///< make the reference run, into the cache; answered by a JobCost
  run,        ///< run it, repeats and all; answered by a RunAnswer
};

/// One piece of work of a study.
struct Job {
  JobKind kind = JobKind::run;
  std::filesystem::path graph;
  Overrides overrides;
  std::optional<Overrides> reference;  ///< as RunCase::reference
  std::uint64_t seed = 1;              ///< of the run; of a plan any seed of the study, for all of them
  std::vector<std::uint64_t> seeds{};  ///< of a plan whose runs recordings judge: of all of them
  /// The node libraries that the study needs: keys of reference runs name those that are loaded.
  std::vector<std::string> libraries;
  std::int64_t repeats = 1;
  std::int64_t warm_up = 0;
  bool without_reference = false;
  std::string reference_recording{};   ///< as RunCase::reference_recording
  std::optional<Time> judge_from{};    ///< as RunOptions::judge_from
  bool judge_whole = false;            ///< as RunOptions::judge_whole
  bool all_curves = false;             ///< else those of the table alone
  std::optional<double> time_limit_s;  ///< of real time, for each repeat
  std::filesystem::path cache_folder;
};

/// What a job took, without what was read and checked for it before.
struct JobCost {
  double cpu_s = 0;
  double waited_for_core_s = 0;  ///< in which the worker was ready to run and other programs had the cores
  bool interrupted = false;      ///< it has not been done, because somebody asked to end
  /// Of what it made, why its last digits may be others on another processor, as processor_dependence().
  std::vector<std::string> depends_on_processor{};
};

/// When a run is warm.
struct WarmUp {
  Warmth warmth;
  std::string failure;      ///< why it ended before; empty: it did not
  bool may_differ = false;  ///< next time: the machine or a time limit ended it
  JobCost cost;
};

/// How the check of a case ended.
enum class CheckResult : std::uint8_t {
  planned,
  refused,  ///< bad input
  failed,   ///< the computer refused
};

/// What a case is, without its plan.
struct CaseCheck {
  CheckResult result = CheckResult::planned;
  std::string message;  ///< why it is not planned
  std::string title;    ///< of the graph
  std::string content;  ///< as RunName::content
  /// Names the reference run together with the seed of a run; empty where it needs none.
  std::string reference;
  double duration_s = 0;                          ///< of its runs
  bool has_to_warm_up = false;                    ///< a node may not be warm from the start
  RunMetrics metrics;                             ///< that its runs report, and the run times that tables show
  std::vector<std::string> notes;                 ///< for the user
  std::vector<std::string> libraries;             ///< node libraries that the worker has loaded by now
  std::vector<std::filesystem::path> code_files;  ///< likewise, as code_files()
  std::vector<std::string> codes;                 ///< NodeInfo::code of its nodes in Python
  std::set<std::filesystem::path> inputs;         ///< files that its runs depend on, as input_files()
  std::set<std::filesystem::path> loaded;         ///< as loaded_code(), by now
};

struct RunAnswer {
  std::optional<RunRecord> record;  ///< without its number; nothing where it was interrupted
  JobCost cost;
};

std::string to_message(const Job& job);
std::string to_message(const JobCost& cost);
std::string to_message(const CaseCheck& check);
std::string to_message(const WarmUp& warm_up);
std::string to_message(const RunAnswer& answer);
/// For Job, JobCost, CaseCheck, WarmUp and RunAnswer. Throws RunError if the text is invalid.
template <class T>
T from_message(const std::string& text);

}  // namespace tactor
