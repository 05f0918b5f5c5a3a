// `tactor export`: a recorded stream as CSV, a recording as a page that replays it or as a file for Foxglove, or a
// figure of a report for a paper.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>

#include "app/interruption.hpp"
#include "app/output.hpp"
#include "app/progress_bar.hpp"
#include "app/report/figure.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "app/view/recorded_show.hpp"
#include "app/view/saved_page.hpp"
#include "app/view/view_server.hpp"
#include "framework/core/input_file.hpp"
#include "framework/core/text.hpp"
#include "framework/node/registry.hpp"
#include "framework/record/csv.hpp"
#include "framework/record/recorder.hpp"

namespace tactor {

namespace {
struct ExportArguments {
  std::filesystem::path source;  // a recording; for a figure, a folder of results or its page
  std::string stream;
  std::filesystem::path html, mcap;
  std::string figure;
  std::filesystem::path figure_file;
  int columns = 1;
};

std::string names_of(const std::vector<NamedFigure>& figures) {
  std::string names;
  for (const NamedFigure& figure : figures) names += "\n  " + figure.name;
  return names;
}

const Drawing& figure_named(const std::vector<NamedFigure>& figures, const std::string& name,
                            const std::filesystem::path& page) {
  const auto found =
      std::find_if(figures.begin(), figures.end(), [&](const auto& figure) { return figure.name == name; });
  if (found != figures.end()) return found->drawing;
  throw InputError(
      fmt::format("--figure: expected one of the figures of {}, found '{}'{}", page.string(), name, names_of(figures)));
}

/// The figures of that name, or of several names with commas between them: their charts under each other.
Drawing drawing_named(const std::vector<NamedFigure>& figures, const std::string& names,
                      const std::filesystem::path& page) {
  const bool is_one =
      std::any_of(figures.begin(), figures.end(), [&](const auto& figure) { return figure.name == names; });
  if (is_one || names.find(',') == std::string::npos) return figure_named(figures, names, page);
  std::vector<Chart> charts;
  std::istringstream list(names);
  for (std::string name; std::getline(list, name, ',');) {
    const auto* more = std::get_if<std::vector<Chart>>(&figure_named(figures, std::string(trimmed(name)), page));
    if (more == nullptr) throw InputError("--figure: expected charts alone in a list, found the map '" + name + "'");
    charts.insert(charts.end(), more->begin(), more->end());
  }
  return charts;
}

/// What a file of that suffix holds.
std::string figure_bytes(const Drawing& drawing, const std::filesystem::path& file, PaperWidth width) {
  const std::string suffix = file.extension().string();
  if (suffix == ".csv") return figure_csv(drawing);
  for (const auto& [its, format] :
       {std::pair{".svg", PictureFormat::svg}, {".pdf", PictureFormat::pdf}, {".png", PictureFormat::png}}) {
    if (suffix == its) return draw_for_paper(drawing, format, width);
  }
  throw InputError(
      fmt::format("--to: expected a file that ends in .svg, .pdf, .png or .csv, found '{}'", file.string()));
}

/// A comparison of 40 methods has a twentieth of it.
constexpr std::uint64_t most_page_bytes = std::uint64_t{1} << 30U;

void export_figure(const ExportArguments& arguments) {
  std::filesystem::path page = arguments.source;
  if (std::filesystem::is_directory(page)) page /= "report.html";
  const std::vector<NamedFigure> figures = figures_of(read_input_file(page, most_page_bytes));
  if (figures.empty()) throw InputError(page.string() + ": expected a report of Tactor with figures, found none");
  if (arguments.figure == "?") {
    fmt::print("{}\n", names_of(figures).substr(1));
    return;
  }
  const Drawing drawing = drawing_named(figures, arguments.figure, page);
  if (arguments.figure_file.empty())
    throw InputError("--figure: expected --to FILE, which ends in .svg, .pdf, .png or .csv");
  const std::string bytes = figure_bytes(drawing, arguments.figure_file,
                                         arguments.columns == 1 ? PaperWidth::one_column : PaperWidth::two_columns);
  if (bytes.empty()) throw RunError("the figure could not be drawn");
  write_file(arguments.figure_file, bytes);
}

void export_show(const ExportArguments& arguments) {
  for (const std::filesystem::path& target : {arguments.html, arguments.mcap}) {
    std::error_code ignored;
    if (std::filesystem::equivalent(arguments.source, target, ignored)) {
      throw InputError(target.string() + " is the recording itself: choose another file to write to");
    }
  }
  Registry registry(default_node_folders());
  ProgressBar bar;
  const ShowOptions options{tell_note, [&bar](double share) {
                              bar.draw(share, "replay");
                              return !is_interrupted();
                            }};
  const Show show = show_of_recording(arguments.source, registry, true, options);
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
      "export",
      "Print a recorded stream as CSV, write a page or a file for Foxglove that replays the run, or a report's "
      "figure for a paper");
  const auto arguments = std::make_shared<ExportArguments>();
  verb->add_option("source", arguments->source,
                   "A recording (HDF5); for --figure a folder of results, or its report.html")
      ->type_name("RECORDING|RESULT")
      ->required();
  CLI::Option* stream =
      verb->add_option("stream", arguments->stream, "The stream to print, for example device.commanded")
          ->type_name(value_type::name);
  CLI::Option* html =
      verb->add_option("--html", arguments->html, "Write one HTML file that replays scene and curves without a server")
          ->type_name(value_type::file);
  html->excludes(stream);
  CLI::Option* mcap =
      verb->add_option("--mcap", arguments->mcap, "Write an MCAP file, for Foxglove, Lichtblick and PlotJuggler")
          ->type_name(value_type::file)
          ->excludes(stream);
  CLI::Option* figure =
      verb->add_option("--figure", arguments->figure,
                       "The figure to write, as the report names it; several with commas between them stand under each "
                       "other, and `?` lists them")
          ->type_name(value_type::name)
          ->excludes(stream)
          ->excludes(html)
          ->excludes(mcap);
  verb->add_option("--to", arguments->figure_file, "The file of the figure, which ends in .svg, .pdf, .png or .csv")
      ->type_name(value_type::file)
      ->needs(figure);
  verb->add_option("--columns", arguments->columns, "The width of the figure in columns of a paper: 84 mm or 174 mm")
      ->check(CLI::IsMember({1, 2}))
      ->needs(figure);
  verb->callback([arguments, &exit_code] {
    exit_code = 0;
    if (!arguments->figure.empty()) return export_figure(*arguments);
    if (!arguments->html.empty() || !arguments->mcap.empty()) return export_show(*arguments);
    if (arguments->stream.empty()) {
      throw InputError(
          "expected the stream to print, --html FILE, --mcap FILE or --figure NAME; `tactor export RECORDING ?` lists "
          "the "
          "streams, and `tactor export RESULT --figure ?` the figures");
    }
    const std::unique_ptr<RecordingReader> reader = load_record_library().open(arguments->source);
    export_csv(*reader, reader->find(arguments->stream), std::cout);
  });
}

}  // namespace tactor
