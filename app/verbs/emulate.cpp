// `tactor emulate`: emulated devices, programs of their own.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "app/verbs/verbs.hpp"
#include "framework/core/check.hpp"
#include "framework/core/installation.hpp"
#include "framework/yaml/diagnostics.hpp"

namespace tactor {

namespace {

/// Becomes the emulator that the first word names, a program beside this one, because it links what the command does
/// not.
void emulate(const std::vector<std::string>& words) {
  constexpr std::string_view prefix = "tactor-emulate-";
  const std::filesystem::path folder = installation_prefix() / "bin";
  std::vector<std::string> kinds;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(prefix)) kinds.push_back(name.substr(prefix.size()));
  }
  std::sort(kinds.begin(), kinds.end());
  if (kinds.empty()) throw InputError("emulate: this build has no emulators; they come with Modbus and USB");
  const std::string kind = words.empty() ? "" : words[0];
  if (std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) {
    throw InputError(fmt::format("emulate: expected one of {}, found {}{}", fmt::join(kinds, ", "),
                                 kind.empty() ? "nothing" : kind, did_you_mean(kind, kinds)));
  }
  const std::string program = folder / (std::string(prefix) + kind);
  std::vector<std::string> copies(words.begin() + 1, words.end());
  std::vector<char*> arguments{const_cast<char*>(program.c_str())};
  for (std::string& word : copies) arguments.push_back(word.data());
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
  verb->callback([verb] { emulate(verb->remaining()); });
}

}  // namespace tactor
