#include "app/study/table/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/run/summary.hpp"
#include "app/study/table/warnings.hpp"

namespace tactor {

using Json = nlohmann::ordered_json;

namespace {

/// The seeds of which the row and what it is compared with are done.
std::vector<bool> judged_seeds(const Comparison& comparison, std::size_t row) {
  const CompareRow& mine = comparison.rows[row];
  const CompareRow& other = comparison.rows[mine.against];
  std::vector<bool> both;
  for (std::size_t s = 0; s < comparison.seeds.size(); ++s) {
    both.push_back(mine.status[s] == RunStatus::done && other.status[s] == RunStatus::done);
  }
  return both;
}

/// For these seeds the logarithm of the metric's ratio to that of the row it is compared with; none where a value is
/// not above zero.
std::vector<double> row_logs(const Comparison& comparison, std::size_t row, std::string_view metric,
                             const std::vector<bool>& seeds) {
  const CompareRow& mine = comparison.rows[row];
  const std::span<const double> a = comparison.rows[mine.against].metric(metric, comparison.columns);
  const std::span<const double> b = mine.metric(metric, comparison.columns);
  std::vector<double> logs;
  for (std::size_t s = 0; s < std::min(a.size(), b.size()); ++s) {
    if (!seeds[s]) continue;
    if (!(a[s] > 0 && b[s] > 0)) return {};
    logs.push_back(std::log(b[s] / a[s]));
  }
  return logs;
}

std::vector<double> row_logs(const Comparison& comparison, std::size_t row, std::string_view metric) {
  return row_logs(comparison, row, metric, judged_seeds(comparison, row));
}

/// The seeds that a configuration, and what it is compared with, have in all graphs.
std::vector<bool> judged_seeds_of_all(const Study& study, std::size_t configuration) {
  std::vector<bool> seeds(study.comparison.seeds.size(), true);
  for (std::size_t row = configuration; row < study.comparison.rows.size(); row += study.configurations.size()) {
    const std::vector<bool> mine = judged_seeds(study.comparison, row);
    for (std::size_t s = 0; s < seeds.size(); ++s) seeds[s] = seeds[s] && mine[s];
  }
  return seeds;
}

/// How the ratios exp(logs) of those seeds lie; nothing where there are none.
std::optional<SeedSpread> spread_of_ratios(const Comparison& comparison, const std::vector<bool>& of,
                                           const std::vector<double>& logs) {
  std::vector<std::uint64_t> seeds;
  for (std::size_t s = 0; s < of.size(); ++s) {
    if (of[s]) seeds.push_back(comparison.seeds[s]);
  }
  std::vector<double> ratios;
  for (const double log : logs) ratios.push_back(std::exp(log));
  return seed_spread(seeds, ratios);
}

/// The mean over the graphs for each seed that all of them have; none where a graph has none.
std::vector<double> logs_over_graphs(const Study& study, std::size_t configuration, std::string_view metric) {
  const std::size_t configurations = study.configurations.size();
  const std::vector<bool> seeds = judged_seeds_of_all(study, configuration);
  std::vector<double> sum(static_cast<std::size_t>(std::count(seeds.begin(), seeds.end(), true)), 0.0);
  for (std::size_t row = configuration; row < study.comparison.rows.size(); row += configurations) {
    const std::vector<double> logs = row_logs(study.comparison, row, metric, seeds);
    if (logs.size() != sum.size()) return {};
    for (std::size_t s = 0; s < sum.size(); ++s) sum[s] += logs[s] / static_cast<double>(study.spec.graphs.size());
  }
  return sum;
}

Json to_json(const ErrorRatio& ratio, std::size_t seeds) {
  const auto one = [&](const std::optional<GeometricMean>& m) -> Json {
    if (!m) return nullptr;
    return {{"ratio", m->ratio},
            {"low", number_json(m->low)},
            {"high", number_json(m->high)},
            {"count", m->count},
            {"seeds", seeds}};
  };
  return {{"delivered_rms", one(ratio.delivered)}, {"one_step_rms", one(ratio.one_step)}};
}

Json to_json(const StudyConfiguration& configuration) {
  Json json;
  if (!configuration.method.empty()) json["method"] = configuration.method;
  json["values"] = Json::object();
  for (const auto& [path, value] : configuration.values) json["values"][path] = value;
  return json;
}

}  // namespace

double Study::over_graphs(std::size_t configuration, std::string_view metric) const {
  std::vector<double> means;
  for (std::size_t row = configuration; row < comparison.rows.size(); row += configurations.size()) {
    means.push_back(comparison.rows[row].mean_of(metric, comparison.columns));
  }
  return mean(means);
}

std::string Study::incomplete(std::size_t configuration) const {
  for (std::size_t row = configuration; row < comparison.rows.size(); row += configurations.size()) {
    const CompareRow& mine = comparison.rows[row];
    if (!mine.seeds_text().empty() || !comparison.rows[mine.against].seeds_text().empty()) return " (seeds missing)";
  }
  return {};
}

Study make_study(const StudySpec& spec, Comparison comparison) {
  Study study{spec, study_configurations(spec), std::move(comparison), {}, {}, {}, {}};
  for (std::size_t row = 0; row < study.comparison.rows.size(); ++row) {
    study.ratios.push_back({geometric_mean(row_logs(study.comparison, row, delivered_error)),
                            geometric_mean(row_logs(study.comparison, row, one_step_error))});
  }
  for (std::size_t row = 0; row < study.comparison.rows.size(); ++row) {
    study.spreads.push_back(spread_of_ratios(study.comparison, judged_seeds(study.comparison, row),
                                             row_logs(study.comparison, row, delivered_error)));
  }
  for (std::size_t s = 0; s < study.configurations.size(); ++s) {
    study.spreads_over_graphs.push_back(
        spread_of_ratios(study.comparison, judged_seeds_of_all(study, s), logs_over_graphs(study, s, delivered_error)));
    study.ratios_over_graphs.push_back({geometric_mean(logs_over_graphs(study, s, delivered_error)),
                                        geometric_mean(logs_over_graphs(study, s, one_step_error))});
  }
  return study;
}

TimingNote timing_note(const Study& study) {
  return timing_note(study.comparison, {study.spec.repeats, study.spec.warm_up});
}

Json to_json(const Study& study) {
  Json json;
  json["tactor"] = TACTOR_VERSION;
  json["metric_definitions"] = metric_definitions;
  json["study"] = study.spec.name;
  json["title"] = study.spec.title;
  json["seeds"] = study.comparison.seeds;
  json["baseline"] = Json::object();
  for (const AxisValue& at : study.spec.baseline) json["baseline"][at.axis] = at.value;
  if (!study.spec.reference_recording.empty()) json["reference_recording"] = study.spec.reference_recording;
  json["warnings"] = comparison_warnings(study.comparison);
  json["timing"] = to_json(timing_note(study));
  json["configurations"] = Json::array();
  for (std::size_t s = 0; s < study.configurations.size(); ++s) {
    Json one = to_json(study.configurations[s]);
    one["over_graphs"] = to_json(study.ratios_over_graphs[s], study.comparison.seeds.size());
    if (const auto& spread = study.spreads_over_graphs[s]) one["over_graphs"]["spread"] = to_json(*spread);
    json["configurations"].push_back(std::move(one));
  }
  json["rows"] = Json::array();
  for (std::size_t row = 0; row < study.comparison.rows.size(); ++row) {
    Json one = to_json(study.configuration(row));
    one.update(to_json(study.comparison, study.comparison.rows[row]));
    one["against"]["ratio"] = to_json(study.ratios[row], study.comparison.seeds.size());
    if (const auto& spread = study.spreads[row]) one["against"]["ratio"]["spread"] = to_json(*spread);
    json["rows"].push_back(std::move(one));
  }
  if (!study.comparison.provenance.empty()) json["provenance"] = to_json(study.comparison.provenance);
  return json;
}

}  // namespace tactor
