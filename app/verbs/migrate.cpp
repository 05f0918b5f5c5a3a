// `tactor migrate`: graphs and studies of an earlier release.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "app/output.hpp"
#include "app/verbs/graph_options.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/core/input_file.hpp"
#include "framework/graph/migrate.hpp"
#include "framework/node/registry.hpp"
#include "framework/yaml/yaml_tree.hpp"

namespace tactor {

namespace {

/// Writes beside the file and renames, so that a full disk leaves the file as it was.
void replace_file(const std::filesystem::path& file, const std::string& text) {
  const std::filesystem::path target = std::filesystem::canonical(file);
  std::filesystem::path beside = target;
  beside += ".migrated";
  std::error_code error;
  try {
    write_file(beside, text);
  } catch (...) {
    std::filesystem::remove(beside, error);
    throw;
  }
  std::filesystem::permissions(beside, std::filesystem::status(target).permissions(), error);
  std::filesystem::rename(beside, target);
}

int migrate_files(const std::vector<std::filesystem::path>& files) {
  Registry registry(default_node_folders());
  load_all_libraries(registry);
  // All are read before the first is written.
  std::vector<Migrated> migrated;
  for (const std::filesystem::path& file : files) {
    Diagnostics diagnostics;
    migrated.push_back(migrate(read_input_file(file, max_yaml_bytes), file.string(), registry.types(), diagnostics));
    diagnostics.throw_if_any();
  }
  for (std::size_t i = 0; i < files.size(); ++i) {
    const std::string name = files[i].string();
    for (const Migration& change : migrated[i].changes) {
      fmt::print("{}:{}: {}\n", name, change.place.line,
                 change.before.empty() ? change.now : fmt::format("{} -> {}", change.before, change.now));
    }
    if (migrated[i].changes.empty()) {
      fmt::print("{}: nothing to change\n", name);
    } else {
      replace_file(files[i], migrated[i].text);
    }
  }
  return 0;
}

}  // namespace

void add_migrate(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand("migrate", "Rewrite graphs and studies of an earlier release, keeping comments");
  const auto files = std::make_shared<std::vector<std::filesystem::path>>();
  verb->add_option("files", *files, "Graph and study files; they are rewritten in place")
      ->type_name(value_type::file)
      ->required();
  verb->callback([files, &exit_code] { exit_code = migrate_files(*files); });
}

}  // namespace tactor
