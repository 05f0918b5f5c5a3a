// `tactor mesh check`, `info`, `repair` and `decimate`: a mesh file made ready for a graph.
#include "app/mesh/mesh_command.hpp"
#include "app/verbs/graph_options.hpp"
#include "app/verbs/option_values.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"

namespace tactor {

namespace {

/// What all of them ask for.
CLI::App* add_mesh_verb(CLI::App& mesh, const std::string& name, const std::string& doc, MeshRequest& request) {
  CLI::App* verb = mesh.add_subcommand(name, doc);
  verb->add_option("file", request.file, "The mesh: OFF, OBJ, STL or PLY")->type_name(value_type::mesh)->required();
  verb->add_flag("--json", request.json, "Print JSON, for programs");
  return verb;
}

void add_mesh_length(CLI::App& verb, const std::string& name, MeshLength& length, const std::string& doc) {
  detail::add_text_option(verb, name, "LENGTH", doc, [&length, name](const std::string& text) {
    length.of_diagonal = text.find('%') != std::string::npos;
    length.value = option_number(name, text, {.min = 0});
  });
}

void add_result(CLI::App& verb, ResultsRequest& results) {
  add_results(verb, results, "File for the new mesh; its ending sets the format: .off, .obj, .stl or .ply",
              value_type::file);
  verb.get_option("--out")->required();
}

}  // namespace

void add_mesh(CLI::App& app, int& exit_code) {
  CLI::App* mesh = app.add_subcommand("mesh", "Check a mesh, repair it, or make it coarser");
  mesh->require_subcommand(1);

  const auto check = std::make_shared<MeshCheckRequest>();
  CLI::App* verb = add_mesh_verb(*mesh, "check", "Tell whether a graph accepts a mesh; exit code 2 if not", *check);
  CLI::Option* unit = add_mesh_unit(*verb, check->scale);
  add_number(*verb, "--scale", check->scale, {.min = 0, .above_min = true},
             "The `scale` that the graph gives the body, for any other unit")
      ->excludes(unit);
  verb->callback([check, &exit_code] { exit_code = check_mesh(*check); });

  const auto info = std::make_shared<MeshRequest>();
  verb = add_mesh_verb(*mesh, "info", "Show what a mesh file contains: size, pieces, volume, mass", *info);
  verb->callback([info, &exit_code] { exit_code = show_mesh(*info); });

  const auto repair = std::make_shared<MeshRepairRequest>();
  verb = add_mesh_verb(*mesh, "repair",
                       "Turn a mesh that a graph refuses into a solid, and tell how far the surface moved", *repair);
  add_result(*verb, repair->results);
  add_mesh_length(*verb, "--max-hole", repair->max_hole,
                  "Fill holes up to this width, in the file's unit, or such as `30 %` of the diagonal of the mesh "
                  "(default: 60 %, and no sheets, which are more hole than surface)");
  add_mesh_length(*verb, "--merge", repair->merge,
                  "Merge vertices of open edges that are nearer than this, in the same units (default: 0.01 %)");
  verb->add_flag("--wrap", repair->wrap,
                 "As a last resort, make a new surface around everything: closed and rounded, without inner parts");
  verb->callback([repair, verb, &exit_code] {
    repair->sheets = verb->count("--max-hole") > 0;
    exit_code = repair_mesh(*repair);
  });

  const auto decimate = std::make_shared<MeshDecimateRequest>();
  verb = add_mesh_verb(*mesh, "decimate", "Make a mesh coarser, and tell how far the surface moved", *decimate);
  add_integer(*verb, "--faces", decimate->faces, 4, 10'000'000, "Largest number of faces of the result")->required();
  add_result(*verb, decimate->results);
  verb->callback([decimate, &exit_code] { exit_code = decimate_mesh(*decimate); });
}

}  // namespace tactor
