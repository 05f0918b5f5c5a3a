// `tactor import`: a CSV file as a recording.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "app/verbs/graph_options.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/core/check.hpp"
#include "framework/core/input_file.hpp"
#include "framework/node/registry.hpp"
#include "framework/record/csv.hpp"
#include "framework/record/recorder.hpp"
#include "framework/yaml/diagnostics.hpp"

namespace tactor {

namespace {

struct ImportArguments {
  std::filesystem::path csv;
  std::string type;
  std::string stream;
  std::filesystem::path recording;
};

const MessageType& imported_type(Registry& registry, const std::string& name) {
  load_all_libraries(registry);
  const auto found = registry.message_types().find(name);
  if (found != registry.message_types().end()) return *found->second;
  std::vector<std::string> names;
  for (const auto& [known, type] : registry.message_types()) names.push_back(known);
  throw InputError("there is no message type " + name + did_you_mean(name, names) +
                   "; `tactor schema --messages` describes them all");
}

void import_stream(const ImportArguments& arguments) {
  Registry registry(default_node_folders());
  const MessageType& type = imported_type(registry, arguments.type);
  if (arguments.stream.empty() || arguments.stream.find('/') != std::string::npos) {
    throw InputError("--stream: expected a name such as coupling.force, found \"" + arguments.stream + "\"");
  }
  if (std::filesystem::exists(arguments.recording)) {
    throw InputError(arguments.recording.string() + " is there already; give another name");
  }
  // Read once before anything is written, so that a broken file leaves no recording behind.
  const auto read = [&](const auto& take) {
    within_memory(arguments.csv, [&] { import_csv(arguments.csv, type, take); });
  };
  read([](const Stamp&, const void*) {});
  const std::unique_ptr<Recorder> recorder =
      load_record_library().create(arguments.recording, {.graph = "", .seed = 0, .version = TACTOR_VERSION});
  const std::size_t stream = recorder->add_stream(arguments.stream, type);
  read([&](const Stamp& stamp, const void* value) { recorder->write(stream, stamp, value); });
  recorder->close();
}

}  // namespace

void add_import(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand("import", "Make a recording from a CSV file that `tactor export` printed");
  const auto arguments = std::make_shared<ImportArguments>();
  verb->add_option("csv", arguments->csv, "The CSV file")->type_name(value_type::file)->required();
  verb->add_option("recording", arguments->recording, "The recording to make (HDF5)")
      ->type_name(value_type::recording)
      ->required();
  verb->add_option("--type", arguments->type, "The message type of its rows, for example Wrench")
      ->type_name(value_type::message_type)
      ->required();
  verb->add_option("--stream", arguments->stream, "The name of the stream, for example coupling.force")
      ->type_name(value_type::name)
      ->required();
  verb->callback([arguments, &exit_code] {
    import_stream(*arguments);
    exit_code = 0;
  });
}

}  // namespace tactor
