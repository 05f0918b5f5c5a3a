// `tactor export`: a recorded stream as CSV, or a recording as a page that replays it or as a file for Foxglove.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "app/interruption.hpp"
#include "app/output.hpp"
#include "app/progress_bar.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "app/view/recorded_show.hpp"
#include "app/view/saved_page.hpp"
#include "app/view/view_server.hpp"
#include "framework/node/registry.hpp"
#include "framework/record/csv.hpp"
#include "framework/record/recorder.hpp"

namespace tactor {

namespace {
struct ExportArguments {
  std::filesystem::path recording;
  std::string stream;
  std::filesystem::path html, mcap;
};

void export_show(const ExportArguments& arguments) {
  for (const std::filesystem::path& target : {arguments.html, arguments.mcap}) {
    std::error_code ignored;
    if (std::filesystem::equivalent(arguments.recording, target, ignored)) {
      throw InputError(target.string() + " is the recording itself: choose another file to write to");
    }
  }
  Registry registry(default_node_folders());
  ProgressBar bar;
  const ShowOptions options{tell_note, [&bar](double share) {
                              bar.draw(share, "replay");
                              return !is_interrupted();
                            }};
  const Show show = show_of_recording(arguments.recording, registry, true, options);
  bar.clear();
  if (!arguments.html.empty()) write_file(arguments.html, saved_page(show));
  if (!arguments.mcap.empty()) {
    remove_link(arguments.mcap);
    std::ofstream out(arguments.mcap, std::ios::binary);
    load_view_library().export_mcap(out, show.hello, show.meshes, show.frames);
    out.close();
    if (!out) throw RunError("cannot write " + arguments.mcap.string());
  }
}

}  // namespace

void add_export(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand(
      "export", "Print a recorded stream as CSV, or write a page or a file for Foxglove that replays the run");
  const auto arguments = std::make_shared<ExportArguments>();
  verb->add_option("recording", arguments->recording, "A recording (HDF5)")
      ->type_name(value_type::recording)
      ->required();
  CLI::Option* stream =
      verb->add_option("stream", arguments->stream, "The stream to print, for example device.commanded")
          ->type_name(value_type::name);
  CLI::Option* html =
      verb->add_option("--html", arguments->html, "Write one HTML file that replays scene and curves without a server")
          ->type_name(value_type::file);
  html->excludes(stream);
  verb->add_option("--mcap", arguments->mcap, "Write an MCAP file, for Foxglove, Lichtblick and PlotJuggler")
      ->type_name(value_type::file)
      ->excludes(stream);
  verb->callback([arguments, &exit_code] {
    exit_code = 0;
    if (!arguments->html.empty() || !arguments->mcap.empty()) return export_show(*arguments);
    if (arguments->stream.empty()) {
      throw InputError(
          "expected the stream to print, --html FILE or --mcap FILE; `tactor export RECORDING ?` lists the streams");
    }
    const std::unique_ptr<RecordingReader> reader = load_record_library().open(arguments->recording);
    export_csv(*reader, reader->find(arguments->stream), std::cout);
  });
}

}  // namespace tactor
