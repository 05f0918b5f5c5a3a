#include "app/study/table/comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/run/run_metrics.hpp"
#include "app/run/summary.hpp"
#include "app/study/table/warnings.hpp"
#include "framework/graph/text_table.hpp"

namespace tactor {

using Json = nlohmann::ordered_json;

namespace {

/// What tables show where nobody asks for anything else; the labels without units.
const std::vector<Column>& error_columns() {
  static const std::vector<Column> columns{
      {"delivered.force.rms_error_N", "RMS error"},
      {"delivered.force.max_error_N", "max error"},
      {"delivered.force.delay_ms", "delay"},
      {"delivered.force.rms_d1_N_per_ms", "RMS 1st diff"},
      {"delivered.force.rms_d2_N_per_ms2", "RMS 2nd diff"},
      {"delivered.force.max_step_N", "largest step"},
      {"delivered.force.error_above_30hz_N", "error above 30 Hz"},
      {"delivered.force.share_beyond_jnd", "beyond JND"},
      {"delivered.force.share_beyond_weber", "beyond Weber curve"},
      {"delivered.force.vibration_above_threshold_dB", "vibration above threshold"},
      {"delivered.force.vibration_above_threshold_Hz", "its band"},
      {"delivered.force.worst_vibration_above_threshold_dB", "the same at worst"},
      {"delivered.force.overshoot_after_loss_N", "pull-in after loss"},
      {"delivered.torque.rms_error_Nm", "torque RMS error"},
      {"one_step.force.rms_error_N", "one-step RMS"},
      {"one_step.force.rms_error_hold_N", "one-step RMS of hold"},
      {"judged.from_s", "judged from"},
      {"warm_from_s", "warm from"},
      {"cold_start.delivered.force.rms_error_N", "RMS error of the cold start"},
      {"reference.force.rms_N", "reference RMS"},
      {"physics.force.rms_error_N", "physics RMS error"},
      {"physics.rate_hz_median", "physics"},
      {"reference.rate_hz", "reference"},
      {"contacts.median", "contacts"},
      {"contacts.max", "most contacts"},
      {"fallbacks", "fallbacks"},
      {"drops", "drops"},
  };
  return columns;
}

/// CPU time in us of all steps of the method, for each message of the physics force, or for each tick of the device.
double method_us(const RunResult& run, bool per_tick) {
  double total_s = 0;
  double ticks = 0;
  if (run.nodes.empty()) return std::nan("");
  for (const NodeCost& node : run.nodes) {
    if (is_method(node.role)) total_s += node.total_s;
    if (node.role == Role::device) ticks += static_cast<double>(node.steps);
  }
  return 1e6 * total_s / (per_tick ? ticks : run.metric("physics.steps"));
}

/// A metric by its dotted name, or one of the run's own.
double value_of(const RunResult& run, const std::string& name) {
  if (name == "cpu_ms_per_s") return 1e3 * run.cpu_s / run.duration_s;
  if (name == "method_us_per_result") return method_us(run, false);
  if (name == "method_us_per_tick") return method_us(run, true);
  constexpr std::string_view cost = "cost_us.";
  if (name.starts_with(cost)) {
    for (const NodeCost& node : run.nodes) {
      if (name == step_time_metric(node.node).name) return node.median_us;
    }
    return std::nan("");
  }
  return run.metric(name);
}

/// The values of every column; a column that nothing reports is no column.
void fill_columns(Comparison& comparison) {
  for (CompareRow& row : comparison.rows) {
    for (const Column& column : comparison.columns) {
      std::vector<double> values;
      for (const RunResult& run : row.runs) values.push_back(value_of(run, column.metric));
      row.values.push_back(std::move(values));
    }
  }
  for (std::size_t c = comparison.columns.size(); c-- > 0;) {
    bool any = false;
    for (const CompareRow& row : comparison.rows) {
      any = any || std::any_of(row.values[c].begin(), row.values[c].end(), [](double v) { return std::isfinite(v); });
    }
    if (any) continue;
    comparison.columns.erase(comparison.columns.begin() + static_cast<std::ptrdiff_t>(c));
    for (CompareRow& row : comparison.rows) row.values.erase(row.values.begin() + static_cast<std::ptrdiff_t>(c));
  }
}

/// The indices of the seeds of which both are done.
std::vector<std::size_t> seeds_of_both(const CompareRow& a, const CompareRow& b) {
  std::vector<std::size_t> seeds;
  for (std::size_t s = 0; s < a.status.size(); ++s) {
    if (a.status[s] == RunStatus::done && b.status[s] == RunStatus::done) seeds.push_back(s);
  }
  return seeds;
}

/// Whether two or more runs of the row are done and report the same values of all metrics.
bool has_identical_seeds(const CompareRow& row) {
  const RunResult* first = nullptr;
  bool several = false;
  for (std::size_t s = 0; s < row.runs.size(); ++s) {
    if (row.status[s] != RunStatus::done) continue;
    if (first == nullptr) {
      first = &row.runs[s];
    } else if (!first_difference(*first, row.runs[s]).empty()) {
      return false;
    } else {
      several = true;
    }
  }
  return several && !first->metrics.empty();
}

/// Why the first run that has no truth finer than it has none; empty where all have one.
std::string why_too_coarse(const CompareRow& row) {
  for (const RunResult& run : row.runs) {
    if (!run.reference.too_coarse.empty()) return run.reference.too_coarse;
  }
  return {};
}

void judge(Comparison& comparison) {
  for (CompareRow& row : comparison.rows) {
    row.identical_seeds = has_identical_seeds(row);
    row.too_coarse = why_too_coarse(row);
  }
  for (std::size_t i = 0; i < comparison.rows.size(); ++i) {
    CompareRow& row = comparison.rows[i];
    if (!is_compared(comparison, i)) continue;
    const CompareRow& first = comparison.rows[row.against];
    // Both are judged over the seeds that both have.
    const std::vector<std::size_t> seeds = seeds_of_both(row, first);
    const auto pooled = [&](const CompareRow& of) {
      std::vector<double> all;
      for (const std::size_t s : seeds) {
        if (const Series* errors = of.runs[s].curve("one_step_error")) {
          all.insert(all.end(), errors->value.begin(), errors->value.end());
        }
      }
      return all;
    };
    const auto metrics = [&](const CompareRow& of, std::string_view name) {
      std::vector<double> all;
      for (const std::size_t s : seeds) all.push_back(of.runs[s].metric(name));
      return all;
    };
    const bool is_chance = !row.identical_seeds || !first.identical_seeds;
    if (is_chance) row.one_step_anova = one_way_anova(pooled(first), pooled(row));
    for (const auto& [target, name] :
         {std::pair{&row.one_step, "one_step.force.rms_error_N"}, {&row.delivered, "delivered.force.rms_error_N"}}) {
      const std::vector<double> a = metrics(first, name);
      const std::vector<double> b = metrics(row, name);
      if (std::isfinite(mean(a)) && std::isfinite(mean(b))) *target = paired_difference(a, b);
    }
  }
}

}  // namespace

std::span<const double> CompareRow::metric(std::string_view name, const std::vector<Column>& columns) const {
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (columns[c].metric == name) return values[c];
  }
  return {};
}

