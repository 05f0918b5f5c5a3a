// The verbs of the command, a file each: help, options, and what it does.
#pragma once

namespace CLI {
class App;
}

namespace tactor {

// Each adds its verb to `app`. The verb sets `exit_code`, or throws InputError (exit code 2) or RunError (1).
void add_run(CLI::App& app, int& exit_code);
void add_compare(CLI::App& app, int& exit_code);
void add_demo(CLI::App& app, int& exit_code);
void add_study(CLI::App& app, int& exit_code);
void add_bridge(CLI::App& app, int& exit_code);
void add_bundle(CLI::App& app, int& exit_code);
void add_check(CLI::App& app, int& exit_code);
void add_explain(CLI::App& app, int& exit_code);
void add_lean(CLI::App& app, int& exit_code);
void add_graph(CLI::App& app, int& exit_code);
void add_nodes(CLI::App& app, int& exit_code);
void add_schema(CLI::App& app, int& exit_code);
void add_export(CLI::App& app, int& exit_code);
void add_import(CLI::App& app, int& exit_code);
void add_replay(CLI::App& app, int& exit_code);
void add_verify(CLI::App& app, int& exit_code);
void add_view(CLI::App& app, int& exit_code);
void add_repair(CLI::App& app, int& exit_code);
void add_flight(CLI::App& app, int& exit_code);
void add_mesh(CLI::App& app, int& exit_code);
void add_new(CLI::App& app, int& exit_code);
void add_migrate(CLI::App& app, int& exit_code);
void add_devices(CLI::App& app, int& exit_code);
void add_device(CLI::App& app, int& exit_code);
void add_emulate(CLI::App& app, int& exit_code);
void add_doctor(CLI::App& app, int& exit_code);
void add_reference(CLI::App& app, int& exit_code);
void add_complete(CLI::App& app, int& exit_code);
void add_task(CLI::App& app, int& exit_code);

}  // namespace tactor
