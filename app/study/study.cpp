#include "app/study/study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "app/run/summary.hpp"
#include "app/study/warnings.hpp"
#include "framework/core/text.hpp"
#include "framework/graph/merge.hpp"
#include "framework/graph/text_table.hpp"

namespace tactor {

using Json = nlohmann::ordered_json;

namespace {

constexpr std::string_view delivered_error = "delivered.force.rms_error_N";
constexpr std::string_view one_step_error = "one_step.force.rms_error_N";

std::string joined(const std::vector<std::string>& parts, std::string_view between) {
  std::string text;
  for (const std::string& part : parts) text.append(text.empty() ? "" : between).append(part);
  return text;
}

/// The seeds of which the row and what it is judged against are done.
std::vector<bool> judged_seeds(const Comparison& comparison, std::size_t row) {
  const CompareRow& mine = comparison.rows[row];
  const CompareRow& other = comparison.rows[mine.against];
  std::vector<bool> both;
  for (std::size_t s = 0; s < comparison.seeds.size(); ++s) {
    both.push_back(mine.status[s] == RunStatus::done && other.status[s] == RunStatus::done);
  }
  return both;
}

/// For these seeds the logarithm of the figure's ratio to that of the row it is judged against; none where a value is
/// not above zero.
std::vector<double> row_logs(const Comparison& comparison, std::size_t row, std::string_view figure,
                             const std::vector<bool>& seeds) {
  const CompareRow& mine = comparison.rows[row];
  const std::span<const double> a = comparison.rows[mine.against].figure(figure, comparison.columns);
  const std::span<const double> b = mine.figure(figure, comparison.columns);
  std::vector<double> logs;
  for (std::size_t s = 0; s < std::min(a.size(), b.size()); ++s) {
    if (!seeds[s]) continue;
    if (!(a[s] > 0 && b[s] > 0)) return {};
    logs.push_back(std::log(b[s] / a[s]));
  }
  return logs;
}

std::vector<double> row_logs(const Comparison& comparison, std::size_t row, std::string_view figure) {
  return row_logs(comparison, row, figure, judged_seeds(comparison, row));
}

/// The mean over the graphs for each seed that all of them have; none where a graph has none.
std::vector<double> logs_over_graphs(const Study& study, std::size_t setting, std::string_view figure) {
  const std::size_t settings = study.settings.size();
  std::vector<bool> seeds(study.comparison.seeds.size(), true);
  for (std::size_t row = setting; row < study.comparison.rows.size(); row += settings) {
    const std::vector<bool> mine = judged_seeds(study.comparison, row);
    for (std::size_t s = 0; s < seeds.size(); ++s) seeds[s] = seeds[s] && mine[s];
  }
  std::vector<double> sum(static_cast<std::size_t>(std::count(seeds.begin(), seeds.end(), true)), 0.0);
  for (std::size_t row = setting; row < study.comparison.rows.size(); row += settings) {
    const std::vector<double> logs = row_logs(study.comparison, row, figure, seeds);
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

Json to_json(const StudySetting& setting) {
  Json json;
  if (!setting.method.empty()) json["method"] = setting.method;
  json["values"] = Json::object();
  for (const auto& [path, value] : setting.values) json["values"][path] = value;
  return json;
}

std::string quoted_where_needed(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

}  // namespace

double Study::over_graphs(std::size_t setting, std::string_view figure) const {
  std::vector<double> means;
  for (std::size_t row = setting; row < comparison.rows.size(); row += settings.size()) {
    means.push_back(comparison.rows[row].mean_of(figure, comparison.columns));
  }
  return mean(means);
}

std::string Study::incomplete(std::size_t setting) const {
  for (std::size_t row = setting; row < comparison.rows.size(); row += settings.size()) {
    const CompareRow& mine = comparison.rows[row];
    if (!mine.seeds_text().empty() || !comparison.rows[mine.against].seeds_text().empty()) return " (seeds missing)";
  }
  return {};
}

std::string ratio_text(const std::optional<GeometricMean>& ratio, std::size_t seeds) {
  if (!ratio) return "-";
  const std::string interval =
      std::isfinite(ratio->low) ? fmt::format("{:.3f}, {:.3f}", ratio->low, ratio->high) : std::string("-");
  return fmt::format("{:.3f} [{}]{}", ratio->ratio, interval, over_seeds(ratio->count, seeds));
}

std::string ratios_text(const StudySpec& spec) {
  const std::string baseline = baseline_text(spec);
  return baseline.empty() ? std::string() : "; ratios are to " + baseline;
}

std::string label(const StudySetting& setting) {
  std::vector<std::string> parts;
  if (!setting.method.empty()) parts.push_back(setting.method);
  for (const auto& [path, value] : setting.values) parts.push_back(fmt::format("{}={}", path, value));
  return parts.empty() ? "as it is" : joined(parts, " ");
}

namespace {

/// Sets of every setting the one that has the values of the baseline and is otherwise like it.
void find_counterparts(const StudySpec& spec, std::vector<StudySetting>& settings) {
  using Cell = std::pair<std::string, std::vector<std::pair<std::string, std::string>>>;
  std::map<Cell, std::size_t> cells;
  for (std::size_t s = 0; s < settings.size(); ++s) {
    cells.emplace(Cell{settings[s].method, settings[s].values}, s);
    settings[s].against = s;
  }
  for (StudySetting& setting : settings) {
    const Cell own{setting.method, setting.values};
    Cell cell = own;
    for (const AxisValue& at : spec.baseline) {
      if (at.axis == "method") cell.first = at.value;
      for (auto& [axis, value] : cell.second) {
        if (axis == at.axis) value = at.value;
      }
    }
    if (cell != own) setting.against = cells.at(cell);
  }
}

}  // namespace

std::vector<StudySetting> study_settings(const StudySpec& spec) {
  std::vector<StudySetting> methods;
  if (spec.methods.empty()) methods.emplace_back();
  for (const Overlay& method : spec.methods) methods.push_back({.method = method.name, .layers = {method}});
  const std::vector<StudyPoint> points = study_points(spec);
  std::vector<StudySetting> settings;
  for (const StudySetting& method : methods) {
    for (const StudyPoint& point : points) {
      StudySetting setting = method;
      for (std::size_t a = 0; a < spec.vary.size(); ++a) {
        const StudyValue& value = point.values[a];
        setting.values.emplace_back(spec.vary[a].name, value.text);
        if (value.overlay) setting.layers.push_back(*value.overlay);
        for (const std::string& path : spec.vary[a].paths) setting.set.push_back(path + "=" + value.text);
      }
      settings.push_back(std::move(setting));
    }
  }
  find_counterparts(spec, settings);
  return settings;
}

std::vector<std::string> shown_figures(const StudySpec& spec) {
  std::vector<std::string> figures = spec.metrics;
  const auto add = [&](const char* name) {
    if (std::find(figures.begin(), figures.end(), name) == figures.end()) figures.emplace_back(name);
  };
  if (spec.report == StudyReport::stability) {
    for (const char* name : {"stability.verdict", "stability.peak_energy_J", "stability.passivity_violation_J",
                             "stability.oscillation_amplitude_m", "stability.oscillation_frequency_Hz"}) {
      add(name);
    }
    if (spec.metrics.empty()) add("delivered.force.rms_error_N");
  } else if (spec.report == StudyReport::work_precision &&
             (!spec.metrics.empty() || spec.error != "delivered.force.rms_error_N")) {
    for (const char* name : {"delivered.force.rms_error_N", spec.error.c_str()}) add(name);
  }
  return figures;
}

std::vector<RunCase> study_cases(const StudySpec& spec, const Overrides& overrides) {
  for (const StudyAxis& axis : spec.vary) {
    for (const std::string& path : axis.paths) {
      if (overrides.duration_s && path == "duration") {
        throw InputError("--duration: the study varies duration; take it out of the study's `vary` first");
      }
      for (const std::string& set : overrides.set) {
        if (trimmed(std::string_view(set).substr(0, set.find('='))) != path) continue;
        throw InputError("--set " + set + ": the study varies " + path + "; take it out of the study's `vary` first");
      }
    }
  }
  const std::vector<StudySetting> settings = study_settings(spec);
  std::vector<RunCase> cases;
  for (const auto& graph : spec.graphs) {
    const std::size_t first = cases.size();
    for (const StudySetting& setting : settings) {
      RunCase c{graph, overrides, label(setting), first + setting.against, {}};
      // What the command line says comes last, so that it wins.
      c.overrides.layers = setting.layers;
      std::vector<std::string> set = spec.set;
      set.insert(set.end(), setting.set.begin(), setting.set.end());
      c.overrides.set.insert(c.overrides.set.begin(), set.begin(), set.end());
      if (!c.overrides.duration_s) c.overrides.duration_s = spec.duration_s;
      if (!spec.reference_over.empty() || !spec.reference_set.empty()) {
        c.reference = c.overrides;
        c.reference->top_layers = spec.reference_over;
        c.reference->top_set = spec.reference_set;
      }
      cases.push_back(std::move(c));
    }
  }
  return cases;
}

Study make_study(const StudySpec& spec, Comparison comparison) {
  Study study{spec, study_settings(spec), std::move(comparison), {}};
  for (std::size_t row = 0; row < study.comparison.rows.size(); ++row) {
    study.ratios.push_back({geometric_mean(row_logs(study.comparison, row, delivered_error)),
                            geometric_mean(row_logs(study.comparison, row, one_step_error))});
  }
  for (std::size_t s = 0; s < study.settings.size(); ++s) {
    study.settings[s].over_graphs = {geometric_mean(logs_over_graphs(study, s, delivered_error)),
                                     geometric_mean(logs_over_graphs(study, s, one_step_error))};
  }
  return study;
}

namespace {

/// A line a run: what it is, then a cell for each of the columns.
template <class Cells>
std::string csv_of(const Study& study, std::vector<std::string> more_head, const Cells& cells_of) {
  std::vector<std::string> head{"graph", "method"};
  for (const StudyAxis& axis : study.spec.vary) head.push_back(quoted_where_needed(axis.name));
  head.emplace_back("seed");
  for (std::string& name : more_head) head.push_back(std::move(name));
  std::string out = joined(head, ",") + "\n";
  const Comparison& comparison = study.comparison;
  for (std::size_t row = 0; row < comparison.rows.size(); ++row) {
    for (std::size_t s = 0; s < comparison.seeds.size(); ++s) {
      std::vector<std::string> cells{quoted_where_needed(comparison.rows[row].graph),
                                     quoted_where_needed(study.setting(row).method)};
      for (const auto& [path, value] : study.setting(row).values) cells.push_back(quoted_where_needed(value));
      cells.push_back(std::to_string(comparison.seeds[s]));
      cells_of(comparison.rows[row], s, cells);
      out += fmt::format("{}\n", fmt::join(cells, ","));
    }
  }
  return out;
}

std::string csv_number(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : "";
}

void add_values(const Study& study, const CompareRow& row, std::size_t seed, bool run_times,
                std::vector<std::string>& cells) {
  for (std::size_t c = 0; c < study.comparison.columns.size(); ++c) {
    if (study.comparison.columns[c].run_time == run_times) cells.push_back(csv_number(row.values[c][seed]));
  }
}

std::vector<std::string> figures_of(const Study& study, bool run_times) {
  std::vector<std::string> names;
  for (const Column& column : study.comparison.columns) {
    if (column.run_time == run_times) names.push_back(column.figure);
  }
  return names;
}

}  // namespace

std::string study_csv(const Study& study) {
  std::vector<std::string> head{"status"};
  for (std::string& name : figures_of(study, false)) head.push_back(std::move(name));
  return csv_of(study, std::move(head), [&](const CompareRow& row, std::size_t s, std::vector<std::string>& cells) {
    cells.push_back(word_of(row.status[s]));
    add_values(study, row, s, false, cells);
  });
}

std::string run_times_csv(const Study& study) {
  std::vector<std::string> head = figures_of(study, true);
  head.insert(head.end(), {"spread_of_repeats", "control_us"});
  return csv_of(study, std::move(head), [&](const CompareRow& row, std::size_t s, std::vector<std::string>& cells) {
    add_values(study, row, s, true, cells);
    cells.push_back(csv_number(row.spread[s]));
    cells.push_back(csv_number(row.control_us[s]));
  });
}

TimingNote timing_note(const Study& study) {
  return timing_note(study.comparison, {study.spec.repeats, study.spec.warm_up});
}

Json to_json(const Study& study) {
  Json json;
  json["tactor"] = TACTOR_VERSION;
  json["study"] = study.spec.name;
  json["title"] = study.spec.title;
  json["seeds"] = study.comparison.seeds;
  json["baseline"] = Json::object();
  for (const AxisValue& at : study.spec.baseline) json["baseline"][at.axis] = at.value;
  json["warnings"] = comparison_warnings(study.comparison);
  json["timing"] = to_json(timing_note(study));
  json["settings"] = Json::array();
  for (const StudySetting& setting : study.settings) {
    Json one = to_json(setting);
    one["over_graphs"] = to_json(setting.over_graphs, study.comparison.seeds.size());
    json["settings"].push_back(std::move(one));
  }
  json["rows"] = Json::array();
  for (std::size_t row = 0; row < study.comparison.rows.size(); ++row) {
    Json one = to_json(study.setting(row));
    one.update(to_json(study.comparison, study.comparison.rows[row]));
    one["against"]["ratio"] = to_json(study.ratios[row], study.comparison.seeds.size());
    json["rows"].push_back(std::move(one));
  }
  return json;
}

std::string study_table(const Study& study, std::size_t columns) {
  const Comparison& comparison = study.comparison;
  const std::size_t settings = study.settings.size();
  const auto name_of_row = [&](std::size_t row) {
    const std::string seeds = comparison.rows[row].seeds_text();
    return label(study.setting(row)) + (seeds.empty() ? "" : " (" + seeds + ")");
  };
  const auto text_of = [&](const std::optional<GeometricMean>& ratio) {
    return ratio_text(ratio, comparison.seeds.size());
  };
  const auto add = [&](TextTable& table, const std::string& name, const ErrorRatio& ratio, const auto& value) {
    const auto figure = [&](std::string_view f) { return pretty(value(f)); };
    table.add({name, figure(delivered_error), text_of(ratio.delivered), figure("delivered.force.delay_ms"),
               figure("delivered.force.rms_d2_N_per_ms2"), figure(one_step_error), text_of(ratio.one_step),
               figure("method_us_per_result"), figure("method_us_per_tick")});
  };
  using enum TextTable::Align;
  const TextTable empty({{""},
                         {"RMS err N", right},
                         {"ratio [95 %]", right},
                         {"delay ms", right},
                         {"2nd diff", right},
                         {"1-step N", right},
                         {"ratio [95 %]", right},
                         {"us/result", right},
                         {"us/tick", right}});
  std::string out =
      fmt::format("\n{}: {} seed{} from {}{}\n", study.spec.name, comparison.seeds.size(),
                  comparison.seeds.size() == 1 ? "" : "s", comparison.seeds.front(), ratios_text(study.spec));
  for (std::size_t first = 0; first < comparison.rows.size(); first += settings) {
    TextTable table = empty;
    for (std::size_t row = first; row < first + settings; ++row) {
      add(table, name_of_row(row), study.ratios[row],
          [&](std::string_view figure) { return comparison.rows[row].mean_of(figure, comparison.columns); });
    }
    out += fmt::format("\n{}\n{}", comparison.rows[first].graph, table.text(columns));
  }
  if (study.spec.graphs.size() > 1) {
    TextTable table = empty;
    for (std::size_t s = 0; s < settings; ++s) {
      add(table, label(study.settings[s]) + study.incomplete(s), study.settings[s].over_graphs,
          [&](std::string_view figure) { return study.over_graphs(s, figure); });
    }
    out += fmt::format("\nall {} graphs\n{}", study.spec.graphs.size(), table.text(columns));
  }
  out += lines_of(timing_note(study));
  const std::string judged = judged_text(comparison);
  if (!judged.empty()) out += fmt::format("\nagainst {}\n{}", baseline_text(study.spec), judged);
  return wrapped(out, columns);
}

}  // namespace tactor