std::vector<double> CompareRow::done(std::span<const double> by_seed) const {
  std::vector<double> out;
  for (std::size_t s = 0; s < by_seed.size(); ++s) {
    if (status[s] == RunStatus::done) out.push_back(by_seed[s]);
  }
  return out;
}

double CompareRow::mean_of(std::string_view name, const std::vector<Column>& columns) const {
  return mean(done(metric(name, columns)));
}

bool CompareRow::never_touches() const {
  bool any = false;
  for (std::size_t s = 0; s < runs.size(); ++s) {
    if (status[s] != RunStatus::done) continue;
    // Not a number where nothing looks for contacts.
    if (!(runs[s].metric("collision.touching_queries") == 0)) return false;
    any = true;
  }
  return any;
}

bool CompareRow::has_reference(const std::vector<Column>& columns) const {
  const std::span<const double> errors = metric("delivered.force.rms_error_N", columns);
  for (std::size_t s = 0; s < status.size(); ++s) {
    if (status[s] != RunStatus::done) continue;
    if (std::isfinite(runs[s].metric("reference.rate_hz")) || (!errors.empty() && std::isfinite(errors[s])))
      return true;
  }
  return false;
}

std::size_t CompareRow::seeds_done() const {
  return static_cast<std::size_t>(std::count(status.begin(), status.end(), RunStatus::done));
}

