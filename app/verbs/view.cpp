// `tactor view`: a scene in the browser, to be looked at and touched.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>

#include "app/confirmation.hpp"
#include "app/interruption.hpp"
#include "app/output.hpp"
#include "app/progress_bar.hpp"
#include "app/verbs/graph_options.hpp"
#include "app/verbs/option_values.hpp"
#include "app/verbs/page_options.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "app/verbs/view_scene.hpp"
#include "app/view/picture.hpp"
#include "app/view/recorded_show.hpp"
#include "app/view/serve_show.hpp"
#include "app/view/view_graph.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace {

namespace fs = std::filesystem;

struct ViewArguments {
  fs::path shown;
  GraphOptions options;
  std::string device = "mouse";
  PageOptions page;
  bool no_reference = false;
  bool no_dead_man = false;
  fs::path recording;
  fs::path picture;
  std::optional<double> time;
  bool whole_page = false;
};

/// A view goes on until somebody ends it, and physics takes the time that the graph says it takes.
Overrides for_a_view(const Overrides& given) {
  Overrides overrides{option_patch("tactor view", "clock", "real"),
                      option_patch("tactor view", "live.impose_cost", "true"),
                      option_patch("tactor view", "duration", "3600 s")};
  overrides.insert(overrides.end(), given.begin(), given.end());
  return overrides;
}

bool is_recording(const fs::path& file) {
  return file.extension() == ".h5";
}

ShowOptions show_options(ProgressBar& bar, const ViewOptions& options) {
  return {options.note, [&bar](double share) {
            bar.draw(share, "run");
            return !is_interrupted();
          }};
}

int view_recording(const ViewArguments& arguments, Registry& registry, const ViewOptions& options) {
  if (!arguments.options.overrides.empty() || options.own_device || options.recording) {
    throw InputError(
        "a recording is shown unchanged: --set, --over, --duration, --seed, --device and --record are for graphs");
  }
  if (options.ports.foxglove) {
    throw InputError("--foxglove is for live runs; `tactor export RECORDING --mcap FILE` gives Foxglove a recording");
  }
  ProgressBar bar;
  const ShowOptions making = show_options(bar, options);
  Show show = show_of_recording(arguments.shown, registry, options.reference, making);
  bar.clear();
  serve_show(
      std::move(show), options.ports.page, [&options](const std::string& url) { options.opened(url, {}); },
      options.stop_asked);
  return 0;
}

/// The frames and the length of an animation.
constexpr int animation_frames = 30;
constexpr double animation_seconds = 6;

int draw_picture(const ViewArguments& arguments, Registry& registry, const ViewOptions& options) {
  ProgressBar bar;
  const ShowOptions making = show_options(bar, options);
  const Show show =
      is_recording(arguments.shown)
          ? show_of_recording(arguments.shown, registry, options.reference, making)
          : show_of_graph(load(arguments.shown, registry, arguments.options), registry, options.reference, making);
  bar.clear();
  PictureOptions drawing;
  drawing.time = arguments.time;
  drawing.whole_page = arguments.whole_page;
  const std::string ending = arguments.picture.extension().string();
  if (ending == ".png") {
    if (arguments.whole_page) {
      drawing.width = 1280;
      drawing.height = 900;
    }
    write_picture(show, arguments.picture, drawing);
  } else if (ending == ".svg") {
    drawing.width = 480;
    drawing.height = 360;
    write_animation(show, arguments.picture, animation_frames, animation_seconds, drawing);
  } else {
    throw InputError("--picture: expected a name that ends in .png, or in .svg for an animation, found " +
                     arguments.picture.string());
  }
  return 0;
}

int view_live(ViewArguments arguments, Registry& registry, const ViewOptions& options) {
  arguments.options.overrides = for_a_view(arguments.options.overrides);
  ramp_down_on_signals();
  const std::optional<std::string> failure =
      view_graph(load(arguments.shown, registry, arguments.options), registry, options);
  if (failure) tell_note(*failure);
  return failure ? 1 : 0;
}

int view(const ViewArguments& arguments) {
  Registry registry(default_node_folders());
  ViewOptions options;
  options.ports = arguments.page.ports;
  options.own_device = arguments.device == "graph";
  options.reference = !arguments.no_reference;
  if (!arguments.recording.empty()) options.recording = arguments.recording;
  options.without_dead_man = ask_without_dead_man(arguments.no_dead_man);
  options.note = tell_note;
  options.stop_asked = is_interrupted;
  options.opened = [&arguments](const std::string& url, const std::string& foxglove) {
    show_page(arguments.page, url, foxglove);
  };
  if (!arguments.picture.empty()) return draw_picture(arguments, registry, options);
  return is_recording(arguments.shown) ? view_recording(arguments, registry, options)
                                       : view_live(arguments, registry, options);
}

}  // namespace

int view_by_mouse(const fs::path& graph, const PageOptions& page) {
  ViewArguments arguments;
  arguments.shown = graph;
  arguments.page = page;
  return view(arguments);
}

void add_view(CLI::App& app, int& exit_code) {
  CLI::App* verb =
      app.add_subcommand("view", "Show a graph live in the browser, with its tool on the mouse, or replay a recording");
  const auto arguments = std::make_shared<ViewArguments>();
  verb->add_option("shown", arguments->shown, "A graph file (YAML) or a recording (HDF5)")
      ->type_name("GRAPH|RECORDING")
      ->required();
  arguments->options.add_to(*verb, true);
  choose_from(
      verb->add_option("--device", arguments->device, "What moves the tool: the mouse, or the device of the graph")
          ->capture_default_str(),
      {"mouse", "graph"});
  arguments->page.add_to(*verb);
  verb->add_flag("--no-reference", arguments->no_reference,
                 "Run no reference beside it. The reference gives error and delay, and uses a core if one is free");
  add_no_dead_man(*verb, arguments->no_dead_man);
  verb->add_option("--record", arguments->recording, "Record the run into this file (HDF5), for a replay")
      ->type_name(value_type::recording);
  CLI::Option* picture =
      verb->add_option("--picture", arguments->picture,
                       "Write a picture of the run to this file instead: .png, or .svg for an animation")
          ->type_name(value_type::file);
  for (const char* option : {"--port", "--foxglove", "--no-open", "--record"})
    picture->excludes(verb->get_option(option));
  verb->add_option("--time", arguments->time, "The time of the picture, s (default: when the force is largest)")
      ->type_name("SECONDS")
      ->needs(picture);
  verb->add_flag("--page", arguments->whole_page, "Draw the whole page instead of the scene only")->needs(picture);
  verb->callback([arguments, &exit_code] { exit_code = view(*arguments); });
}

}  // namespace tactor
