// `tactor device test` and `tactor device calibrate`: the device of a graph.
#include "app/interruption.hpp"
#include "app/machine/devices.hpp"
#include "app/verbs/graph_options.hpp"
#include "app/verbs/option_values.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/engine/plan_nodes.hpp"

namespace tactor {

namespace {

struct DeviceArguments {
  std::filesystem::path graph;
  GraphOptions options;
  std::string node;
  DeviceTrial trial;
};

int test_device(const DeviceArguments& arguments) {
  Registry registry(default_node_folders());
  const GraphSpec spec = load(arguments.graph, registry, arguments.options);
  const NodeSpec& found = hardware_node(spec, arguments.node);
  check_node(spec, found);
  ramp_down_on_signals();
  return try_device(spec, found, arguments.trial, registry, interruption);
}

int calibrate_node(const DeviceArguments& arguments) {
  Registry registry(default_node_folders());
  const GraphSpec spec = load(arguments.graph, registry, arguments.options);
  const NodeSpec& found = hardware_node(spec, arguments.node);
  check_node(spec, found);
  ramp_down_on_signals();
  calibrate_device(found, arguments.trial.yes, interruption);
  return 0;
}

/// What both verbs ask for.
CLI::App* add_device_verb(CLI::App& device, const std::string& name, const std::string& doc,
                          DeviceArguments& arguments) {
  CLI::App* verb = device.add_subcommand(name, doc);
  verb->add_option("graph", arguments.graph, "The graph file (YAML)")->type_name(value_type::graph)->required();
  verb->add_option("--node", arguments.node, "The device, if the graph has several")->type_name(value_type::name);
  verb->add_flag("--yes", arguments.trial.yes, "Do not ask");
  return verb;
}

}  // namespace

void add_device(CLI::App& app, int& exit_code) {
  CLI::App* device = app.add_subcommand("device", "Try or calibrate the device of a graph");
  device->require_subcommand(1);
  const auto trial = std::make_shared<DeviceArguments>();
  CLI::App* verb = add_device_verb(
      *device, "test", "Show the position of the device and, after you confirm, apply small forces", *trial);
  add_number(*verb, "--force", trial->trial.force, {.unit = "N", .min = 0, .max = 5}, "The largest force, in N")
      ->default_str(number_text(trial->trial.force));
  add_number(*verb, "--seconds", trial->trial.seconds, {.unit = "s", .min = 0.1, .max = 60},
             "How long to show the position, and how long to apply each force, in s")
      ->default_str(number_text(trial->trial.seconds));
  trial->options.add_to(*verb, false);
  verb->callback([trial, &exit_code] { exit_code = test_device(*trial); });

  const auto calibration = std::make_shared<DeviceArguments>();
  verb = add_device_verb(*device, "calibrate", "Calibrate it", *calibration);
  calibration->options.add_to(*verb, false);
  verb->callback([calibration, &exit_code] { exit_code = calibrate_node(*calibration); });
}

}  // namespace tactor
