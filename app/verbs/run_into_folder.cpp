#include "app/verbs/run_into_folder.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "app/interruption.hpp"
#include "app/output.hpp"
#include "app/progress_bar.hpp"
#include "app/report/run_report.hpp"
#include "app/run/headline.hpp"
#include "app/run/live.hpp"
#include "app/run/live_view.hpp"
#include "app/run/summary.hpp"
#include "app/terminal.hpp"
#include "framework/core/user_folders.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

void write_results(const fs::path& folder, const Plan& plan, const RunResult& result, bool all) {
  write_file(folder / "summary.json", to_json(result).dump(2) + "\n");
  write_file(folder / "graph.yaml", result.graph_yaml);
  if (result.live) write_file(folder / "latencies.csv", latencies_csv(plan, *result.live));
  write_file(folder / "report.html", run_report(result, &plan.graph.scene));
  // Last, because the terminal may have been closed.
  const std::size_t columns = terminal_columns();
  fmt::print("{}", headline_text(result, (folder / "report.html").string(), all, columns));
  if (all && !result.blind) fmt::print("{}", summary_table(result, columns));
}

}  // namespace

RunResult run_into_folder(const Plan& plan, const ResultsFolder& results, RunOptions options, bool all) {
  const fs::path& folder = results.path();
  options.recording = folder / "recording.h5";
  options.keeps_tables = true;
  options.traces = true;
  options.cache_folder = default_cache_folder();
  options.note = tell_note;
  options.before_writing = [&results] { results.clear(); };
  ProgressBar bar;
  options.progress = [&bar](double share, const char* what) {
    bar.draw(share, what);
    return !is_interrupted();
  };
  LiveView view(plan);
  options.live_progress = [&view](const LiveLook& look) {
    view.draw(look);
    return true;
  };
  options.stop_asked = is_interrupted;
  if (plan.graph.clock == Clock::real) ramp_down_on_signals();
  RunResult result = execute(plan, options);
  view.clear();
  bar.clear();
  if (result.failure) tell_note(*result.failure);
  if (result.abandoned) {
    // A step that never came back still runs on its thread: nothing may be cleaned up under it.
    try {
      write_results(folder, plan, result, all);
    } catch (const std::exception& error) {
      tell_note(error.what());
    }
    std::fflush(nullptr);
    std::_Exit(1);
  }
  write_results(folder, plan, result, all);
  return result;
}

int exit_code_of(const RunResult& result) {
  // A live run that is asked to end has ended as it should.
  const bool ended_early = result.interrupted || result.reference_interrupted;
  return result.failure || (ended_early && !result.live) ? 1 : 0;
}

}  // namespace tactor
