// `tactor new`: the beginning of a project of the user's own.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "app/new/new_graph.hpp"
#include "app/new/new_mujoco.hpp"
#include "app/new/new_project.hpp"
#include "app/verbs/option_values.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/core/check.hpp"
#include "framework/core/file_lookup.hpp"
#include "framework/core/installation.hpp"
#include "framework/core/shell_word.hpp"
#include "framework/yaml/file_finder.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

struct NewArguments {
  std::string name;
  fs::path folder = ".";
  std::string graph = "wall/scene";
};

/// Tells what was written, and what to do next.
void tell_project(const std::vector<fs::path>& files, const std::string& next) {
  for (const fs::path& file : files) fmt::print("{}\n", file.lexically_normal().string());
  fmt::print("\nNext:\n{}", next);
}

CLI::App* add_kind(CLI::App& verb, const std::string& kind, const std::string& help, const std::string& name_help,
                   const std::shared_ptr<NewArguments>& arguments) {
  CLI::App* sub = verb.add_subcommand(kind, help);
  sub->add_option("name", arguments->name, name_help)->type_name(value_type::name)->required();
  sub->add_option("--in", arguments->folder,
                  "The folder in which to make the project's folder (default: the current one)")
      ->type_name(value_type::folder);
  return sub;
}

/// Whether CMAKE_PREFIX_PATH of the environment has this folder.
bool cmake_is_told(const fs::path& prefix) {
  const char* told = std::getenv("CMAKE_PREFIX_PATH");
  std::istringstream folders(told == nullptr ? "" : told);
  for (std::string folder; std::getline(folders, folder, ':');) {
    std::error_code ignored;
    if (fs::equivalent(folder, prefix, ignored)) return true;
  }
  return false;
}

/// The option of cmake that names this installation or the folder of this build, where cmake does not look by itself.
std::string where_cmake_looks() {
  const fs::path prefix = installation_prefix();
  if (prefix == "/usr" || prefix == "/usr/local" || cmake_is_told(prefix)) return {};
  return " -DCMAKE_PREFIX_PATH=" + as_typed(prefix.string());
}

void add_project(CLI::App& verb, ProjectKind kind, const std::string& word, const std::string& help,
                 const std::string& name_help) {
  const auto arguments = std::make_shared<NewArguments>();
  CLI::App* sub = add_kind(verb, word, help, name_help, arguments);
  sub->callback([arguments, kind] {
    const std::vector<fs::path> files = new_project(kind, arguments->name, arguments->folder);
    const std::string folder = as_typed(files.front().parent_path().lexically_normal().string());
    tell_project(files, fmt::format("  cmake -S {0} -B {0}/build{1} && cmake --build {0}/build\n"
                                    "  ctest --test-dir {0}/build --output-on-failure\n"
                                    "  cmake --install {0}/build --prefix ~/.local    # for every graph of yours\n",
                                    folder, where_cmake_looks()));
  });
}

/// `PYTHONPATH=... `, where Python does not find the package by itself.
std::string where_python_looks() {
  const fs::path prefix = installation_prefix();
  std::error_code ignored;
  // A build has a link there; an installation's folder carries the version of Python.
  if (fs::exists(prefix / "python/tactor", ignored))
    return "PYTHONPATH=" + as_typed((prefix / "python").string()) + " ";
  return {};
}

void make_physics(const NewArguments& arguments) {
  const std::vector<fs::path> files = new_project(ProjectKind::physics, arguments.name, arguments.folder);
  const fs::path folder = files.front().parent_path().lexically_normal();
  const std::string python = where_python_looks() + "/usr/bin/python3 ";
  tell_project(files,
               fmt::format("  {0}{1}\n  {0}{1} local\n  {0}{2}\n", python, as_typed((folder / "physics.py").string()),
                           as_typed((folder / "study.py").string())));
}

void make_mujoco(const NewMujocoRequest& request) {
  const std::vector<fs::path> files = new_mujoco(request);
  const fs::path folder = files.front().parent_path().lexically_normal();
  tell_project(files, fmt::format("  tactor run {0}\n  tactor run {0} --over own_physics/rollout\n"
                                  "  tactor study {1} --short\n",
                                  as_typed((folder / (request.name + ".yaml")).string()),
                                  as_typed((folder / "methods.yaml").string())));
}

