// `tactor reference`: the pages of docs/reference that come from declarations, and manual pages.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <memory>
#include <string>

#include "app/output.hpp"
#include "app/verbs/graph_options.hpp"
#include "app/verbs/reference/pages.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"

namespace tactor {

namespace {

struct ReferenceArguments {
  std::filesystem::path folder;
  bool manual = false;
};

/// Today, or what SOURCE_DATE_EPOCH says, by which whoever builds packages makes the same bytes again.
std::string date_of_pages() {
  const char* epoch = std::getenv("SOURCE_DATE_EPOCH");
  const std::time_t seconds = epoch != nullptr ? std::strtoll(epoch, nullptr, 10) : std::time(nullptr);
  std::tm day{};
  gmtime_r(&seconds, &day);
  return fmt::format("{:04}-{:02}-{:02}", day.tm_year + 1900, day.tm_mon + 1, day.tm_mday);
}

Pages reference_pages(const VerbInfo& command) {
  Registry registry(default_node_folders());
  load_all_libraries(registry);
  ReferenceSource source{registry, {}, command};
  for (const NodeInfo* info : registry.types()) source.types.insert(info->type);
  Pages pages;
  add_node_pages(source, pages);
  add_metric_page(source, pages);
  add_message_page(source, pages);
  add_verb_pages(source, pages);
  add_key_page(source, pages);
  return pages;
}

int write_reference(const ReferenceArguments& arguments, const VerbInfo& command) {
  const Pages pages =
      arguments.manual ? manual_pages(command, TACTOR_VERSION, date_of_pages()) : reference_pages(command);
  for (const auto& [name, text] : pages) {
    const std::filesystem::path file = arguments.folder / name;
    make_folder(file.parent_path());
    write_file(file, text);
  }
  return 0;
}

}  // namespace

void add_reference(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand(
      "reference", "Write the reference of nodes, verbs, keys, messages and metrics as Markdown, or manual pages");
  verb->group("");
  const auto arguments = std::make_shared<ReferenceArguments>();
  verb->add_option("folder", arguments->folder, "Where the pages go; those of the same names are replaced")
      ->type_name(value_type::folder)
      ->required();
  verb->add_flag("--man", arguments->manual, "Write manual pages instead: tactor.1, and one for each verb");
  verb->callback([&app, arguments, &exit_code] { exit_code = write_reference(*arguments, describe_verbs(app)); });
}

}  // namespace tactor
