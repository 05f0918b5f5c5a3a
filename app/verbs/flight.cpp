// `tactor flight`: what the flight recorder kept of the last minute of a live run.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "app/flight/flight_findings.hpp"
#include "app/flight/flight_page.hpp"
#include "app/flight/flight_source.hpp"
#include "app/flight/flight_text.hpp"
#include "app/output.hpp"
#include "app/terminal.hpp"
#include "app/verbs/option_values.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"

namespace tactor {

namespace {

struct FlightArguments {
  std::optional<std::filesystem::path> file;
  std::optional<std::int64_t> process;
  bool json = false, csv = false;
  std::filesystem::path html, save;
};

void show_flight(const FlightArguments& arguments) {
  const FlightSource source = find_flight(arguments.file, arguments.process);
  const std::vector<FlightFinding> findings = find_faults(source.log, source.is_running);
  if (!arguments.save.empty()) write_file(arguments.save, source.bytes);
  if (!arguments.html.empty()) write_file(arguments.html, flight_page(source, findings));
  if (arguments.json) return write_flight_json(source, findings, std::cout);
  if (arguments.csv) return write_flight_csv(source.log, std::cout);
  fmt::print("{}", flight_text(source, findings, terminal_columns()));
}

}  // namespace

void add_flight(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand(
      "flight", "Show the last minute of a live run, and what went wrong in it, from the file of its flight recorder");
  const auto arguments = std::make_shared<FlightArguments>();
  CLI::Option* file = verb->add_option("file", arguments->file,
                                       "A flight file, or a folder of results with one (default: the newest that an "
                                       "ended process left, else that of a run that goes on)")
                          ->type_name("FILE|RESULT");
  add_integer(*verb, "--of", arguments->process, 1, std::numeric_limits<std::int32_t>::max(),
              "The process whose file is meant, running or not")
      ->excludes(file);
  CLI::Option* json =
      verb->add_flag("--json", arguments->json, "Print JSON lines, for programs: the fault first, then each record");
  verb->add_flag("--csv", arguments->csv, "Print each record as CSV")->excludes(json);
  verb->add_option("--html", arguments->html, "Write a page with curves on one time axis")->type_name(value_type::file);
  verb->add_option("--save", arguments->save, "Keep a copy of the flight file itself")->type_name(value_type::file);
  verb->callback([arguments, &exit_code] {
    show_flight(*arguments);
    exit_code = 0;
  });
}

}  // namespace tactor