void add_new_physics(CLI::App& verb) {
  const auto arguments = std::make_shared<NewArguments>();
  const auto request = std::make_shared<NewMujocoRequest>();
  CLI::App* sub = add_kind(verb, "physics",
                           "Physics of your own: a simulation in Python or a model of MuJoCo, its graph and a study of "
                           "methods",
                           "The project's name", arguments);
  CLI::Option* model =
      sub->add_option("--mujoco", request->model,
                      "A model of MuJoCo (MJCF, .xml), which the project reads where it lies; its physics is then "
                      "MuJoCo's, and no Python")
          ->type_name(value_type::file);
  sub->add_option("--tool", request->tool,
                  "The body of the model that the hand moves: a child of the world with a free joint, or with three "
                  "slide joints (default: one called tool, ee, end_effector or gripper, else the only such body)")
      ->type_name(value_type::name)
      ->needs(model);
  sub->callback([arguments, request, model] {
    if (model->count() == 0) return make_physics(*arguments);
    request->name = arguments->name;
    request->folder = arguments->folder;
    make_mujoco(*request);
  });
}

void add_new_graph(CLI::App& parent, int& exit_code) {
  CLI::App* verb = parent.add_subcommand("graph", "Write a complete scene around a mesh, or around a box");
  const auto request = std::make_shared<NewGraphRequest>();
  verb->add_option("name", request->name, "Name of the scene, and of the folder that is made for it")
      ->type_name(value_type::name)
      ->required();
  verb->add_option("--mesh", request->mesh, "The body: OFF, OBJ, STL or PLY; it is copied (default: a box)")
      ->type_name(value_type::mesh);
  verb->add_option("--method", request->method,
                   "How the force is predicted and interpolated: a file of graphs/methods, such as refit, blend, local "
                   "or paper; off holds it")
      ->type_name(value_type::method)
      ->capture_default_str();
  CLI::Option* size = add_number(
      *verb, "--size", request->size, {.unit = "m", .min = 1e-3, .max = 10},
      "The longest side of the body (default: as in the file, if that is 20 mm to 0.5 m when read in m or mm)");
  add_mesh_unit(*verb, request->unit)->excludes(size);
  add_number(*verb, "--young", request->young, {.unit = "Pa", .min = 100, .max = 1e9},
             "Young's modulus of a deformable body, such as `20 kPa`; it is held at the side away from the ball "
             "(default: the body is rigid)");
  verb->add_option("--in", request->folder, "The folder in which to make the scene's folder (default: the current one)")
      ->type_name(value_type::folder);
  verb->add_flag("--overwrite", request->overwrite, "Replace existing files");
  verb->callback([request, &exit_code] {
    make_new_graph(*request);
    exit_code = 0;
  });
}

}  // namespace

void add_new(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand(
      "new",
      "Start a project of your own: a scene around a mesh, a node, a device, a message type, physics or "
      "a study");
  verb->require_subcommand(1);
  add_new_graph(*verb, exit_code);
  const char* library = "The library's name, which comes before the dot in its node types, or both: mylab.smooth";
  add_project(*verb, ProjectKind::node, "node", "A node in C++ (a predictor, as a start), with a graph and a test",
              library);
  add_project(*verb, ProjectKind::device, "device",
              "A device on a line of its own, with a program that emulates the hardware, a graph and a test", library);
  add_project(*verb, ProjectKind::message, "message",
              "A message type of your own, with nodes that send and read it, a graph and a test",
              "The library's name, which comes before the dot in its types: mylab");
  add_new_physics(*verb);
  const auto arguments = std::make_shared<NewArguments>();
  CLI::App* study = add_kind(*verb, "study", "A study of several methods on a graph", "The study's name", arguments);
  study
      ->add_option("--graph", arguments->graph,
                   "The scene to run, without prediction; the methods are laid over it (default: wall/scene)")
      ->type_name(value_type::graph);
  study->callback([arguments] {
    const fs::path graph = named_file(arguments->graph, graph_files);
    // A file of the user's is found from wherever the study lies.
    const bool beside = fs::exists(arguments->graph);
    const std::vector<fs::path> files =
        new_study(arguments->name, beside ? fs::absolute(graph).lexically_normal().string() : arguments->graph,
                  arguments->folder);
    const fs::path folder = files.front().parent_path();
    const std::string file = as_typed((folder / (arguments->name + ".yaml")).lexically_normal().string());
    tell_project(files, fmt::format("  tactor study {0} --short\n  tactor study {0}\n", file));
  });
}

}  // namespace tactor
