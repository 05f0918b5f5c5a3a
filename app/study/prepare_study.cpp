#include "app/study/prepare_study.hpp"

#include <fmt/format.h>

#include "app/results_folder.hpp"
#include "app/run/timing.hpp"
#include "app/study/plan/study_plan.hpp"
#include "framework/core/disk_cache.hpp"

namespace tactor {

namespace fs = std::filesystem;

namespace {

/// Everything that the command line lays over a study and that its results depend on.
std::string options_text(const StudyRequest& request, const StudySpec& spec) {
  std::string text = fmt::format("seeds {} from {}; short {}", spec.seeds, spec.first_seed, request.is_short);
  for (const Patch& patch : request.overrides) {
    const fs::path* over = patch.file();
    text += "\n" + (over == nullptr ? patch.place.file : "--over " + fs::absolute(*over).string());
  }
  return content_key({text});
}

}  // namespace

std::vector<std::uint64_t> seeds_from(std::uint64_t first, std::int64_t count) {
  std::vector<std::uint64_t> seeds;
  for (std::int64_t s = 0; s < count; ++s) seeds.push_back(first + static_cast<std::uint64_t>(s));
  return seeds;
}

PreparedStudy prepare_study(const StudyRequest& request) {
  PreparedStudy study;
  StudySpec& spec = study.spec;
  spec = load_study(request.file, request.is_short);
  if (request.seeds) spec.seeds = *request.seeds;
  if (request.first_seed) spec.first_seed = *request.first_seed;
  if (request.repeats) {
    const Repeats repeats = warmed_up(*request.repeats);
    spec.repeats = repeats.count;
    spec.warm_up = repeats.warm_up;
  }
  if (request.judge) spec.judge = *request.judge;
  study.folder = request.out.value_or(fs::path("out") / spec.name);
  refuse_results_of_runs(study.folder);
  study.cases = study_cases(spec, request.overrides);
  CasesSettings& settings = study.settings;
  settings.seeds = seeds_from(spec.first_seed, spec.seeds);
  settings.repeats = spec.repeats;
  settings.warm_up = spec.warm_up;
  settings.without_reference = spec.without_reference;
  settings.judge_warm = spec.judge == JudgedPart::warm;
  settings.refused_are_results = spec.report == StudyReport::stability;
  settings.run_timeout_s = spec.run_timeout_s;
  settings.study_file = fs::absolute(request.file);
  // Of the study's text only what decides how runs are made counts here; what they are, their names and graphs tell.
  settings.identity = {spec.name,
                       content_key({fmt::format("{} repeats, {} warm-up, reference {}{}, judged {}", spec.repeats,
                                                spec.warm_up, spec.without_reference ? "none" : "made",
                                                spec.reference_recording, settings.judge_warm ? "warm" : "whole")}),
                       options_text(request, spec),
                       {}};
  return study;
}

}  // namespace tactor
