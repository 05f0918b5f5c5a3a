// The command `tactor`.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/lean/explain.hpp"
#include "app/lean/lean_command.hpp"
#include "app/machine/devices.hpp"
#include "app/machine/doctor.hpp"
#include "app/node_reference.hpp"
#include "app/option_values.hpp"
#include "app/output.hpp"
#include "app/progress_bar.hpp"
#include "app/report/run_report.hpp"
#include "app/results_folder.hpp"
#include "app/run/headline.hpp"
#include "app/run/live.hpp"
#include "app/run/live_view.hpp"
#include "app/run/run.hpp"
#include "app/run/summary.hpp"
#include "app/study/study_command.hpp"
#include "app/study/supervisor.hpp"
#include "app/terminal.hpp"
#include "devices/hardware/profile_files.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/core/user_folders.hpp"
#include "framework/graph/plan.hpp"
#include "framework/graph/study.hpp"
#include "framework/node/registry.hpp"
#include "framework/record/csv.hpp"
#include "framework/record/recorder.hpp"

namespace fs = std::filesystem;
using namespace tactor;

namespace {

// Set by signals, read by several threads.
std::atomic<int> interrupted = 0;

/// Where meshes and profiles of devices that graphs name are looked for after the graph's own folder.
std::vector<fs::path> mesh_folders() {
  std::vector<fs::path> folders;
  if (const char* folder = std::getenv("TACTOR_MESH_PATH")) folders.emplace_back(folder);
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path();
  folders.push_back(program.parent_path() / "meshes");
  folders.push_back(program.parent_path() / "share" / "tactor" / "meshes");
  for (const fs::path& folder : profile_folders()) folders.push_back(folder);
  return folders;
}

// Beyond these nobody means what was typed.
constexpr std::int64_t most_seeds = 10'000;
constexpr std::int64_t most_jobs = 1024;

/// Options that several verbs share.
struct GraphOptions {
  std::vector<fs::path> over;
  std::vector<std::string> set;
  std::optional<std::uint64_t> seed;
  std::optional<double> duration;

