#include "app/study/run/planned_cases.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/run/recorded_reference.hpp"
#include "app/run/references.hpp"
#include "app/study/run/worker_pool.hpp"
#include "framework/core/disk_cache.hpp"

namespace tactor {

Obstacle lost_reference(const Ending& ending) {
  return {RunStatus::failed, "the reference run that this run needs: " + ending.text, ending.may_differ};
}

std::string PlannedCases::graph_of(std::size_t c) const {
  return graph_name(cases[c].graph);
}

std::string PlannedCases::name_of(std::size_t run) const {
  const std::size_t c = run / seeds();
  return run_name(graph_of(c), cases[c].configuration, seed_of(run));
}

bool PlannedCases::has_to_warm_up(std::size_t c) const {
  return settings.judge_warm && checks[c].has_to_warm_up && !obstacles[c];
}

Job PlannedCases::job(JobKind kind, std::size_t run, const std::filesystem::path& cache_folder) const {
  const RunCase& c = cases[run / seeds()];
  Job job;
  job.kind = kind;
  job.graph = c.graph;
  job.overrides = c.overrides;
  job.reference = c.reference;
  job.seed = seed_of(run);
  job.libraries = {libraries.begin(), libraries.end()};
  job.repeats = settings.repeats;
  job.warm_up = settings.warm_up;
  job.without_reference = settings.without_reference;
  job.reference_recording = c.reference_recording;
  if (kind == JobKind::plan && !job.reference_recording.empty()) job.seeds = settings.seeds;
  job.judge_whole = !settings.judge_warm;
  if (settings.judge_warm && kind == JobKind::run) job.judge_from = judged[c.group].from;
  job.time_limit_s = settings.run_timeout_s;
  job.cache_folder = cache_folder;
  return job;
}

namespace {

/// What a run is, with the interval that it is judged on and the recording that judges it.
std::string run_content(const PlannedCases& planned, std::size_t run) {
  const std::size_t c = run / planned.seeds();
  const RunCase& one = planned.cases[c];
  const Time from = planned.judged[one.group].from;
  std::string content = planned.checks[c].content;
  if (from != Time{}) content = content_key({content, std::to_string(from.ns)});
  return one.reference_recording.empty() ? content : content_key({content, planned.recording_hash(run)});
}

/// Puts together what the checks of the cases found, in the order of the cases: jobs end in any order, and what is told
/// of them does not depend on it.
void take_checks(PlannedCases& planned, const PlanningHooks& hooks) {
  std::size_t refused = 0;
  RunMetrics metrics;
  std::map<std::string, std::size_t> first_with;  // a reference run
  for (std::size_t c = 0; c < planned.cases.size(); ++c) {
    CaseCheck& check = planned.checks[c];
    planned.libraries.insert(check.libraries.begin(), check.libraries.end());
    planned.code_files.insert(check.code_files.begin(), check.code_files.end());
    planned.codes.insert(check.codes.begin(), check.codes.end());
    planned.inputs.merge(check.inputs);
    planned.loaded.merge(check.loaded);
    for (const std::string& text : check.notes) {
      if (hooks.note) hooks.note(text);
    }
    if (check.result == CheckResult::failed) throw RunError(check.message);
    if (check.result == CheckResult::refused) {
      if (!planned.settings.refused_are_results) throw InputError(check.message);
      planned.obstacles[c] = Obstacle{RunStatus::refused, check.message};
      ++refused;
    }
    metrics.add(check.metrics);
    planned.reference_case.push_back(planned.needs_reference(c) ? first_with.emplace(check.reference, c).first->second
                                                                : c);
    check.libraries = {};
    check.code_files = {};
    check.codes = {};
    check.inputs = {};
    check.loaded = {};
    check.notes = {};
    check.metrics = {};
  }
  if (refused == planned.cases.size() && refused > 0) throw InputError(planned.checks.front().message);
  if (hooks.planned) hooks.planned(metrics);
}

/// To a tenth of a second, so that a table can name it.
Time rounded_up(Time time) {
  constexpr std::int64_t tenth = 100'000'000;
  return Time{(time.ns + tenth - 1) / tenth * tenth};
}

std::string advice_on_warmth() {
  return "; runs are compared only from when all of them are warm: make the runs longer (duration), shorten the "
         "windows that must fill, or set `judge: whole` (--judge whole) to include the cold start";
}

/// A judged interval that is a small rest of the run would say little of it.
void refuse_too_short(const PlannedCases& planned, const std::vector<JudgedFrom>& intervals, std::size_t c) {
  constexpr double least_s = 1;
  const JudgedFrom& judged = intervals[planned.cases[c].group];
  const double duration = planned.checks[c].duration_s;
  if (judged.from == Time{} || duration - judged.from.seconds() >= least_s || planned.obstacles[c]) return;
  throw InputError(
      fmt::format("{}: expected at least {} s of the run after all compared runs are warm, found {:.1f} s: the run "
                  "lasts {:.6g} s, and {} is warm at {:.6g} s{}",
                  case_name(planned.graph_of(c), planned.cases[c].configuration), least_s,
                  std::max(0.0, duration - judged.from.seconds()), duration, judged.last, judged.from.seconds(),
                  advice_on_warmth()));
}

}  // namespace

std::string PlannedCases::recording_hash(std::size_t run) const {
  const RunCase& one = cases[run / seeds()];
  if (one.reference_recording.empty()) return {};
  return file_key(recording_of(one.reference_recording, graph_of(run / seeds()), seed_of(run)));
}

std::vector<RunName> PlannedCases::names() const {
  std::vector<RunName> names;
  names.reserve(runs());
  for (std::size_t run = 0; run < runs(); ++run) {
    const std::size_t c = run / seeds();
    names.push_back({graph_of(c), cases[c].configuration, seed_of(run), run_content(*this, run)});
  }
  return names;
}

RunRecord PlannedCases::hopeless(std::size_t run, const Obstacle& obstacle) const {
  RunRecord record;
  record.number = run;
  record.status = obstacle.status;
  record.message = obstacle.message;
  record.may_differ = obstacle.may_differ;
  record.result.title = checks[run / seeds()].title;
  return record;
}

PlannedCases plan_cases(const std::vector<RunCase>& cases, const CasesSettings& settings, WorkerPool& pool,
                        const std::filesystem::path& cache_folder, unsigned at_once, const PlanningHooks& hooks) {
  PlannedCases planned;
  planned.cases = cases;
  planned.settings = settings;
  planned.checks.resize(cases.size());
  planned.obstacles.resize(cases.size());
  planned.judged.resize(1);
  for (const RunCase& c : cases) planned.judged.resize(std::max(planned.judged.size(), c.group + 1));
  JobBatch batch;
  batch.jobs = cases.size();
  batch.at_once = at_once;
  batch.note = hooks.note;
  batch.job = [&](std::size_t c) { return to_message(planned.job(JobKind::plan, c * planned.seeds(), cache_folder)); };
  batch.done = [&](std::size_t c, const std::string& answer) {
    planned.checks[c] = from_message<CaseCheck>(answer);
    return planned.checks[c].result == CheckResult::planned ||
           (planned.checks[c].result == CheckResult::refused && settings.refused_are_results);
  };
  batch.lost = [&](std::size_t c, const Ending& ending) {
    const std::string name = case_name(planned.graph_of(c), cases[c].configuration);
    if (hooks.note) hooks.note(fmt::format("the planning of {}: {}; the others go on", name, ending.text));
    planned.obstacles[c] = Obstacle{RunStatus::failed, "its planning: " + ending.text, ending.may_differ};
  };
  if (!pool.run(batch)) throw RunError("interrupted while the graphs were read; runs that had finished are kept");
  take_checks(planned, hooks);
  if (!settings.judge_warm) {
    for (std::size_t c = 0; c < cases.size(); ++c) {
      JudgedFrom& judged = planned.judged[cases[c].group];
      judged.cold = judged.cold || planned.checks[c].has_to_warm_up;
    }
  }
  planned.settings.identity.program = program_hash(planned.code_files, planned.codes);
  return planned;
}

Provenance provenance_of(const PlannedCases& planned, const std::filesystem::path& cache_folder) {
  std::vector<InputOfPlan> inputs;
  if (!planned.settings.study_file.empty()) inputs.push_back({"study", planned.settings.study_file});
  for (const std::filesystem::path& file : planned.inputs) inputs.push_back({"", file});
  std::set<std::filesystem::path> code = planned.code_files;
  code.insert(planned.loaded.begin(), planned.loaded.end());
  return provenance_of(inputs, code, cache_folder);
}

std::vector<JudgedFrom> judged_intervals(const PlannedCases& planned, const std::map<std::size_t, Warmth>& warmths) {
  std::vector<JudgedFrom> intervals = planned.judged;
  for (const auto& [run, warmth] : warmths) {
    const std::size_t c = run / planned.seeds();
    if (!warmth.since) {
      throw InputError(fmt::format("{}: node {} is not warm when the run ends, after {:.6g} s: {}{}",
                                   planned.name_of(run), warmth.last, planned.checks[c].duration_s, warmth.when,
                                   advice_on_warmth()));
    }
    if (*warmth.since == Time{}) continue;
    JudgedFrom& judged = intervals[planned.cases[c].group];
    // Of runs that are warm last at the same time, the first is named.
    const Time from = rounded_up(*warmth.since);
    if (from > judged.from) judged = {from, run, fmt::format("{}: {}", planned.name_of(run), warmth.last), false};
  }
  for (std::size_t c = 0; c < planned.cases.size(); ++c) refuse_too_short(planned, intervals, c);
  return intervals;
}

}  // namespace tactor