std::string CompareRow::seeds_text() const {
  const std::size_t there = seeds_done();
  if (there == status.size()) return {};
  return of_seeds(there, status.size());
}

std::string CompareRow::full_name() const {
  return case_name(graph, configuration);
}

std::string CompareRow::with_seeds(const std::string& name) const {
  const std::string seeds = seeds_text();
  return seeds.empty() ? name : name + " (" + seeds + ")";
}

std::string CompareRow::name() const {
  return with_seeds(full_name());
}

std::optional<std::size_t> Comparison::column(std::string_view metric) const {
  const auto found =
      std::find_if(columns.begin(), columns.end(), [&](const Column& one) { return one.metric == metric; });
  if (found == columns.end()) return std::nullopt;
  return static_cast<std::size_t>(found - columns.begin());
}

const MetricInfo* Comparison::info(std::string_view metric) const {
  const auto found = declared.find(metric);
  return found == declared.end() ? nullptr : &found->second;
}

std::string with_unit(const Comparison& comparison, const std::string& text, std::string_view metric) {
  const MetricInfo* info = comparison.info(metric);
  const std::string unit = info == nullptr ? std::string() : unit_text(info->unit);
  return unit.empty() ? text : text + " " + unit;
}

std::string head_of(const Comparison& comparison, const Column& column) {
  const MetricInfo* info = comparison.info(column.metric);
  return info == nullptr ? column.label : fmt::format("{}{}", column.label, direction_mark(info->better));
}

Comparison make_comparison(const std::vector<RunCase>& cases, const std::vector<std::uint64_t>& seeds,
                           std::vector<RunRecord> records, const std::vector<std::string>& metrics,
                           MetricMap declared) {
  Comparison comparison;
  comparison.seeds = seeds;
  comparison.declared = std::move(declared);
  for (const MetricInfo& metric : run_time_metrics()) comparison.declared.emplace(metric.name, metric);
  for (const RunCase& c : cases) {
    CompareRow row;
    row.graph = graph_name(c.graph);
    row.configuration = c.configuration;
    row.against = c.against;
    row.unlike = c.unlike;
    row.judged = c.judged;
    row.runs.resize(seeds.size());
    row.status.assign(seeds.size(), RunStatus::failed);
    row.message.assign(seeds.size(), "it has not run");
    row.spread.assign(seeds.size(), std::nan(""));
    row.control_us.assign(seeds.size(), std::nan(""));
    comparison.rows.push_back(std::move(row));
  }
  for (RunRecord& record : records) {
    CompareRow& row = comparison.rows[record.number / seeds.size()];
    const std::size_t s = record.number % seeds.size();
    if (row.title.empty()) row.title = record.result.title;
    row.status[s] = record.status;
    row.message[s] = record.message;
    row.control_us[s] = record.control_us;
    row.spread[s] = spread_of_repeats(record.cpu_s);
    row.runs[s] = std::move(record.result);
  }
  for (const std::string& metric : metrics) comparison.columns.push_back({metric, metric});
  if (metrics.empty()) {
    for (const Column& column : error_columns()) {
      comparison.columns.push_back({column.metric, with_unit(comparison, column.label, column.metric)});
    }
  }
  const auto add_run_time = [&comparison](const std::string& metric, const std::string& what, const char* each) {
    comparison.columns.push_back({metric, with_unit(comparison, what, metric) + each, true});
  };
  add_run_time("cpu_ms_per_s", "CPU", "");
  add_run_time("method_us_per_result", "method", " a result");
  add_run_time("method_us_per_tick", "method", " a tick");
  for (const CompareRow& row : comparison.rows) {
    for (const RunResult& run : row.runs) {
      for (const NodeCost& node : run.nodes) {
        const MetricInfo metric = step_time_metric(node.node);
        if (comparison.declared.emplace(metric.name, metric).second) add_run_time(metric.name, node.node, "");
      }
    }
  }
  // A run time that was asked for as a metric has its column among the run times.
  std::erase_if(comparison.columns, [&](const Column& column) {
    return !column.run_time &&
           std::any_of(comparison.columns.begin(), comparison.columns.end(),
                       [&](const Column& other) { return other.run_time && other.metric == column.metric; });
  });
  fill_columns(comparison);
  judge(comparison);
  return comparison;
}

