// `tactor export`: a recorded stream as CSV, or a recording as a page that replays it.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>

#include "app/interruption.hpp"
#include "app/output.hpp"
#include "app/progress_bar.hpp"
#include "app/verbs/verbs.hpp"
#include "app/view/recorded_show.hpp"
#include "app/view/saved_page.hpp"
#include "framework/node/registry.hpp"
#include "framework/record/csv.hpp"
#include "framework/record/recorder.hpp"

namespace tactor {

namespace {
struct ExportArguments {
  std::filesystem::path recording;
  std::string stream;
  std::filesystem::path html;
};

void export_page(const ExportArguments& arguments) {
  Registry registry(default_node_folders());
  ProgressBar bar;
  const ShowOptions options{tell_note, [&bar](double share) {
                              bar.draw(share, "replay");
                              return !is_interrupted();
                            }};
  const Show show = show_of_recording(arguments.recording, registry, true, options);
  bar.clear();
  write_file(arguments.html, saved_page(show));
}

}  // namespace

void add_export(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand("export", "Print a recorded stream as CSV, or write a page that replays the run");
  const auto arguments = std::make_shared<ExportArguments>();
  verb->add_option("recording", arguments->recording, "A recording (HDF5)")->required();
  CLI::Option* stream =
      verb->add_option("stream", arguments->stream, "The stream to print, for example device.commanded");
  CLI::Option* html =
      verb->add_option("--html", arguments->html, "Write one HTML file that replays scene and curves without a server");
  html->excludes(stream);
  verb->callback([arguments, &exit_code] {
    exit_code = 0;
    if (!arguments->html.empty()) return export_page(*arguments);
    if (arguments->stream.empty()) {
      throw InputError("expected the stream to print, or --html FILE; `tactor export RECORDING ?` lists the streams");
    }
    const std::unique_ptr<RecordingReader> reader = load_record_library().open(arguments->recording);
    export_csv(*reader, reader->find(arguments->stream), std::cout);
  });
}

}  // namespace tactor
