#include "app/lean/lean_command.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

#include "app/lean/lean.hpp"
#include "app/output.hpp"
#include "app/terminal.hpp"
#include "framework/core/user_folders.hpp"
#include "framework/graph/compose.hpp"
#include "framework/graph/plan.hpp"
#include "framework/graph/texts.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// The text of the lean graph: what it changes of the files it came from, or all of it where that does not say it.
std::string lean_graph_text(const Lean& lean, const LeanRequest& request, Registry& registry, const fs::path& file) {
  const auto plan_of = [&](const fs::path& graph, const Overrides& overrides) {
    return make_plan(load_graph(graph, registry, overrides));
  };
  GraphSpec wanted = lean.graph;
  wanted.title = lean.original.title + (lean.original.title.empty() ? "lean" : ", lean");
  // A file can extend files alone.
  Overrides files = request.overrides;
  std::erase_if(files, [](const Patch& patch) { return patch.file() == nullptr; });
  const GraphSpec base = plan_of(request.graph, files).graph;
  wanted.duration = base.duration;
  std::vector<std::string> extended{fs::proximate(request.graph, file.parent_path()).string()};
  for (const Patch& patch : files) {
    extended.push_back(fs::proximate(find_over(*patch.file(), request.graph).file, file.parent_path()).string());
  }
  std::string overlay = to_overlay(base, wanted, wanted.title, extended);
  write_file(file, overlay);
  try {
    if (to_yaml(plan_of(file, {}).graph) == to_yaml(wanted)) return overlay;
  } catch (const InputError&) {
    // What --set says may be more than an overlay can.
  }
  return to_yaml(wanted);
}

}  // namespace

int run_lean(const LeanRequest& request) {
  Registry registry(default_node_folders());
  const GraphSpec original = make_plan(load_graph(request.graph, registry, request.overrides)).graph;
  const fs::path file =
      fs::absolute(results_file(fs::path("out") / (original.name + "_lean.yaml"), {".md", ".json"}, request.results));
  if (file.extension() != ".yaml") throw InputError("--out " + file.string() + ": expected a name that ends in .yaml");
  make_folder(file.parent_path());
  const FileLock lock(file.parent_path() / ("." + file.filename().string() + ".lock"),
                      "--out " + file.string() + ": expected a file");
  LeanOptions options;
  options.budget = request.budget;
  // A force at a lever of 50 mm.
  options.torque_budget = request.torque_budget.value_or(0.05 * request.budget);
  options.seeds.clear();
  options.check_seeds.clear();
  for (std::uint64_t i = 0; i < request.seeds; ++i) {
    options.seeds.push_back(original.seed + i);
    options.check_seeds.push_back(original.seed + 1000 + i);
  }
  options.measure.metric = request.metric == "physics" ? LeanMetric::physics : LeanMetric::delivered;
  options.measure.repeats = warmed_up(request.repeats);
  options.measure.cache_folder = default_cache_folder();
  std::set<std::string> told;
  options.measure.note = [&told](const std::string& note) {
    if (told.insert(note).second) tell_note(note);
  };
  options.measure.interrupted = request.interrupted;
  options.progress = [](const std::string& what) { tell(fmt::format("  {}\n", what)); };
  const Lean result = make_lean(original, registry, options);
  write_file(file, lean_graph_text(result, request, registry, file));
  fs::path table = file;
  write_file(table.replace_extension(".md"), lean_markdown(result));
  fs::path json = file;
  write_file(json.replace_extension(".json"), to_json(result).dump(2) + "\n");
  fmt::print("{}\n  {}\n  {}\n", lean_table(result, terminal_columns()), file.string(), table.string());
  return 0;
}

}  // namespace tactor
