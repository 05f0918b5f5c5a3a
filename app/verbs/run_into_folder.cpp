#include "app/verbs/run_into_folder.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "app/interruption.hpp"
#include "app/output.hpp"
#include "app/progress_bar.hpp"
#include "app/report/run_report.hpp"
#include "app/run/event_log.hpp"
#include "app/run/headline.hpp"
#include "app/run/live.hpp"
#include "app/run/live_view.hpp"
#include "app/run/summary.hpp"
#include "app/terminal.hpp"
#include "app/verbs/value_types.hpp"
#include "framework/core/user_folders.hpp"
#include "framework/realtime/flight_file.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

void write_results(const fs::path& folder, const Plan& plan, const RunResult& result, const RunTelling& telling) {
  write_file(folder / "summary.json", to_json(result).dump(2) + "\n");
  write_file(folder / "graph.yaml", result.graph_yaml);
  if (result.live) write_file(folder / "latencies.csv", latencies_csv(plan, *result.live));
  write_file(folder / "report.html", run_report(result, &plan.graph));
  // Last, because the terminal may have been closed.
  const bool all = telling.all;
  const std::size_t columns = terminal_columns();
  fmt::print(telling.out(), "{}", headline_text(result, (folder / "report.html").string(), all, columns));
  if (all && !result.blind) fmt::print(telling.out(), "{}", summary_table(result, columns));
}

/// Tells the log of what is thrown, because nothing has run.
RunResult execute_told(const Plan& plan, const RunOptions& options, EventLog& log) {
  try {
    return execute(plan, options);
  } catch (const std::exception& error) {
    log.write({LogLevel::error, EventKind::failed, "", {}, error.what()});
    throw;
  }
}

}  // namespace

void RunTelling::add_to(CLI::App& verb, const std::string& about_all) {
  verb.add_flag("--all", all, about_all);
  verb.add_option(
          "--log-json", log_json,
          "A file that gets a JSON line for each event of the run, at its end: time, level, kind, node, message; "
          "`-`: standard output, where it stands alone then")
      ->type_name(value_type::file);
}

RunResult run_into_folder(const Plan& plan, const ResultsFolder& results, RunOptions options,
                          const RunTelling& telling) {
  EventLog log(telling.log_json);
  const fs::path& folder = results.path();
  options.recording = folder / "recording.h5";
  options.flight = folder / flight_name;
  options.keeps_tables = true;
  options.traces = true;
  options.provenance = true;
  options.cache_folder = default_cache_folder();
  options.note = [&log](const std::string& text) { log.tell({LogLevel::notice, EventKind::note, "", {}, text}); };
  options.before_writing = [&results] { results.clear(); };
  ProgressBar bar;
  options.progress = [&bar](double share, const char* what) {
    bar.draw(share, what);
    return !is_interrupted();
  };
  LiveView view(plan);
  LiveEvents events(plan, log);
  options.live_progress = [&view, &events](const LiveLook& look) {
    view.draw(look);
    events.look(look);
    return true;
  };
  options.stop_asked = is_interrupted;
  if (plan.graph.clock == Clock::real) ramp_down_on_signals();
  RunResult result = execute_told(plan, options, log);
  view.clear();
  bar.clear();
  log.tell(last_event(plan, result));
  if (result.abandoned) {
    // A step that never came back still runs on its thread: nothing may be cleaned up under it.
    try {
      write_results(folder, plan, result, telling);
    } catch (const std::exception& error) {
      tell_failure(error.what());
    }
    std::fflush(nullptr);
    std::_Exit(1);
  }
  write_results(folder, plan, result, telling);
  return result;
}

int exit_code_of(const RunResult& result) {
  // A live run that is asked to end has ended as it should.
  const bool ended_early = result.interrupted || result.reference_interrupted;
  return result.failure || (ended_early && !result.live) ? 1 : 0;
}

}  // namespace tactor
