// `tactor demo`: six ways from slow physics to a smooth force, compared on a scene that is there, then that scene to
// touch.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "app/output.hpp"
#include "app/results_folder.hpp"
#include "app/study/study_command.hpp"
#include "app/verbs/graph_options.hpp"
#include "app/verbs/option_values.hpp"
#include "app/verbs/page_options.hpp"
#include "app/verbs/scene_methods.hpp"
#include "app/verbs/verbs.hpp"
#include "app/verbs/view_scene.hpp"
#include "framework/yaml/file_finder.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {
struct DemoArguments {
  std::string scene;
  std::int64_t seeds = 2;
  ResultsRequest results;
  std::optional<bool> view;
  PageOptions page;
};

/// The first of the demo's scenes whose mesh is there. Packages leave the bunny out, and a build may have no meshes.
std::string demo_scene() {
  for (const char* scene : {"bunny", "duck"}) {
    if (!find_file(std::string(scene) + ".off", {}, mesh_files).file.empty()) return scene;
  }
  throw InputError(
      "demo: expected bunny.off or duck.off among the meshes, found neither; build the target tactor_meshes, or name a "
      "folder that holds them in TACTOR_MESH_PATH");
}

/// True where a person sits at the terminal and may end a view.
bool is_watched() {
  return isatty(STDIN_FILENO) == 1 && isatty(STDOUT_FILENO) == 1;
}

int touch(const DemoArguments& arguments, const std::string& graph) {
  fmt::print("\nThe scene itself: press the mouse on the orange tool and push it into the other body.\n");
  std::fflush(stdout);
  try {
    return view_by_mouse(graph, arguments.page);
  } catch (const InputError& error) {
    if (arguments.view) throw;
    tell_note(error.what());  // this build has no view: the comparison is what the user asked for
    return 0;
  }
}

int demo(const DemoArguments& arguments) {
  const std::string scene = arguments.scene.empty() ? demo_scene() : arguments.scene;
  CompareRequest comparison;
  comparison.graphs = scene_with_methods(scene, {"off", "fixed", "refit", "lowpass", "blend", "local"});
  comparison.seeds = arguments.seeds;
  comparison.jobs = cores();
  comparison.brief = true;
  comparison.out = results_folder(fs::path("out") / "demo", arguments.results);
  fmt::print("Six ways from slow physics to a smooth force, on the scene {}, {} seed{} each: some seconds.\n", scene,
             arguments.seeds, arguments.seeds == 1 ? "" : "s");
  std::fflush(stdout);
  if (const int code = run_compare(comparison); code != 0) return code;
  fmt::print("\nThe curves and all metrics are a page for the browser: xdg-open {}\n",
             (comparison.out / "report.html").string());
  const std::string graph = scene + "/touch";
  if (arguments.view.value_or(is_watched())) return touch(arguments, graph);
  fmt::print("To touch the scene with the mouse: tactor view {}\n", graph);
  return 0;
}

}  // namespace

void add_demo(CLI::App& app, int& exit_code) {
  CLI::App* verb =
      app.add_subcommand("demo", "Compare six methods on a shipped scene, then touch that scene in the browser");
  const auto arguments = std::make_shared<DemoArguments>();
  choose_from(
      verb->add_option("--scene", arguments->scene, "The scene (default: bunny, where its mesh is there; else duck)"),
      {"bunny", "duck"});
  add_integer(*verb, "--seeds", arguments->seeds, 1, most_seeds, "Number of seeds")->default_str("2");
  add_results(
      *verb, arguments->results,
      "Folder for the results (default: out/demo, or the first of out/demo_2, out/demo_3, ... that holds none)");
  verb->add_flag(
      "--view,!--no-view", [arguments](std::int64_t given) { arguments->view = given > 0; },
      "Show the scene in the browser afterwards, or do not (default: where somebody sits at the terminal)");
  arguments->page.add_to(*verb);
  verb->callback([arguments, &exit_code] { exit_code = demo(*arguments); });
}

}  // namespace tactor
