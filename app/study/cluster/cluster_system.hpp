// How jobs reach a cluster: a file of command templates for submitting, asking and cancelling.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "framework/core/file_lookup.hpp"

namespace tactor {

inline const FileKind cluster_files{
    .noun = "a cluster file", .variable = "TACTOR_CLUSTER_PATH", .folder = "clusters", .ending = ".yaml"};

/// A command as words. `{name}` stands for a value. A word whose value is empty or not there is left out; one that is
/// nothing but `{jobs}`, `{after}` or `{options}` becomes a word for each of these. In a word that a shell reads (`sh
/// -c`, `sbatch --wrap`, all of ssh) each value is quoted.
using CommandTemplate = std::vector<std::string>;

/// A checked cluster file.
struct ClusterSystem {
  std::filesystem::path file;
  std::filesystem::path folder;  ///< of the file, `{here}`
  std::string title;
  CommandTemplate submit;       ///< prints the name of the job, up to a `;` or white space
  CommandTemplate status;       ///< prints `JOB [INDEX] STATE` for each task that waits or runs
  CommandTemplate cancel;       ///< ends the jobs `{jobs}`
  CommandTemplate most_tasks;   ///< prints how many tasks an array may have; may be empty
  std::string index;            ///< the variable of the environment that holds the index of a task in its array
  std::string joined_by = ":";  ///< what is between the jobs of `{after}` inside a word
  std::string exclusive;        ///< what `{exclusive}` is where a study asks for nodes of its own
  std::vector<std::string> waiting, running;  ///< states; tasks in other states have ended
  std::vector<std::string> held;              ///< those of `waiting` in which a task begins only when someone lets it
  std::size_t most_tasks_of_file = 1000;      ///< of an array, where `most_tasks` is empty
};

/// Throws GraphError with every error of the file, and InputError where another user could have written it: its
/// commands are started.
ClusterSystem load_cluster_system(const std::filesystem::path& file);

/// The values of a template.
struct TemplateValues {
  std::map<std::string, std::string> texts;
  std::map<std::string, std::vector<std::string>> lists;  ///< jobs, after, options
};
/// The words of a command.
std::vector<std::string> filled_in(const CommandTemplate& command, const TemplateValues& values,
                                   const std::string& joined_by);

/// How many tasks wait and run; `held` of those that wait.
struct JobCounts {
  std::size_t waiting = 0, running = 0, held = 0;
};
/// Asks the system, by job; jobs that have ended are not there. Throws RunError where it does not answer.
std::map<std::string, JobCounts> ask_for_jobs(const ClusterSystem& system, const std::vector<std::string>& jobs);
void cancel_jobs(const ClusterSystem& system, const std::vector<std::string>& jobs);
/// How many tasks an array may have.
std::size_t most_tasks_of_array(const ClusterSystem& system);

}  // namespace tactor
