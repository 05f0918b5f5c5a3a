#include "app/study/cluster/submission.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/study/cluster/own_files.hpp"
#include "app/study/cluster/shard.hpp"

namespace tactor {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

fs::path file_of(const ClusterFolder& folder, std::size_t number) {
  return folder.jobs() / fmt::format("{:04}.json", number);
}

Json read_json(const ClusterFolder& folder, const fs::path& file) {
  demand_own(folder);
  const std::optional<std::string> bytes = own_bytes(file);
  if (!bytes) throw InputError(file.string() + ": expected what a command with --cluster has left, found no file");
  Json json = Json::parse(*bytes, nullptr, false);
  if (!json.is_object()) throw InputError(file.string() + ": its bytes are damaged");
  return json;
}

/// Calls `read`, in which a value of another kind means a damaged file.
template <class Read>
auto from_json(const ClusterFolder& folder, const fs::path& file, const Read& read) {
  const Json json = read_json(folder, file);
  try {
    return read(json);
  } catch (const Json::exception&) {
    throw InputError(file.string() + ": its bytes are damaged");
  }
}

}  // namespace

void write_options(const ClusterFolder& folder, const ClusterOptions& options) {
  const Json json{{"system", options.system.string()}, {"partition", options.partition}, {"account", options.account},
                  {"time_s", options.time_s},          {"options", options.options},     {"at_once", options.at_once}};
  publish_bytes(json.dump(1) + "\n", folder.path() / "options.json");
}

ClusterOptions read_options(const ClusterFolder& folder) {
  return from_json(folder, folder.path() / "options.json", [](const Json& json) {
    ClusterOptions options;
    options.system = json.at("system").get<std::string>();
    options.partition = json.at("partition");
    options.account = json.at("account");
    options.time_s = json.at("time_s");
    options.options = json.at("options").get<std::vector<std::string>>();
    options.at_once = json.at("at_once");
    return options;
  });
}

void write_submission(const ClusterFolder& folder, const Submission& submission) {
  const Json json{{"stage", name_of(submission.stage)}, {"job", submission.job}, {"chunks", submission.chunks}};
  publish_bytes(json.dump() + "\n", file_of(folder, submission.number));
}

Submission read_submission(const ClusterFolder& folder, std::size_t number) {
  return from_json(folder, file_of(folder, number), [&](const Json& json) {
    Submission submission;
    submission.number = number;
    submission.stage = stage_of(json.at("stage"));
    submission.job = json.at("job");
    submission.chunks = json.at("chunks").get<std::vector<std::size_t>>();
    return submission;
  });
}

std::vector<Submission> read_submissions(const ClusterFolder& folder) {
  std::vector<Submission> submissions;
  std::error_code ignored;
  while (fs::exists(file_of(folder, submissions.size()), ignored)) {
    submissions.push_back(read_submission(folder, submissions.size()));
  }
  return submissions;
}

std::vector<std::string> jobs_of(const std::vector<Submission>& submissions) {
  std::vector<std::string> jobs;
  for (const Submission& submission : submissions) {
    if (!submission.job.empty()) jobs.push_back(submission.job);
  }
  return jobs;
}

}  // namespace tactor
