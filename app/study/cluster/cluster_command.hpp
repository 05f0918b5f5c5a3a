// `tactor study --cluster`, and what is asked of such a study later: how far it is, to end it, to go on, to wait.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/study/prepare_study.hpp"

namespace tactor {

/// What the command line says of the cluster.
struct ClusterRequest {
  std::filesystem::path system;  ///< the cluster file
  std::optional<std::string> partition, account;
  std::optional<double> time_s;  ///< limit of each task
  std::vector<std::string> options;
  double chunk_s = 120;  ///< what a task is to take
  bool exclusive = false;
  bool wait = false;
};

// All return the exit code, and throw InputError and RunError.

/// Plans the study here, measures a few runs, and submits the rest. Forks workers, so the program must have no other
/// thread.
int run_study_on_cluster(const StudyRequest& study, const ClusterRequest& cluster);
/// Throws InputError where the folder holds a study that is not to be overwritten, or that still runs on a cluster.
void refuse_study_folder(const std::filesystem::path& out, bool overwrite);
/// Whether a folder holds a study that was handed to a cluster.
bool is_cluster_study(const std::filesystem::path& out);
int show_cluster_status(const std::filesystem::path& out);
int cancel_cluster_study(const std::filesystem::path& out);
/// Submits what is missing. `study`: its file is that of the study, which must ask for the same runs, or the folder
/// itself. What `cluster` says replaces what was said before; its system and chunk_s do not count.
int resume_cluster_study(const std::filesystem::path& out, const StudyRequest& study, const ClusterRequest& cluster);
/// Until it is merged or nothing runs any more; then prints what the merge has printed.
int wait_for_cluster_study(const std::filesystem::path& out);

}  // namespace tactor