  void add_to(CLI::App& verb, bool with_seed) {
    verb.add_option("--over", over, "Lay a file over the graph, for example one of graphs/methods; comes before --set")
        ->expected(1, 16)
        ->allow_extra_args(false);
    verb.add_option("--set", set, "Replace a value: node.parameter=value, with or without unit")
        ->expected(1, 1000)
        ->allow_extra_args(false);
    if (with_seed) add_seed(verb, "--seed", seed, "Seed of everything random (default: the graph's)");
    add_duration(verb, "--duration", duration, "Time of the graph's clock to run, as `3 s` (default: the graph's)");
  }
  [[nodiscard]] Overrides overrides() const { return {set, seed, duration, over}; }
};

void add_results(CLI::App& verb, ResultsRequest& results, const std::string& doc) {
  verb.add_option("--out", results.out, doc);
  verb.add_flag("--overwrite", results.overwrite, "Replace the results that are there");
}

Plan load_plan(const fs::path& graph, Registry& registry, const Overrides& overrides) {
  return make_plan(load_graph(graph, registry, overrides, mesh_folders()));
}

void write_results(const fs::path& folder, const Plan& plan, const RunResult& result, bool all) {
  write_file(folder / "summary.json", to_json(result).dump(2) + "\n");
  write_file(folder / "graph.yaml", result.graph_yaml);
  if (result.live) write_file(folder / "latencies.csv", latencies_csv(plan, *result.live));
  write_file(folder / "report.html", run_report(result));
  // Last, because the terminal may have been closed.
  const std::size_t columns = terminal_columns();
  fmt::print("{}", headline_text(result, (folder / "report.html").string(), all, columns));
  if (all) fmt::print("{}", summary_table(result, columns));
}

/// A live run must not be stopped on the spot, by Ctrl-Z or from behind a terminal, nor end there by Ctrl-\: its device
/// would go on with the last force that it got.
void end_instead_of_stopping() {
  for (const int number : {SIGTSTP, SIGQUIT}) std::signal(number, [](int) { interrupted = 1; });
  for (const int number : {SIGTTOU, SIGTTIN}) std::signal(number, SIG_IGN);
}

struct RunRequest {
  fs::path graph;
  ResultsRequest results;
  bool record_costs = false;
  bool all = false;  // print every figure
};

int run(const RunRequest& request, const GraphOptions& options) {
  Registry registry(default_node_folders());
  const Plan plan = load_plan(request.graph, registry, options.overrides());
  const ResultsFolder results(fs::path("out") / plan.graph.name, request.results);
  results.refuse_to_replace(request.graph);
  const fs::path& folder = results.path();
  RunOptions run_options;
  run_options.recording = folder / "recording.h5";
  run_options.cache_folder = default_cache_folder();
  run_options.note = tell_note;
  run_options.before_writing = [&results] { results.clear(); };
  ProgressBar bar;
  run_options.progress = [&bar](double share, const char* what) {
    bar.draw(share, what);
    return interrupted == 0;
  };
  LiveView view(plan);
  run_options.live_progress = [&view](const LiveStatus& status) {
    view.draw(status);
    return true;
  };
  run_options.stop_asked = [] { return interrupted != 0; };
  if (plan.graph.clock == Clock::real) end_instead_of_stopping();
  if (request.record_costs) {
    if (plan.graph.clock != Clock::real) {
      throw InputError(
          "--record-costs: expected a graph with clock: real, found clock: virtual, whose costs it says itself");
    }
    run_options.replay_folder = folder;
  }
  const RunResult result = execute(plan, run_options);
  view.clear();
  bar.clear();
  if (result.failure) tell_note(*result.failure);
  if (result.abandoned) {
    // A step that never came back still runs on its thread: nothing may be cleaned up under it.
    try {
      write_results(folder, plan, result, request.all);
    } catch (const std::exception& error) {
      tell_note(error.what());
    }
    std::fflush(nullptr);
    std::_Exit(1);
  }
  write_results(folder, plan, result, request.all);
  // A live run that is asked to end has ended as it should.
  const bool ended_early = result.interrupted || result.reference_interrupted;
  return result.failure || (ended_early && !result.live) ? 1 : 0;
}

/// Does the work in a process of its own, and in a new one where a run has crashed that.
int supervised(unsigned threads, const std::function<int(const StudyConsole&)>& work) {
  Supervisor supervisor(threads);
  if (const std::optional<int> code = supervisor.watch()) return *code;
  return work({mesh_folders(), [] { return interrupted != 0; }, &supervisor});
}

int check(const std::vector<fs::path>& graphs, const GraphOptions& options, bool explained) {
  Registry registry(default_node_folders());
  bool bad = false;
  for (const fs::path& graph : graphs) {
    try {
      const Plan plan = make_plan(load_graph(graph, registry, options.overrides(), mesh_folders()));
      for (const std::string& note : check_nodes(plan)) tell_note(note);
      fmt::print("{}: ok\n", graph.string());
      if (explained) fmt::print("{}\n", explain(plan, terminal_columns()));
    } catch (const InputError& error) {
      tell(fmt::format("{}\n", error.what()));
      bad = true;
    }
  }
  return bad ? 2 : 0;
}

int explain_costs(const fs::path& graph, GraphOptions options, std::int64_t repeats, bool json) {
  Registry registry(default_node_folders());
  const GraphSpec spec = load_graph(graph, registry, options.overrides(), mesh_folders());
  if (spec.clock == Clock::real) {
    throw InputError(graph.string() +
                     ": expected clock: virtual, found clock: real; add --set clock=virtual, or see `tactor run`");
  }
  // A short run, unless the user says otherwise.
  const double seconds = options.duration.value_or(std::min(2.0, spec.duration.seconds()));
  const Explanation found =
      explain_measured(spec, seconds, warmed_up(repeats), registry, [] { return interrupted != 0; });
  fmt::print("{}\n", json ? to_json(found).dump(2) : explanation_table(found, terminal_columns()));
  return 0;
}

/// Standard output of `command FILE`, the file holding `input`.
std::string filter(const std::string& command, const std::string& input) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "input";
  write_file(file, input);
  FILE* pipe = popen((command + " '" + file.string() + "'").c_str(), "r");
  if (pipe == nullptr) throw RunError("cannot start " + command);
  std::string out;
  std::array<char, 4096> buffer{};
  for (std::size_t n = 0; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) out.append(buffer.data(), n);
  if (pclose(pipe) != 0) throw RunError(command + " failed (Debian package graphviz)");
  return out;
}

int draw(const fs::path& graph, const GraphOptions& options, const std::string& format) {
  Registry registry(default_node_folders());
  const Plan plan = make_plan(load_graph(graph, registry, options.overrides(), mesh_folders()));
  if (format == "mermaid") fmt::print("{}", to_diagram(plan, DiagramFormat::mermaid));
  if (format == "dot") fmt::print("{}", to_diagram(plan, DiagramFormat::dot));
  if (format == "svg") fmt::print("{}", filter("dot -Tsvg", to_diagram(plan, DiagramFormat::dot)));
  return 0;
}

