#include "app/run/verify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/run/run.hpp"
#include "app/run/sha256.hpp"
#include "app/run/summary.hpp"
#include "framework/core/input_file.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/node/registry.hpp"
#include "framework/record/recorder.hpp"

namespace tactor {

namespace fs = std::filesystem;

using SummaryJson = nlohmann::ordered_json;

namespace {

constexpr std::uint64_t most_summary_bytes = std::uint64_t{1} << 28U;

/// The results of a run as they lie in a folder.
struct KeptResult {
  fs::path folder;
  SummaryJson summary;
  Provenance provenance;
};

[[noreturn]] void refuse_result(const fs::path& folder, const std::string& why) {
  throw InputError(fmt::format("{}: its run cannot be made again: {}", folder.string(), why));
}

KeptResult read_result(const fs::path& result) {
  const bool is_file = result.filename() == "summary.json";
  KeptResult kept{is_file ? fs::absolute(result).parent_path() : result, {}, {}};
  const fs::path file = kept.folder / "summary.json";
  for (const char* table : {"study.json", "compare.json"}) {
    if (is_file || !fs::exists(kept.folder / table)) continue;
    throw InputError(fmt::format(
        "{}: expected the results of one run, found a table of many: run it again with another --out, and compare the "
        "tables, which are equal to the byte but for run times and provenance",
        kept.folder.string()));
  }
  if (!is_file && !fs::exists(file)) {
    throw InputError(
        fmt::format("{}: expected the results of a run, which have a summary.json, found none", kept.folder.string()));
  }
  const std::string text = read_input_file(file, most_summary_bytes);
  kept.summary = SummaryJson::parse(text, nullptr, false);
  if (!kept.summary.is_object() || !kept.summary.contains("clock")) {
    throw InputError(fmt::format("{}: expected the summary of a run, found another file", file.string()));
  }
  if (!kept.summary.contains("provenance")) {
    throw InputError(
        fmt::format("{}: expected a summary that tells its provenance, found one of tactor {}, which does not",
                    file.string(), kept.summary.value("tactor", "of an unknown version")));
  }
  kept.provenance = provenance_from_json(kept.summary["provenance"], file.string());
  return kept;
}

/// Throws InputError where the run cannot be made again, whatever its graph.
void check_result(const KeptResult& kept) {
  if (kept.summary["clock"] != "virtual") {
    refuse_result(kept.folder,
                  "it was live, and what its devices and threads did happened once; `tactor replay` repeats its "
                  "recording");
  }
  if (kept.summary.contains("failure")) refuse_result(kept.folder, "it failed before its end");
  for (const char* key : {"interrupted", "reference_interrupted"}) {
    if (kept.summary.value(key, false)) refuse_result(kept.folder, "somebody ended it early");
  }
  if (!fs::exists(kept.folder / "graph.yaml")) refuse_result(kept.folder, "its graph.yaml is missing");
  for (const HashedFile& one : kept.provenance.files) {
    // The graph as it ran is in graph.yaml.
    if (one.of == "graph" || fs::exists(one.file)) continue;
    refuse_result(kept.folder, fmt::format("{} ({}) is missing", one.file.string(), one.of));
  }
}

FilesNow inputs_now(const std::vector<HashedFile>& files) {
  FilesNow found;
  for (const HashedFile& one : files) {
    const std::string now = sha256_of_file(one.file);
    if (now == one.sha256) {
      ++found.same;
      continue;
    }
    const std::string kept = one.of == "graph" ? "; the run was made from graph.yaml" : "";
    found.others.push_back(
        fmt::format("{}: {} ({}){}", now == "missing" ? "missing" : "differs", one.file.string(), one.of, kept));
  }
  return found;
}

/// By name, since an installation may have been moved.
FilesNow libraries_now(const std::vector<HashedFile>& was, const std::vector<HashedFile>& now) {
  std::map<std::string, std::string> hashes;
  for (const HashedFile& one : now) hashes[one.file.filename().string()] = one.sha256;
  FilesNow found;
  for (const HashedFile& one : was) {
    const auto other = hashes.find(one.file.filename().string());
    if (other == hashes.end()) {
      found.others.push_back("not loaded now: " + one.file.string());
    } else if (other->second == one.sha256) {
      ++found.same;
    } else {
      found.others.push_back("differs: " + one.file.string());
    }
    if (other != hashes.end()) hashes.erase(other);
  }
  for (const auto& [name, hash] : hashes) found.others.push_back("not loaded then: " + name);
  return found;
}

/// Throws InputError where the recording of the results is gone or was not closed.
std::unique_ptr<RecordingReader> kept_recording(const fs::path& folder) {
  if (!fs::exists(folder / "recording.h5")) refuse_result(folder, "its recording.h5 is missing");
  std::unique_ptr<RecordingReader> reader = load_record_library().open(folder / "recording.h5");
  if (!reader->complete()) refuse_result(folder, "its recording was not closed");
  return reader;
}

RunResult made_again(const Plan& plan, const KeptResult& kept, const VerifyOptions& options, const fs::path& folder) {
  RunOptions run;
  run.recording = folder / "recording.h5";
  run.cache_folder = options.cache_folder;
  run.provenance = true;
  run.progress = options.progress;
  run.stop_asked = options.stop_asked;
  run.note = options.note;
  for (const HashedFile& one : kept.provenance.files) {
    if (one.of == reference_option) run.reference_recording = one.file;
  }
  run.without_reference = !run.reference_recording && !kept.summary.contains("reference_run");
  RunResult result = execute(plan, run);
  if (result.failure) throw RunError("the run failed when it was made again: " + *result.failure);
  if (result.interrupted || result.reference_interrupted) throw RunError("interrupted");
  return result;
}

std::string part_text(const char* name, const FilesNow& files) {
  std::string out;
  for (const std::string& line : files.others) out += fmt::format("  {:<12}{}\n", name, line);
  return out + fmt::format("  {:<12}{} the same\n", name, files.same);
}

std::string commit_of(const Provenance& made) {
  return made.commit + (made.dirty ? " with changes that were not committed" : "");
}

}  // namespace

Verification verify_run(const fs::path& result, Registry& registry, const VerifyOptions& options) {
  const KeptResult kept = read_result(result);
  check_result(kept);
  const Plan plan = make_plan(load_graph(kept.folder / "graph.yaml", registry));
  for (const NodeSpec& node : plan.nodes) {
    if (node.info->fed) refuse_result(kept.folder, fmt::format("another program stepped its node {}", node.name));
  }
  Verification found;
  found.was = kept.provenance;
  const auto definitions = kept.summary.value("metric_definitions", 0);
  if (definitions != metric_definitions) {
    found.notes.push_back(
        fmt::format("metrics have version {} of their definitions, now {}: differences may come from that", definitions,
                    metric_definitions));
  }
  std::unique_ptr<RecordingReader> was = plan.streams.empty() ? nullptr : kept_recording(kept.folder);
  found.files = inputs_now(kept.provenance.files);
  const TemporaryFolder folder;
  const RunResult again = made_again(plan, kept, options, folder.path());
  found.now = again.provenance;
  found.libraries = libraries_now(found.was.libraries, found.now.libraries);
  if (was != nullptr) {
    if (was->header().graph != again.graph_yaml)
      found.notes.emplace_back("graph.yaml is not the graph that was recorded");
    const std::unique_ptr<RecordingReader> now = load_record_library().open(folder.path() / "recording.h5");
    compare_recordings(*was, *now, found.results);
  }
  // As text, so that both have the numbers that JSON can say.
  compare_summaries(kept.summary, SummaryJson::parse(to_json(again).dump()), found.results);
  return found;
}

std::string verification_text(const Verification& found) {
  std::string out = fmt::format("\n  {:<12}{} on {} ({}) by tactor {}\n", "made", found.was.date, found.was.host.node,
                                found.was.host.processor, found.was.version);
  if (commit_of(found.was) == commit_of(found.now)) {
    out += fmt::format("  {:<12}{}, the same\n", "commit", commit_of(found.was));
  } else {
    out += fmt::format("  {:<12}{}, now {}\n", "commit", commit_of(found.was), commit_of(found.now));
  }
  for (const std::string& note : found.notes) out += fmt::format("  {:<12}{}\n", "note", note);
  out += part_text("files", found.files) + part_text("libraries", found.libraries);
  const ResultComparison& results = found.results;
  out += fmt::format("  {:<12}{} of {} equal\n  {:<12}{} of {} equal\n", "data sets", results.equal_data_sets,
                     results.data_sets, "metrics", results.equal_metrics, results.metrics);
  constexpr std::size_t shown = 10;
  for (std::size_t i = 0; i < std::min(shown, results.differences.size()); ++i) {
    out += fmt::format("  {:<12}{}\n", i == 0 ? "differs" : "", results.differences[i]);
  }
  if (results.differences.size() > shown) {
    out += fmt::format("  {:<12}and {} more\n", "", results.differences.size() - shown);
  }
  return out + (results.is_equal() ? "\n  The run is the same, to the byte.\n" : "\n  The run is another one now.\n");
}

}  // namespace tactor
