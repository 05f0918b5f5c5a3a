// `tactor study`: graphs by methods by values over seeds.
#include "app/study/spec/study_spec.hpp"
#include "app/study/study_command.hpp"
#include "app/verbs/graph_options.hpp"
#include "app/verbs/option_values.hpp"
#include "app/verbs/verbs.hpp"
#include "framework/yaml/file_finder.hpp"

namespace tactor {

namespace {
struct StudyArguments {
  StudyRequest study;
  GraphOptions options;
};
}  // namespace

void add_study(CLI::App& app, int& exit_code) {
  CLI::App* verb = app.add_subcommand(
      "study", "Run graphs by methods by values over seeds, into one table that survives anything, and report on it");
  const auto arguments = std::make_shared<StudyArguments>();
  StudyRequest& study = arguments->study;
  study.jobs = cores();
  verb->add_option("study", study.file, "The study file (YAML)")->required();
  arguments->options.add_to(*verb, false);
  add_integer(*verb, "--seeds", study.seeds, 1, most_seeds, "Number of seeds (default: the study's)");
  add_seed(*verb, "--first-seed", study.first_seed, "The first seed (default: the study's)");
  add_integer(*verb, "--repeats", study.repeats, 1, most_repeats,
              "Runs of each seed, for the median of its run time; with one more that does not count where there are "
              "several (default: the study's)");
  add_integer(*verb, "--jobs", study.jobs, 1, most_jobs,
              "Runs at once (default: the cores); only run times depend on it");
  verb->add_option("--out", study.out, "Folder for the results (default: out/NAME)");
  CLI::Option* resume = verb->add_flag("--resume", study.resume, "Go on with the runs that the folder has");
  verb->add_flag("--overwrite", study.overwrite, "Begin anew where the folder has runs")->excludes(resume);
  verb->add_flag("--short", study.is_short, "Use what the study says under `short`");
  verb->add_option_function<std::string>(
          "--judge",
          [&study](const std::string& part) { study.judge = part == "whole" ? JudgedPart::whole : JudgedPart::warm; },
          "Which part of the runs is judged: from when all that is compared is warm, or the whole (default: the "
          "study's)")
      ->check(CLI::IsMember({"warm", "whole"}));
  verb->callback([arguments, &exit_code] {
    StudyRequest& made = arguments->study;
    made.file = named_file(made.file, study_files);
    made.overrides = arguments->options.overrides;
    exit_code = run_study(made);
  });
}

}  // namespace tactor
