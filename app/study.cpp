#include "app/study.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/summary.hpp"
#include "framework/graph/merge.hpp"

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

/// How a setting is called in tables.
std::string label(const StudySetting& setting) {
  std::vector<std::string> parts;
  if (!setting.method.empty()) parts.push_back(setting.method);
  for (const auto& [path, value] : setting.values) parts.push_back(fmt::format("{}={}", path, value));
  return parts.empty() ? "as it is" : joined(parts, " ");
}

/// log(b_i / a_i) for each seed; none where a value is not above zero.
std::vector<double> log_ratios(std::span<const double> a, std::span<const double> b) {
  std::vector<double> logs;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    if (!(a[i] > 0 && b[i] > 0)) return {};
    logs.push_back(std::log(b[i] / a[i]));
  }
  return logs;
}

std::vector<double> row_logs(const Comparison& comparison, std::size_t row, std::string_view figure) {
  const CompareRow& mine = comparison.rows[row];
  return log_ratios(comparison.rows[mine.against].figure(figure, comparison.columns),
                    mine.figure(figure, comparison.columns));
}

/// Each seed's mean over the graphs; none where a graph has none.
std::vector<double> logs_over_graphs(const Study& study, std::size_t setting, std::string_view figure) {
  const std::size_t settings = study.settings.size();
  std::vector<double> sum(study.comparison.seeds.size(), 0.0);
  for (std::size_t row = setting; row < study.comparison.rows.size(); row += settings) {
    const std::vector<double> logs = row_logs(study.comparison, row, figure);
    if (logs.size() != sum.size()) return {};
    for (std::size_t s = 0; s < sum.size(); ++s) sum[s] += logs[s] / static_cast<double>(study.spec.graphs.size());
  }
  return sum;
}

std::string text_of(const std::optional<GeometricMean>& m) {
  return m ? fmt::format("{:.3f} [{:.3f}, {:.3f}]", m->ratio, m->low, m->high) : "-";
}

Json to_json(const ErrorRatio& ratio) {
  const auto one = [](const std::optional<GeometricMean>& m) -> Json {
    if (!m) return nullptr;
    return {{"ratio", m->ratio}, {"low", m->low}, {"high", m->high}, {"count", m->count}};
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
    means.push_back(mean(comparison.rows[row].figure(figure, comparison.columns)));
  }
  return mean(means);
}

std::vector<StudySetting> study_settings(const StudySpec& spec) {
  std::vector<StudySetting> settings;
  if (spec.methods.empty()) settings.emplace_back();
  for (const auto& method : spec.methods) settings.push_back({method.stem().string(), {}, {}});
  for (const StudyAxis& axis : spec.vary) {
    std::vector<StudySetting> more;
    for (const StudySetting& setting : settings) {
      for (const std::string& value : axis.values) {
        more.push_back(setting);
        more.back().values.emplace_back(joined(axis.paths, ", "), value);
      }
    }
    settings = std::move(more);
  }
  return settings;
}

