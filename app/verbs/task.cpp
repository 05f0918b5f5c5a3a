// `tactor task`: one task of a study on a cluster, which job scripts start.
#include "app/study/cluster/task.hpp"

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>

#include "app/verbs/option_values.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"

namespace tactor {

namespace {
struct TaskArguments {
  std::filesystem::path out;
  std::int64_t submission = 0, index = 0;
};
}  // namespace

void add_task(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand(
      "task", "Run one task of a study on a cluster; the job scripts that tactor study --cluster writes call this");
  // People call it where they look for what went wrong, and the help of the command is for what they do each day.
  verb->group("");
  const auto arguments = std::make_shared<TaskArguments>();
  constexpr std::int64_t most = std::numeric_limits<std::int32_t>::max();
  verb->add_option("out", arguments->out, "The folder of the study's results")
      ->type_name(value_type::folder)
      ->required();
  add_integer(*verb, "submission", arguments->submission, 0, most,
              "Number of the file in OUT/cluster/jobs that lists the tasks")
      ->required();
  add_integer(*verb, "index", arguments->index, 0, most, "Index of the task in that file")->required();
  verb->callback([arguments, &exit_code] {
    exit_code = run_cluster_task(arguments->out, static_cast<std::size_t>(arguments->submission),
                                 static_cast<std::size_t>(arguments->index));
  });
}

}  // namespace tactor