namespace {

/// The rows with a run whose repeats spread too far, the worst few by name; empty where there is none.
std::string spread_warning(const Comparison& comparison) {
  struct Row {
    const CompareRow* row;
    double worst;
    std::size_t beyond;
  };
  std::vector<Row> rows;
  std::size_t runs = 0, beyond = 0;
  for (const CompareRow& row : comparison.rows) {
    Row mine{&row, 0, 0};
    for (const double spread : row.done(row.spread)) {
      ++runs;
      if (!(spread > TimingNote::quiet_spread)) continue;
      ++mine.beyond;
      mine.worst = std::max(mine.worst, spread);
    }
    beyond += mine.beyond;
    if (mine.beyond > 0) rows.push_back(mine);
  }
  if (rows.empty()) return {};
  std::stable_sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.worst > b.worst; });
  constexpr std::size_t most_named = 3;
  std::string names;
  for (std::size_t i = 0; i < std::min(rows.size(), most_named); ++i) {
    const CompareRow& row = *rows[i].row;
    names +=
        fmt::format("{}{} (by {:.0f} % at most, in {} of {})", i == 0 ? "" : ", ",
                    case_name(row.graph, row.configuration), 100 * rows[i].worst, rows[i].beyond, row.seeds_done());
  }
  if (rows.size() > most_named) names += fmt::format(" and {} more", rows.size() - most_named);
  return fmt::format("the repeats of {} of {} runs spread by more than 10 %: {}", beyond, runs, names);
}

}  // namespace

TimingNote timing_note(const Comparison& comparison, Repeats repeats) {
  std::vector<double> control, spreads;
  for (const CompareRow& row : comparison.rows) {
    for (std::size_t s = 0; s < row.status.size(); ++s) {
      if (row.status[s] != RunStatus::done) continue;
      control.push_back(row.control_us[s]);
      spreads.push_back(row.spread[s]);
    }
  }
  return timing_note(control, spreads, repeats, spread_warning(comparison),
                     "measure again on an idle machine, a study with --jobs 1");
}

std::optional<SeedSpread> seed_spread(const std::vector<std::uint64_t>& seeds, std::span<const double> by_seed,
                                      Better better) {
  std::vector<double> values;
  std::optional<std::size_t> worst;
  for (std::size_t s = 0; s < std::min(seeds.size(), by_seed.size()); ++s) {
    if (!std::isfinite(by_seed[s])) continue;
    values.push_back(by_seed[s]);
    if (!worst || badness(better, by_seed[s]) > badness(better, by_seed[*worst])) worst = s;
  }
  if (!worst) return std::nullopt;
  return SeedSpread{quantile(values, 0.05), median(values), quantile(values, 0.95),
                    by_seed[*worst],        seeds[*worst],  two_populations(values)};
}

