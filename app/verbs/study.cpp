// `tactor study`: graphs by methods by values over seeds, here or on a cluster.
#include "app/study/cluster/cluster_command.hpp"
#include "app/study/cluster/cluster_system.hpp"
#include "app/study/cluster/earlier_study.hpp"
#include "app/study/spec/study_spec.hpp"
#include "app/study/study_command.hpp"
#include "app/verbs/graph_options.hpp"
#include "app/verbs/option_values.hpp"
#include "app/verbs/value_types.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/yaml/file_finder.hpp"

namespace tactor {

namespace {

struct StudyArguments {
  StudyRequest study;
  GraphOptions options;
  ClusterRequest cluster;
  bool is_for_cluster = false;
  bool status = false, cancel = false;
};

void add_cluster_options(CLI::App& verb, StudyArguments& arguments) {
  ClusterRequest& cluster = arguments.cluster;
  CLI::Option* system =
      verb.add_option_function<std::string>(
              "--cluster",
              [&arguments](const std::string& name) {
                arguments.cluster.system = named_file(name, cluster_files);
                arguments.is_for_cluster = true;
              },
              "Run the study on a cluster: slurm, local (processes of this machine), or a cluster file")
          ->type_name("slurm|local|FILE")
          ->group("Cluster");
  const auto about_cluster = [](CLI::Option* option) { return option->group("Cluster"); };
  about_cluster(verb.add_option("--partition", cluster.partition, "Partition, or queue")->type_name(value_type::name));
  about_cluster(verb.add_option("--account", cluster.account, "Account to charge")->type_name(value_type::name));
  about_cluster(add_duration(verb, "--time", cluster.time_s,
                             "Time limit of each task (default: five times the expected time, at least 30 min)"));
  about_cluster(verb.add_option("--sbatch-option", cluster.options,
                                "A further option for the submit command, such as --constraint=NAME; may be repeated")
                    ->type_name("WORD")
                    ->allow_extra_args(false));
  about_cluster(add_duration(verb, "--chunk", cluster.chunk_s, "Intended run time of a task (default: 120 s)"))
      ->needs(system);
  about_cluster(verb.add_flag("--exclusive", cluster.exclusive,
                              "Ask for exclusive nodes for each task, for undisturbed run times"))
      ->needs(system);
  about_cluster(verb.add_flag("--wait", cluster.wait,
                              "Wait until the study is done, with a progress bar; then print the tables"));
  CLI::Option* status = about_cluster(
      verb.add_flag("--status", arguments.status, "Show the progress of the study in this folder, or of this name"));
  about_cluster(verb.add_flag("--cancel", arguments.cancel, "End the study's tasks; finished results are kept"))
      ->excludes(status)
      ->excludes(system);
  status->excludes(system);
}

/// The folder of a study that was handed to a cluster: what is named, or where the results of that study go.
std::optional<std::filesystem::path> handed_over(const StudyRequest& study) {
  if (is_cluster_study(study.file)) return study.file;
  const std::filesystem::path out = study.out.value_or(std::filesystem::path("out") / study.file.stem());
  return is_cluster_study(out) ? std::optional(out) : std::nullopt;
}

/// Whether an option changes which runs a study has.
bool changes_study(const StudyRequest& study) {
  return study.seeds || study.first_seed || study.repeats || study.judge || study.is_short || !study.overrides.empty();
}

/// What the command line asks of a study that has been handed to a cluster: `out`, its folder.
int run_handed_over(const std::filesystem::path& out, StudyArguments& made) {
  StudyRequest& study = made.study;
  if (made.status) return show_cluster_status(out);
  if (made.cancel) return cancel_cluster_study(out);
  if (study.resume) {
    study.overrides = made.options.overrides;
    if (!is_cluster_study(study.file)) {
      study.file = named_file(study.file, study_files);
    } else if (changes_study(study)) {
      throw InputError(
          study.file.string() +
          ": --resume: expected no option that changes the study; to start anew, name the study file with --overwrite");
    }
    return resume_cluster_study(out, study, made.cluster);
  }
  if (made.cluster.wait) return wait_for_cluster_study(out);
  throw InputError(out.string() +
                   ": expected --status, --wait, --cancel or --resume, since this is a study on a cluster; to start "
                   "anew, name the study file with --overwrite");
}

int run(StudyArguments& made) {
  StudyRequest& study = made.study;
  const std::optional<std::filesystem::path> out = handed_over(study);
  const ClusterRequest& cluster = made.cluster;
  const bool asks = made.status || made.cancel || cluster.wait;
  if (is_cluster_study(study.file) && (made.is_for_cluster || study.overwrite)) {
    throw InputError(study.file.string() +
                     ": expected a study file beside --cluster and --overwrite, found the folder of "
                     "a study on a cluster");
  }
  if (out && !made.is_for_cluster && (asks || study.resume || is_cluster_study(study.file))) {
    return run_handed_over(*out, made);
  }
  if (!made.is_for_cluster &&
      (asks || cluster.partition || cluster.account || cluster.time_s || !cluster.options.empty())) {
    throw InputError(
        study.file.string() +
        ": --status, --cancel, --wait and the options of jobs: expected --cluster, or a study that was handed "
        "to a cluster");
  }
  study.file = named_file(study.file, study_files);
  study.overrides = made.options.overrides;
  if (!made.is_for_cluster) {
    // Its table would be that of two studies.
    if (out) {
      refuse_study_folder(*out, study.overwrite);
      study.before_runs = [folder = *out] { clear_study_folder(folder); };
    }
    return run_study(study);
  }
  if (study.resume) {
    throw InputError("--resume: expected no --cluster, because the study in that folder already has one");
  }
  return run_study_on_cluster(study, made.cluster);
}

}  // namespace

void add_study(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand(
      "study",
      "Run every combination of graphs, methods and values over seeds into one crash-proof table, and report on it");
  const auto arguments = std::make_shared<StudyArguments>();
  StudyRequest& study = arguments->study;
  study.jobs = cores();
  verb->add_option("study", study.file, "The study file (YAML), or the folder of a study on a cluster")
      ->type_name(value_type::study)
      ->required();
  arguments->options.add_to(*verb, false);
  add_integer(*verb, "--seeds", study.seeds, 1, most_seeds, "Number of seeds (default: the study's)");
  add_seed(*verb, "--first-seed", study.first_seed, "The first seed (default: the study's)");
  add_integer(*verb, "--repeats", study.repeats, 1, most_repeats,
              "Repeats of each seed; the median run time counts. With several, one more run before them does not count "
              "(default: the study's)");
  add_integer(*verb, "--jobs", study.jobs, 1, most_jobs,
              "Number of runs at once (default: the number of cores); on a cluster, of the runs measured first. Only "
              "run times depend on it");
  verb->add_option("--out", study.out, "Folder for the results (default: out/NAME)")->type_name(value_type::folder);
  CLI::Option* resume = verb->add_flag("--resume", study.resume, "Continue with the runs already in the folder");
  verb->add_flag("--overwrite", study.overwrite, "Start anew even if the folder has runs")->excludes(resume);
  verb->add_flag("--short", study.is_short, "Use the settings of the study's key `short`");
  choose_from(
      verb->add_option_function<std::string>(
          "--judge",
          [&study](const std::string& part) { study.judge = part == "whole" ? JudgedPart::whole : JudgedPart::warm; },
          "Which part of the runs the metrics cover: warm, from when every compared run is warm, or whole (default: "
          "the study's)"),
      {"warm", "whole"});
  add_cluster_options(*verb, *arguments);
  verb->callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace tactor
