// `tactor emulate`: emulated devices, programs of their own.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "app/verbs/verbs.hpp"
#include "framework/core/check.hpp"
#include "framework/core/installation.hpp"
#include "framework/yaml/diagnostics.hpp"

namespace tactor {

namespace {

constexpr std::string_view program_prefix = "tactor-emulate-";

std::filesystem::path program_folder() {
  return installation_prefix() / "bin";
}

/// The kinds of devices that there are emulators of.
std::vector<std::string> emulators() {
  std::vector<std::string> kinds;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(program_folder(), ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(program_prefix)) kinds.push_back(name.substr(program_prefix.size()));
  }
  std::sort(kinds.begin(), kinds.end());
  return kinds;
}

/// Becomes the emulator of that kind, a program beside this one, because it links what the command does
/// not.
void emulate(const std::string& kind, std::vector<std::string> words) {
  const std::vector<std::string> kinds = emulators();
  if (kinds.empty()) throw InputError("emulate: this build has no emulators; they come with Modbus and USB");
  if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) {
    throw InputError(fmt::format("emulate: expected one of {}, found {}{}", fmt::join(kinds, ", "),
                                 kind.empty() ? "nothing" : kind, did_you_mean(kind, kinds)));
  }
  const std::string program = program_folder() / (std::string(program_prefix) + kind);
  std::vector<char*> arguments{const_cast<char*>(program.c_str())};
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execv(program.c_str(), arguments.data());
  throw RunError("cannot start " + program);
}

}  // namespace

void add_emulate(CLI::App& app, int& /*exit_code*/) {
  CLI::App* verb = app.add_subcommand(
      "emulate", "Serve an emulated device: `tactor emulate modbus --help`, and so on for other kinds");
  verb->set_help_flag();
  verb->prefix_command();
  const auto kind = std::make_shared<std::string>();
  const std::vector<std::string> kinds = emulators();
  verb->add_option("kind", *kind, "Which device; the words behind it go to its emulator")
      ->type_name(kinds.empty() ? "KIND" : fmt::format("{}", fmt::join(kinds, "|")));
  verb->callback([verb, kind] { emulate(*kind, verb->remaining()); });
}

}  // namespace tactor