int list_nodes(const std::string& type, bool markdown) {
  Registry registry(default_node_folders());
  if (!type.empty()) {
    if (const NodeInfo* info = registry.find(type)) {
      fmt::print("{}", node_help(*info));
      return 0;
    }
  }
  registry.load_all();
  if (!type.empty()) {
    std::vector<std::string> names;
    for (const NodeInfo* info : registry.types()) names.push_back(info->type);
    std::string message = "there is no node type " + type + did_you_mean(type, names) + "; `tactor nodes` lists them";
    const std::string prefix = type.substr(0, type.find('.'));
    const auto of_prefix = [&](const std::string& name) { return name.starts_with(prefix + "."); };
    if (prefix != type && std::none_of(names.begin(), names.end(), of_prefix)) {
      message += "; " + registry.why_missing(prefix);
    }
    throw InputError(message);
  }
  fmt::print("{}", markdown ? node_reference_markdown(registry.types()) : node_list(registry.types()));
  return 0;
}

int export_csv_file(const fs::path& recording, const std::string& stream) {
  const std::unique_ptr<RecordingReader> reader = load_record_library().open(recording);
  export_csv(*reader, reader->find(stream), std::cout);
  return 0;
}

int doctor(double seconds, bool json) {
  const Diagnosis diagnosis = diagnose(Duration::from_seconds(seconds));
  const bool coloured = isatty(STDOUT_FILENO) == 1 && std::getenv("NO_COLOR") == nullptr;
  fmt::print("{}\n", json ? to_json(diagnosis).dump(2) : diagnosis_text(diagnosis, coloured));
  return 0;
}

