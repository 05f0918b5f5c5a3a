// `tactor verify`: a run made again from its results, and compared with them to the byte.
#include "app/run/verify.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "app/interruption.hpp"
#include "app/output.hpp"
#include "app/progress_bar.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/core/user_folders.hpp"
#include "framework/node/registry.hpp"

namespace tactor {

namespace {

int verify(const std::filesystem::path& result) {
  Registry registry(default_node_folders());
  ProgressBar bar;
  VerifyOptions options;
  options.cache_folder = default_cache_folder();
  options.progress = [&bar](double share, const char* what) {
    bar.draw(share, what);
    return !is_interrupted();
  };
  options.stop_asked = is_interrupted;
  options.note = tell_note;
  const Verification found = verify_run(result, registry, options);
  bar.clear();
  fmt::print("{}", verification_text(found));
  return found.results.is_equal() ? 0 : 1;
}

}  // namespace

void add_verify(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand(
      "verify",
      "Make a run in virtual time again from its results, and compare all data sets and metrics to the byte; tells "
      "which files and libraries have changed. Exit codes: 0 equal, 1 different, 2 it cannot be made again");
  const auto result = std::make_shared<std::filesystem::path>();
  verb->add_option("result", *result, "The folder of results of `tactor run`, or its summary.json")
      ->type_name(value_type::results)
      ->required();
  verb->callback([result, &exit_code] { exit_code = verify(*result); });
}

}  // namespace tactor