std::string populations_text(const std::optional<SeedSpread>& spread) {
  if (!spread || !spread->populations) return {};
  const TwoPopulations& two = *spread->populations;
  return fmt::format("two populations: {} seeds at {} to {}, {} at {} to {}", two.low_count, pretty(two.low_min),
                     pretty(two.low_max), two.high_count, pretty(two.high_min), pretty(two.high_max));
}

namespace {

/// From when on the runs of the row are judged, `settle` included where they say so.
double judged_from_s(const CompareRow& row) {
  for (const RunResult& run : row.runs) {
    const double said = run.metric("judged.from_s");
    if (std::isfinite(said)) return said;
  }
  return row.judged.from.seconds();
}

}  // namespace

std::vector<std::string> judged_sentences(const Comparison& comparison) {
  std::vector<std::string> sentences;
  const bool alike = std::all_of(comparison.rows.begin(), comparison.rows.end(), [&](const CompareRow& row) {
    return row.judged.last == comparison.rows.front().judged.last;
  });
  std::string last;
  for (const CompareRow& row : comparison.rows) {
    // The rows of a group are judged alike; those of a study are the configurations of a graph.
    if (row.judged.last.empty() || row.judged.last == last) continue;
    last = row.judged.last;
    sentences.push_back(fmt::format("{}metrics from {} s on, when all compared runs are warm (last: {})",
                                    alike ? "" : row.graph + ": ", pretty(judged_from_s(row)), last));
  }
  if (std::any_of(comparison.rows.begin(), comparison.rows.end(),
                  [](const CompareRow& row) { return row.judged.cold; })) {
    sentences.emplace_back("metrics from the start of the runs, including their cold start (judge: whole)");
  }
  sentences.push_back(fmt::format("metrics by version {} of their definitions", metric_definitions));
  return sentences;
}

std::string word_of(RunStatus status) {
  return status == RunStatus::done ? "done" : status == RunStatus::failed ? "failed" : "refused";
}

std::string failures_text(const Comparison& comparison) {
  std::string out;
  for (const CompareRow& row : comparison.rows) {
    for (std::size_t s = 0; s < row.status.size(); ++s) {
      if (row.status[s] == RunStatus::done) continue;
      out += fmt::format("{}: {}\n", run_name(row.graph, row.configuration, comparison.seeds[s]), row.message[s]);
    }
  }
  return out;
}

Json to_json(const SeedSpread& spread) {
  Json json{{"q05", spread.low},
            {"q50", spread.middle},
            {"q95", spread.high},
            {"worst", spread.worst},
            {"worst_seed", spread.worst_seed}};
  if (const auto& two = spread.populations) {
    json["populations"] = Json::array({{{"seeds", two->low_count}, {"from", two->low_min}, {"to", two->low_max}},
                                       {{"seeds", two->high_count}, {"from", two->high_min}, {"to", two->high_max}}});
  }
  return json;
}

