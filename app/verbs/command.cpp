#include "app/verbs/command.hpp"

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "app/run/build_info.hpp"
#include "app/verbs/option_values.hpp"
#include "app/verbs/verb_info.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/core/check.hpp"

namespace tactor {

int run_command(int argc, char** argv) {
  CLI::App app{"Tactor renders smooth force feedback from slow physics.", "tactor"};
  app.set_version_flag("--version", version_text, "Print version and commit, and exit");
  app.require_subcommand(1);
  app.footer("Exit codes: " + std::string(exit_codes));
  int exit_code = 0;
  for (const auto add :
       {add_demo,   add_new,    add_run,    add_compare,   add_study,   add_check,   add_explain, add_lean,
        add_graph,  add_nodes,  add_schema, add_export,    add_import,  add_view,    add_bridge,  add_replay,
        add_verify, add_repair, add_flight, add_mesh,      add_migrate, add_devices, add_device,  add_emulate,
        add_doctor, add_bundle, add_task,   add_reference, add_complete}) {
    add(app, exit_code);
  }
  refuse_unknown_verb(app, std::vector<std::string>(argv + 1, argv + argc));
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& done) {
    return app.exit(done);
  } catch (const CLI::ExtrasError&) {
    throw InputError(unexpected_words(app));
  } catch (const CLI::ParseError& error) {
    app.exit(error);
    return 2;
  }
  return exit_code;
}

}  // namespace tactor
