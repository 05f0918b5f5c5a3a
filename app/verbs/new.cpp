// `tactor new`: what one begins with. A subcommand for each kind of thing.
#include <CLI/CLI.hpp>
#include <memory>

#include "app/new/new_graph.hpp"
#include "app/verbs/option_values.hpp"
#include "app/verbs/verbs.hpp"

namespace tactor {

namespace {

void add_new_graph(CLI::App& parent, int& exit_code) {
  CLI::App* verb = parent.add_subcommand("graph", "Write a complete scene around a mesh, or around a box");
  const auto request = std::make_shared<NewGraphRequest>();
  verb->add_option("name", request->name, "Of the scene, and of the folder that is made for it")->required();
  verb->add_option("--mesh", request->mesh, "The body: OFF, OBJ, STL or PLY; it is copied (default: a box)");
  verb->add_option("--method", request->method,
                   "How the force is predicted and interpolated: a file of graphs/methods, such as refit, blend, local "
                   "or paper; off holds it")
      ->capture_default_str();
  add_number(*verb, "--size", request->size, {.unit = "m", .min = 1e-3, .max = 10},
             "The longest side of the body (default: as the file says, where that is 20 mm to 0.5 m in m or mm)");
  verb->add_option("--in", request->folder, "The folder in which the scene's folder is made (default: this one)");
  verb->add_flag("--overwrite", request->overwrite, "Replace files that are there");
  verb->callback([request, &exit_code] {
    make_new_graph(*request);
    exit_code = 0;
  });
}

}  // namespace

void add_new(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand("new", "Write something to begin with");
  verb->require_subcommand(1);
  add_new_graph(*verb, exit_code);
}

}  // namespace tactor