Json to_json(const Comparison& comparison, const CompareRow& row) {
  const auto by_seed = [](const std::vector<double>& values) {
    Json list = Json::array();
    for (const double v : values) list.push_back(number_json(v));
    return list;
  };
  const auto difference = [](const std::optional<PairedDifference>& d) -> Json {
    if (!d) return nullptr;
    return {{"pairs", d->pairs},
            {"mean_N", d->mean},
            {"low_N", d->interval ? Json(d->interval->low) : Json()},
            {"high_N", d->interval ? Json(d->interval->high) : Json()},
            {"effect_size", d->effect_size ? Json(*d->effect_size) : Json()},
            {"p_wilcoxon", d->p_wilcoxon ? Json(*d->p_wilcoxon) : Json()},
            {"identical", d->identical == Identical::no       ? Json()
                          : d->identical == Identical::groups ? Json("rows")
                                                              : Json("seeds")}};
  };
  Json json;
  json["graph"] = row.graph;
  if (!row.configuration.empty()) json["configuration"] = row.configuration;
  json["title"] = row.title;
  json["seeds_done"] = row.seeds_done();
  json["identical_seeds"] = row.identical_seeds;
  json["unlike"] = row.unlike.empty() ? Json() : Json(row.unlike);
  json["reference_too_coarse"] = row.too_coarse.empty() ? Json() : Json(row.too_coarse);
  json["status"] = Json::array();
  for (const RunStatus status : row.status) json["status"].push_back(word_of(status));
  json["failures"] = Json::array();
  for (std::size_t s = 0; s < row.status.size(); ++s) {
    if (row.status[s] == RunStatus::done) continue;
    json["failures"].push_back({{"seed", comparison.seeds[s]}, {"message", row.message[s]}});
  }
  json["metrics"] = Json::object();
  for (std::size_t c = 0; c < comparison.columns.size(); ++c) {
    const std::vector<double> values = row.done(row.values[c]);
    Json& metric = json["metrics"][comparison.columns[c].metric];
    const double centre = mean(values);
    metric = {{"mean", number_json(centre)},
              {"sd", std::isfinite(centre) && values.size() > 1 ? Json(standard_deviation(values)) : Json()}};
    const MetricInfo* info = comparison.info(comparison.columns[c].metric);
    const Better better = info == nullptr ? Better::lower : info->better;
    if (const auto spread = seed_spread(comparison.seeds, row.values[c], better)) {
      metric["spread"] = to_json(*spread);
    }
    if (info != nullptr) {
      metric["unit"] = info->unit;
      metric["better"] = name_of(info->better);
    }
    metric["by_seed"] = by_seed(row.values[c]);
  }
  json["judged"] = {{"from_s", judged_from_s(row)}, {"last_warm", row.judged.last}};
  json["spread_of_repeats"] = by_seed(row.spread);
  json["control_us"] = by_seed(row.control_us);
  json["against"]["row"] = comparison.rows[row.against].name();
  if (row.one_step_anova) {
    json["against"]["one_step_anova"] = {
        {"F", row.one_step_anova->F}, {"p", row.one_step_anova->p}, {"df_within", row.one_step_anova->df_within}};
  }
  json["against"]["one_step_rms"] = difference(row.one_step);
  json["against"]["delivered_rms"] = difference(row.delivered);
  return json;
}

Json to_json(const Comparison& comparison) {
  Json json;
  json["tactor"] = TACTOR_VERSION;
  json["metric_definitions"] = metric_definitions;
  json["seeds"] = comparison.seeds;
  json["warnings"] = comparison_warnings(comparison);
  json["graphs"] = Json::array();
  for (const CompareRow& row : comparison.rows) json["graphs"].push_back(to_json(comparison, row));
  if (!comparison.provenance.empty()) json["provenance"] = to_json(comparison.provenance);
  return json;
}

bool is_compared(const Comparison& comparison, std::size_t row) {
  const CompareRow& mine = comparison.rows[row];
  const CompareRow& other = comparison.rows[mine.against];
  const bool is_method_alone = mine.unlike.empty() && other.unlike.empty();
  return mine.against != row && is_method_alone && !(mine.never_touches() && other.never_touches());
}

const Anova* shown_anova(const Comparison& comparison, const CompareRow& row) {
  return row.one_step_anova && judged_seeds(comparison, row) >= fewest_seeds ? &*row.one_step_anova : nullptr;
}

std::size_t judged_seeds(const Comparison& comparison, const CompareRow& row) {
  return seeds_of_both(row, comparison.rows[row.against]).size();
}

std::string of_seeds(std::size_t count, std::size_t seeds) {
  return fmt::format("{} of {} seed{}", count, seeds, seeds == 1 ? "" : "s");
}

std::string over_seeds(std::size_t count, std::size_t seeds) {
  return count < seeds ? fmt::format(" over {} seed{}", count, count == 1 ? "" : "s") : std::string();
}

}  // namespace tactor