/// Becomes the emulator `kind`, a program of its own beside this one, because it links what the command does not.
int emulate(const std::vector<std::string>& words) {
  constexpr std::string_view prefix = "tactor-emulate-";
  const fs::path folder = fs::read_symlink("/proc/self/exe").parent_path();
  std::vector<std::string> kinds;
  for (const auto& entry : fs::directory_iterator(folder)) {
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

int device(const std::string& what, const fs::path& graph, const GraphOptions& options, const std::string& node,
           const DeviceTrial& trial) {
  Registry registry(default_node_folders());
  const GraphSpec spec = load_graph(graph, registry, options.overrides(), mesh_folders());
  const NodeSpec& found = hardware_node(spec, node);
  check_node(spec, found);
  if (what == "calibrate") {
    calibrate_device(found, trial.yes, interrupted);
    return 0;
  }
  end_instead_of_stopping();
  return try_device(spec, found, trial, registry, interrupted);
}

int main_checked(int argc, char** argv) {
  CLI::App app{"Tactor renders smooth force feedback from slow physics.", "tactor"};
  app.set_version_flag("--version", TACTOR_VERSION);
  app.require_subcommand(1);
  app.footer("Exit codes: 0 done, 1 failed while running, 2 bad input.");
  int result = 0;
  GraphOptions options;

  RunRequest run_request;
  CLI::App* run_verb = app.add_subcommand(
      "run", "Run a graph; writes summary.json, report.html, graph.yaml, the recording, and live latencies.csv");
  run_verb->add_option("graph", run_request.graph, "The graph file (YAML)")->required();
  options.add_to(*run_verb, true);
  add_results(*run_verb, run_request.results,
              "Folder for the results (default: out/NAME, or the first of out/NAME_2, "
              "out/NAME_3, ... that holds none)");
  run_verb->add_flag("--all", run_request.all, "Print every figure, and what each node took");
  run_verb->add_flag("--record-costs", run_request.record_costs,
                     "With clock: real, also write what each step took and replay.yaml, which repeats the run");
  run_verb->callback([&] { result = run(run_request, options); });

  fs::path graph;
  std::vector<fs::path> graphs;
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  CompareRequest comparison;
  ResultsRequest comparison_results;
  comparison.jobs = cores;
  CLI::App* compare_verb = app.add_subcommand("compare", "Run several graphs over several seeds, side by side");
  compare_verb->add_option("graphs", comparison.graphs, "Graph files; the first is what the others are compared with")
      ->required();
  options.add_to(*compare_verb, false);
  add_integer(*compare_verb, "--seeds", comparison.seeds, 1, most_seeds, "Number of seeds")->default_str("6");
  add_seed(*compare_verb, "--first-seed", comparison.first_seed, "The first seed")->default_str("1");
  add_integer(*compare_verb, "--repeats", comparison.repeats, 1, most_repeats,
              "Runs of each seed whose median run time counts; where several, after one that does not")
      ->default_str("1");
  add_integer(*compare_verb, "--jobs", comparison.jobs, 1, most_jobs, "Reference runs at once (default: the cores)");
  add_results(*compare_verb, comparison_results,
              "Folder for the results (default: out/compare, or the first of "
              "out/compare_2, out/compare_3, ... that holds none)");
  compare_verb->callback([&] {
    comparison.overrides = options.overrides();
    comparison.out = results_folder(fs::path("out") / "compare", comparison_results);
    result = supervised(comparison.jobs, [&](const StudyConsole& console) { return run_compare(comparison, console); });
  });

  StudyRequest study;
  study.jobs = cores;
  CLI::App* study_verb = app.add_subcommand(
      "study", "Run graphs by methods by values over seeds, into one table that survives anything, and report on it");
  study_verb->add_option("study", study.file, "The study file (YAML)")->required();
  options.add_to(*study_verb, false);
  add_integer(*study_verb, "--seeds", study.seeds, 1, most_seeds, "Number of seeds (default: the study's)");
  add_seed(*study_verb, "--first-seed", study.first_seed, "The first seed (default: the study's)");
  add_integer(*study_verb, "--repeats", study.repeats, 1, most_repeats,
              "Runs of each seed, for the median of its run time; with one more that does not count where there are "
              "several (default: the study's)");
  add_integer(*study_verb, "--jobs", study.jobs, 1, most_jobs,
              "Runs at once (default: the cores); only run times depend on it");
  study_verb->add_option("--out", study.out, "Folder for the results (default: out/NAME)");
  CLI::Option* resume = study_verb->add_flag("--resume", study.resume, "Go on with the runs that the folder has");
  study_verb->add_flag("--overwrite", study.overwrite, "Begin anew where the folder has runs")->excludes(resume);
  study_verb->add_flag("--short", study.is_short, "Use what the study says under `short`");
  study_verb->callback([&] {
    study.overrides = options.overrides();
    result = supervised(study.jobs, [&](const StudyConsole& console) { return run_study(study, console); });
  });

  bool explained = false;
  CLI::App* check_verb = app.add_subcommand("check", "Check graphs without running them");
  check_verb->add_option("graphs", graphs, "Graph files")->required();
  check_verb->add_flag("--explain", explained, "Show what runs, the queues, and what was left out and why");
  options.add_to(*check_verb, false);
  check_verb->callback([&] { result = check(graphs, options, explained); });

  bool explain_json = false;
  std::int64_t explain_repeats = 3;
  CLI::App* explain_verb =
      app.add_subcommand("explain", "What a scene needs and what was left out, with what each costs, by a short run");
  explain_verb->add_option("graph", graph, "The graph file")->required();
  explain_verb->add_flag("--json", explain_json, "For programs");
  add_integer(*explain_verb, "--repeats", explain_repeats, 1, most_repeats,
              "Runs whose median counts; where several, after one that does not")
      ->default_str("3");
  options.add_to(*explain_verb, true);
  explain_verb->callback([&] { result = explain_costs(graph, options, explain_repeats, explain_json); });

  LeanRequest lean;
  CLI::App* lean_verb = app.add_subcommand(
      "lean", "Leave out and coarsen what an error budget allows; writes the leanest graph and what each step saved");
  lean_verb->add_option("graph", lean.graph, "The graph file")->required();
  add_number(*lean_verb, "--budget", lean.budget, {.unit = "N", .min = 0, .above_min = true},
             "RMS error of the force against the graph's reference run, in N")
      ->required();
  add_number(*lean_verb, "--torque-budget", lean.torque_budget, {.unit = "N m", .min = 0},
             "The same of the torque, in N m (default: the force budget at a lever of 50 mm)");
  lean_verb
      ->add_option("--metric", lean.metric,
                   "The force that is judged: delivered, as displayed; or physics, "
                   "without delay")
      ->capture_default_str()
      ->check(CLI::IsMember({"delivered", "physics"}));
  add_integer(*lean_verb, "--seeds", lean.seeds, 1, 100,
              "Number of seeds, from the graph's; as many others check the result")
      ->default_str("1");
  add_integer(*lean_verb, "--repeats", lean.repeats, 1, most_repeats,
              "Runs of each seed whose median counts; where several, after one that does not")
      ->default_str("3");
  add_results(*lean_verb, lean.results,
              "The graph that is written, the table beside it as .md and .json (default: "
              "out/NAME_lean.yaml, or the first of out/NAME_lean_2.yaml, ... that is not there)");
  options.add_to(*lean_verb, true);
  lean_verb->callback([&] {
    lean.overrides = options.overrides();
    lean.mesh_folders = mesh_folders();
    lean.interrupted = [] { return interrupted != 0; };
    result = run_lean(lean);
  });

  std::string format = "mermaid";
  CLI::App* graph_verb = app.add_subcommand("graph", "Draw a graph");
  graph_verb->add_option("graph", graph, "The graph file")->required();
  graph_verb->add_option("--format", format, "mermaid, dot or svg")
      ->capture_default_str()
      ->check(CLI::IsMember({"mermaid", "dot", "svg"}));
  options.add_to(*graph_verb, false);
  graph_verb->callback([&] { result = draw(graph, options, format); });

  std::string type;
  bool markdown = false;
  CLI::App* nodes_verb = app.add_subcommand("nodes", "List the node types, or tell everything about one");
  nodes_verb->add_option("type", type, "A node type, for example prediction.ar");
  nodes_verb->add_flag("--markdown", markdown, "The whole reference as Markdown");
  nodes_verb->callback([&] { result = list_nodes(type, markdown); });

  CLI::App* schema_verb = app.add_subcommand("schema", "Print the JSON Schema of graph files, for editors");
  schema_verb->callback([&] {
    Registry registry(default_node_folders());
    fmt::print("{}\n", graph_schema(registry));
  });

  fs::path recording;
  std::string stream;
  CLI::App* export_verb = app.add_subcommand("export", "Print a recorded stream as CSV");
  export_verb->add_option("recording", recording, "A recording (HDF5)")->required();
  export_verb->add_option("stream", stream, "The stream, for example device.commanded")->required();
  export_verb->callback([&] { result = export_csv_file(recording, stream); });

  CLI::App* mend_verb = app.add_subcommand("mend", "Let other HDF5 programs open the recording of a killed run");
  mend_verb->add_option("recording", recording, "A recording (HDF5)")->required();
  mend_verb->callback([&] { load_record_library().mend(recording); });

  CLI::App* devices_verb = app.add_subcommand("devices", "List the attached devices that Tactor recognises");
  devices_verb->callback([&] {
    Registry registry(default_node_folders());
    fmt::print("{}", device_list(registry));
  });

  DeviceTrial trial;
  std::string device_node;
  CLI::App* device_verb = app.add_subcommand("device", "Try or calibrate the device of a graph");
  device_verb->require_subcommand(1);
  for (const std::string what : {"test", "calibrate"}) {
    CLI::App* verb = device_verb->add_subcommand(
        what, what == "test" ? "Show where it is, and on confirmation give it small forces" : "Calibrate it");
    verb->add_option("graph", graph, "The graph file (YAML)")->required();
    verb->add_option("--node", device_node, "The device, where the graph has several");
    verb->add_flag("--yes", trial.yes, "Do not ask");
    if (what == "test") {
      add_number(*verb, "--force", trial.force, {.unit = "N", .min = 0, .max = 5}, "The largest force, in N")
          ->default_str(number_text(trial.force));
      add_number(*verb, "--seconds", trial.seconds, {.unit = "s", .min = 0.1, .max = 60},
                 "Of the look at its position, and of each force, in s")
          ->default_str(number_text(trial.seconds));
    }
    options.add_to(*verb, false);
    verb->callback([&, what] { result = device(what, graph, options, device_node, trial); });
  }

  CLI::App* emulate_verb = app.add_subcommand(
      "emulate", "Serve an emulated device: `tactor emulate modbus --help`, and so on for other kinds");
  emulate_verb->set_help_flag();
  emulate_verb->prefix_command();
  emulate_verb->callback([&] { result = emulate(emulate_verb->remaining()); });

  double seconds = 1;
  bool json = false;
  CLI::App* doctor_verb =
      app.add_subcommand("doctor", "Tell what this machine offers to a real-time loop, and how to mend what it lacks");
  add_number(*doctor_verb, "--seconds", seconds, {.unit = "s", .min = 0.1, .max = 3600},
             "Length of each of the loops it tries, in s")
      ->default_str("1");
  doctor_verb->add_flag("--json", json, "For programs");
  doctor_verb->callback([&] { result = doctor(seconds, json); });

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
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGINT, [](int) { interrupted = 1; });
  std::signal(SIGTERM, [](int) { interrupted = 1; });
  // The terminal has been closed; nohup says that this is no reason to end.
  if (std::signal(SIGHUP, [](int) { interrupted = 1; }) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
  // A file that may not grow any more is an error that the run can answer, with a ramp to zero, like a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    return main_checked(argc, argv);
  } catch (const InputError& error) {
    tell(fmt::format("{}\n", error.what()));
    return 2;
  } catch (const std::exception& error) {
    tell_note(error.what());
    return 1;
  }
}
