// `tactor repair`: the recording of a killed run for other programs.
#include <CLI/CLI.hpp>
#include <filesystem>

#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/record/recorder.hpp"

namespace tactor {

void add_repair(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand("repair", "Let other HDF5 programs open the recording of a killed run");
  const auto recording = std::make_shared<std::filesystem::path>();
  verb->add_option("recording", *recording, "A recording (HDF5)")->type_name(value_type::recording)->required();
  verb->callback([recording, &exit_code] {
    load_record_library().repair(*recording);
    exit_code = 0;
  });
}

}  // namespace tactor
