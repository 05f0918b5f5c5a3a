// The shipped graphs that a machine without hardware runs, by their clocks.
#pragma once

#include <algorithm>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include "app/report/run_report.hpp"
#include "app/run/headline.hpp"
#include "app/run/summary.hpp"
#include "tests/support/page_text.hpp"
#include "tests/support/shipped_graphs.hpp"

namespace tactor::test {

inline std::vector<std::filesystem::path> folders_of_graphs() {
  std::vector<std::filesystem::path> folders;
  for (const auto& entry : std::filesystem::directory_iterator(graphs)) {
    if (entry.is_directory()) folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

inline std::vector<std::filesystem::path> yaml_files(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// Does `work` with each of the files. An error in one of them hides none of another.
template <class Work>
void with_each(const std::vector<std::filesystem::path>& files, const Work& work) {
  for (const std::filesystem::path& file : files) {
    BOOST_TEST_CONTEXT(file) {
      try {
        work(file);
      } catch (const std::exception& error) {
        BOOST_ERROR(error.what());
      }
    }
  }
}

/// The graphs of all scenes, without those for hardware, which are run beside their emulators elsewhere.
inline std::vector<std::filesystem::path> graphs_with_clock(Clock clock) {
  const std::regex hardware("type: *(modbus|usb|falcon)\\.");
  std::vector<std::filesystem::path> found;
  for (const std::filesystem::path& folder : folders_of_graphs()) {
    if (!std::filesystem::exists(folder / "scene.yaml")) continue;
    with_each(yaml_files(folder), [&](const std::filesystem::path& file) {
      if (!std::regex_search(text_in(file), hardware) && loaded(file).clock == clock) found.push_back(file);
    });
  }
  return found;
}

/// What makes a shipped soft body coarse, which saves minutes, beside what is laid over the graph.
inline Over with_few_tetrahedra(const std::filesystem::path& graph, Over over) {
  if (graph.parent_path().filename() == "bunny_soft") over.push_back("scene.bodies.bunny.tetrahedra=500");
  return over;
}

/// Runs the plan with all that the page of a run shows.
inline RunResult run_for_page(const Plan& plan) {
  return run(plan, {}, {.traces = true});
}

/// What `tactor run` writes and prints of a judged run.
inline void check_told(const RunResult& result, const GraphSpec& graph) {
  const std::string error = "delivered.force.rms_error_N";
  BOOST_TEST((run_report(result, &graph).find("<svg") != std::string::npos));
  const nlohmann::json summary = nlohmann::json::parse(to_json(result).dump());
  BOOST_TEST(summary.at("delivered").at("force").at("rms_error_N").get<double>() == result.metric(error));
  says(headline_text(result, "report.html", false, 1000), " N RMS, ");
}

}  // namespace tactor::test
