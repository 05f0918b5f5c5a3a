// `tactor devices`: what is attached.
#include "app/machine/devices.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "app/verbs/graph_options.hpp"
#include "app/verbs/verbs.hpp"

namespace tactor {

void add_devices(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand("devices", "List the attached devices that Tactor recognises");
  verb->callback([&exit_code] {
    Registry registry(default_node_folders());
    load_all_libraries(registry);
    fmt::print("{}", device_list(registry));
    exit_code = 0;
  });
}

}  // namespace tactor
