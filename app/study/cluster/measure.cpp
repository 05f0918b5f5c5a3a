#include "app/study/cluster/measure.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "app/study/run/worker_pool.hpp"

namespace tactor {

namespace {

constexpr std::size_t most_tried = 16;          // runs
constexpr std::size_t most_tried_of_group = 4;  // runs of one graph
constexpr double guess_s = 1;                   // where nothing is known
constexpr double least_s = 1e-3;                // that a unit counts for, so that a chunk has an end

/// So many of `all` places, spread evenly, with the first and the last.
std::vector<std::size_t> spread_places(std::size_t all, std::size_t count) {
  std::vector<std::size_t> places;
  count = std::min(count, all);
  for (std::size_t i = 0; i < count; ++i) places.push_back(count == 1 ? 0 : i * (all - 1) / (count - 1));
  return places;
}

/// Cases to be tried, by group.
std::map<std::size_t, std::vector<std::size_t>> tried_cases(const PlannedCases& planned) {
  std::map<std::size_t, std::vector<std::size_t>> groups;
  for (std::size_t c = 0; c < planned.cases.size(); ++c) {
    if (!planned.obstacles[c]) groups[planned.cases[c].group].push_back(c);
  }
  std::vector<std::size_t> names;
  for (const auto& [group, cases] : groups) names.push_back(group);
  std::map<std::size_t, std::vector<std::size_t>> tried;
  const std::size_t each =
      std::clamp<std::size_t>(most_tried / std::max<std::size_t>(1, names.size()), 1, most_tried_of_group);
  for (const std::size_t place : spread_places(names.size(), most_tried)) {
    const std::vector<std::size_t>& cases = groups[names[place]];
    for (const std::size_t at : spread_places(cases.size(), each)) tried[names[place]].push_back(cases[at]);
  }
  return tried;
}

double distance(std::size_t a, std::size_t b) {
  return a < b ? static_cast<double>(b - a) : static_cast<double>(a - b);
}

/// The costs of all cases by those of some.
std::vector<double> all_costs(const PlannedCases& planned, const std::map<std::size_t, double>& known) {
  double mean = known.empty() ? guess_s : 0;
  for (const auto& [c, cost] : known) mean += cost / static_cast<double>(known.size());
  std::map<std::size_t, std::vector<std::size_t>> by_group;
  for (const auto& [c, cost] : known) by_group[planned.cases[c].group].push_back(c);
  std::vector<double> costs;
  for (std::size_t c = 0; c < planned.cases.size(); ++c) {
    const auto group = by_group.find(planned.cases[c].group);
    double cost = mean;
    if (group != by_group.end()) {
      cost = known.at(*std::min_element(group->second.begin(), group->second.end(),
                                        [&](std::size_t a, std::size_t b) { return distance(a, c) < distance(b, c); }));
    }
    costs.push_back(std::max(least_s, cost));
  }
  return costs;
}

}  // namespace

Measured measure_costs(const PlannedCases& planned, WorkerPool& pool, const std::filesystem::path& cache_folder,
                       unsigned at_once, const std::function<void(double share, const std::string& what)>& progress,
                       const std::function<void(const std::string& note)>& note) {
  std::vector<std::size_t> cases;
  for (const auto& [group, tried] : tried_cases(planned)) cases.insert(cases.end(), tried.begin(), tried.end());
  std::map<std::size_t, double> references, warm, runs;
  std::set<std::string> depends;
  const auto make = [&](JobKind kind, std::vector<std::size_t> of, std::map<std::size_t, double>& costs,
                        const std::string& what) {
    JobBatch batch;
    batch.jobs = of.size();
    batch.at_once = at_once;
    batch.time_limit_s = planned.settings.run_timeout_s;
    batch.note = note;
    batch.job = [&](std::size_t i) {
      progress(static_cast<double>(i) / static_cast<double>(of.size()), what);
      return to_message(planned.job(kind, of[i] * planned.seeds(), cache_folder));
    };
    batch.done = [&](std::size_t i, const std::string& answer) {
      JobCost cost;
      bool counts = true;  // what failed says little of how long others take
      if (kind == JobKind::run) {
        const auto run = from_message<RunAnswer>(answer);
        cost = run.cost;
        counts = run.record && run.record->status == RunStatus::done;
      } else if (kind == JobKind::warm_up) {
        const auto warm_up = from_message<WarmUp>(answer);
        cost = warm_up.cost;
        counts = warm_up.failure.empty();
      } else {
        cost = from_message<JobCost>(answer);
      }
      depends.insert(cost.depends_on_processor.begin(), cost.depends_on_processor.end());
      if (counts) costs[of[i]] = cost.cpu_s;
      return true;
    };
    batch.lost = [](std::size_t, const Ending&) {};  // it says so again when it runs
    if (!pool.run(batch)) throw RunError("interrupted while the first runs were measured; nothing was submitted");
  };
  std::vector<std::size_t> with_reference, warmed;
  for (const std::size_t c : cases) {
    if (planned.needs_reference(c)) with_reference.push_back(planned.reference_case[c]);
    if (planned.has_to_warm_up(c)) warmed.push_back(c);
  }
  std::sort(with_reference.begin(), with_reference.end());
  with_reference.erase(std::unique(with_reference.begin(), with_reference.end()), with_reference.end());
  make(JobKind::reference, with_reference, references, "reference runs");
  make(JobKind::warm_up, warmed, warm, "when runs are warm");
  make(JobKind::run, cases, runs, "a few runs");
  if (runs.empty() && note) note("all trial runs failed, so the expected time of a task is a guess");
  return {{all_costs(planned, warm), all_costs(planned, references), all_costs(planned, runs)},
          {depends.begin(), depends.end()}};
}

}  // namespace tactor
