// `tactor export`: a recorded stream as CSV.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>

#include "app/verbs/verbs.hpp"
#include "framework/record/csv.hpp"
#include "framework/record/recorder.hpp"

namespace tactor {

namespace {
struct ExportArguments {
  std::filesystem::path recording;
  std::string stream;
};
}  // namespace

void add_export(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand("export", "Print a recorded stream as CSV");
  const auto arguments = std::make_shared<ExportArguments>();
  verb->add_option("recording", arguments->recording, "A recording (HDF5)")->required();
  verb->add_option("stream", arguments->stream, "The stream, for example device.commanded")->required();
  verb->callback([arguments, &exit_code] {
    const std::unique_ptr<RecordingReader> reader = load_record_library().open(arguments->recording);
    export_csv(*reader, reader->find(arguments->stream), std::cout);
    exit_code = 0;
  });
}

}  // namespace tactor
