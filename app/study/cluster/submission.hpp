// What has been handed to a cluster: which tasks each job has, kept beside the plan of the study.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "app/study/cluster/cluster_plan.hpp"

namespace tactor {

/// How the jobs of a study are handed over; kept in cluster/options.json for --resume.
struct ClusterOptions {
  std::filesystem::path system;  ///< the cluster file
  std::string partition, account;
  double time_s = 0;                 ///< limit of each task; 0: by what the tasks are expected to take
  std::vector<std::string> options;  ///< further words for the command that submits
  unsigned at_once = 1;              ///< tasks at a time where the system is this machine
};
void write_options(const ClusterFolder& folder, const ClusterOptions& options);
/// Throws InputError where the file is missing or damaged.
ClusterOptions read_options(const ClusterFolder& folder);

/// One job: an array of tasks of one stage.
struct Submission {
  std::size_t number = 0;  ///< names its files in cluster/jobs
  StageKind stage = StageKind::runs;
  std::vector<std::size_t> chunks;  ///< by index in the array; {0} for a stage of one task
  std::string job;                  ///< what the cluster calls it; empty until it is handed over
};
void write_submission(const ClusterFolder& folder, const Submission& submission);
/// Throws InputError where there is no such one.
Submission read_submission(const ClusterFolder& folder, std::size_t number);
/// All there are, in order.
std::vector<Submission> read_submissions(const ClusterFolder& folder);
/// The names of their jobs.
std::vector<std::string> jobs_of(const std::vector<Submission>& submissions);

}  // namespace tactor