std::vector<CompareCase> study_cases(const StudySpec& spec, const Overrides& overrides) {
  for (const StudyAxis& axis : spec.vary) {
    for (const std::string& path : axis.paths) {
      for (const std::string& set : overrides.set) {
        if (trimmed(set.substr(0, set.find('='))) != path) continue;
        throw InputError("--set " + set + ": the study varies " + path + "; take it out of the study's `vary` first");
      }
    }
  }
  const std::vector<StudySetting> settings = study_settings(spec);
  std::vector<CompareCase> cases;
  for (const auto& graph : spec.graphs) {
    const std::size_t first = cases.size();
    for (const StudySetting& setting : settings) {
      CompareCase c{graph, overrides, label(setting), first};
      // What the command line lays over comes last, so that it wins, as with its values.
      for (const auto& method : spec.methods) {
        if (method.stem() == setting.method) c.overrides.over.insert(c.overrides.over.begin(), method);
      }
      std::vector<std::string> set = spec.set;
      for (std::size_t a = 0; a < spec.vary.size(); ++a) {
        for (const std::string& path : spec.vary[a].paths) set.push_back(path + "=" + setting.values[a].second);
      }
      c.overrides.set.insert(c.overrides.set.begin(), set.begin(), set.end());
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

std::string study_csv(const Study& study) {
  const Comparison& comparison = study.comparison;
  std::vector<std::string> head{"graph", "method"};
  for (const StudyAxis& axis : study.spec.vary) head.push_back(quoted_where_needed(joined(axis.paths, ", ")));
  head.emplace_back("seed");
  for (const Column& column : comparison.columns) head.push_back(column.figure);
  std::string out = joined(head, ",") + "\n";
  for (std::size_t row = 0; row < comparison.rows.size(); ++row) {
    for (std::size_t s = 0; s < comparison.seeds.size(); ++s) {
      std::vector<std::string> cells{comparison.rows[row].graph, study.setting(row).method};
      for (const auto& [path, value] : study.setting(row).values) cells.push_back(quoted_where_needed(value));
      cells.push_back(std::to_string(comparison.seeds[s]));
      for (const std::vector<double>& values : comparison.rows[row].values) {
        cells.push_back(std::isfinite(values[s]) ? fmt::format("{}", values[s]) : "");
      }
      out += fmt::format("{}\n", fmt::join(cells, ","));
    }
  }
  return out;
}

Json to_json(const Study& study) {
  Json json;
  json["tactor"] = TACTOR_VERSION;
  json["study"] = study.spec.name;
  json["title"] = study.spec.title;
  json["seeds"] = study.comparison.seeds;
  json["settings"] = Json::array();
  for (const StudySetting& setting : study.settings) {
    Json one = to_json(setting);
    one["over_graphs"] = to_json(setting.over_graphs);
    json["settings"].push_back(std::move(one));
  }
  json["rows"] = Json::array();
  for (std::size_t row = 0; row < study.comparison.rows.size(); ++row) {
    Json one = to_json(study.setting(row));
    one.update(to_json(study.comparison.rows[row], study.comparison.columns));
    one["against_first"]["ratio"] = to_json(study.ratios[row]);
    json["rows"].push_back(std::move(one));
  }
  return json;
}

std::string study_table(const Study& study) {
  const Comparison& comparison = study.comparison;
  const std::size_t settings = study.settings.size();
  std::size_t width = 12;
  for (const StudySetting& setting : study.settings) width = std::max(width, label(setting).size());
  const auto line = [&](const std::string& name, const ErrorRatio& ratio, const auto& value) {
    const auto figure = [&](std::string_view f) { return pretty(value(f)); };
    return fmt::format("  {:<{}} {:>10} {:>22} {:>8} {:>11} {:>10} {:>22} {:>10} {:>10}\n", name, width,
                       figure(delivered_error), text_of(ratio.delivered), figure("delivered.force.delay_ms"),
                       figure("delivered.force.rms_d2_N_per_ms2"), figure(one_step_error), text_of(ratio.one_step),
                       figure("method_us_per_result"), figure("method_us_per_tick"));
  };
  const std::string head =
      fmt::format("  {:<{}} {:>10} {:>22} {:>8} {:>11} {:>10} {:>22} {:>10} {:>10}\n", "", width, "RMS err N",
                  "ratio [95 %]", "delay ms", "2nd diff", "1-step N", "ratio [95 %]", "us/result", "us/tick");
  std::string out =
      fmt::format("\n{}: {} seed{} from {}; ratios are to the first line\n", study.spec.name, comparison.seeds.size(),
                  comparison.seeds.size() == 1 ? "" : "s", comparison.seeds.front());
  for (std::size_t row = 0; row < comparison.rows.size(); ++row) {
    if (row % settings == 0) out += fmt::format("\n{}\n{}", comparison.rows[row].graph, head);
    out += line(label(study.setting(row)), study.ratios[row],
                [&](std::string_view figure) { return mean(comparison.rows[row].figure(figure, comparison.columns)); });
  }
  if (study.spec.graphs.size() > 1) {
    out += fmt::format("\nall {} graphs\n{}", study.spec.graphs.size(), head);
    for (std::size_t s = 0; s < settings; ++s) {
      out += line(label(study.settings[s]), study.settings[s].over_graphs,
                  [&](std::string_view figure) { return study.over_graphs(s, figure); });
    }
  }
  if (settings > 1) out += "\nagainst the first line of the graph\n" + judged_text(comparison);
  return out;
}

}  // namespace tactor
