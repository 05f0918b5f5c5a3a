#include "app/study/report/work_precision.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "app/output.hpp"
#include "app/report/chart.hpp"
#include "app/report/figure.hpp"
#include "app/report/html_page.hpp"
#include "app/report/method_style.hpp"
#include "app/run/summary.hpp"
#include "app/study/report/report_parts.hpp"
#include "app/study/table/warnings.hpp"
#include "app/study/table/where.hpp"
#include "framework/graph/text_table.hpp"

namespace tactor {

using Json = nlohmann::ordered_json;

namespace {

constexpr int chart_width = 1160;
constexpr int chart_height = 430;

std::string join_words(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : " ") + word;
  return out;
}

/// The curve that a configuration is on, and the values that say where.
std::pair<std::string, std::string> place_of(const Study& study, const StudyConfiguration& configuration) {
  std::vector<std::string> curve, values;
  if (!configuration.method.empty()) curve.push_back(configuration.method);
  for (std::size_t a = 0; a < study.spec.vary.size(); ++a) {
    const auto& [name, value] = configuration.values[a];
    if (study.spec.vary[a].swaps()) {
      curve.push_back(value);
    } else {
      values.push_back(fmt::format("{}={}", name, value));
    }
  }
  return {join_words(curve), join_words(values)};
}

bool is_bound(const StudySpec& spec, const StudyConfiguration& configuration) {
  return std::find(spec.bounds.begin(), spec.bounds.end(), configuration.method) != spec.bounds.end();
}

/// What the configuration has in these rows of the comparison, one a graph: over the seeds of which all of them are
/// done, the geometric mean over the rows.
WorkPoint point_of(const Study& study, std::size_t configuration, const std::vector<std::size_t>& rows) {
  const Comparison& comparison = study.comparison;
  std::vector<std::size_t> seeds;
  for (std::size_t s = 0; s < comparison.seeds.size(); ++s) {
    const bool done = std::all_of(rows.begin(), rows.end(),
                                  [&](std::size_t row) { return comparison.rows[row].status[s] == RunStatus::done; });
    if (done) seeds.push_back(s);
  }
  const auto spread = [&](std::string_view metric) {
    const MetricInfo* info = comparison.info(metric);
    const Better better = info == nullptr ? Better::neither : info->better;
    std::vector<double> by_seed;
    for (const std::size_t s : seeds) {
      std::vector<double> over_rows;
      for (const std::size_t row : rows) {
        const std::span<const double> values = comparison.rows[row].metric(metric, comparison.columns);
        over_rows.push_back(values.empty() ? std::nan("") : compared_value(better, values[s]));
      }
      by_seed.push_back(spread_of(over_rows).centre);
    }
    return spread_of(by_seed);
  };
  const auto [curve, values] = place_of(study, study.configurations[configuration]);
  return {curve,
          values,
          spread(study.spec.error),
          spread("cpu_ms_per_s"),
          spread("method_us_per_tick"),
          is_bound(study.spec, study.configurations[configuration]),
          seeds.size(),
          comparison.seeds.size(),
          std::all_of(rows.begin(), rows.end(), [&](std::size_t row) {
            return comparison.rows[row].too_coarse.empty() && comparison.rows[row].has_reference(comparison.columns);
          })};
}

/// The points of these graphs together, by their index.
WorkGraph points_of(const Study& study, std::string name, const std::vector<std::size_t>& graphs) {
  WorkGraph out{std::move(name), {}};
  const std::size_t configurations = study.configurations.size();
  for (std::size_t s = 0; s < configurations; ++s) {
    std::vector<std::size_t> rows;
    for (const std::size_t graph : graphs) rows.push_back(graph * configurations + s);
    out.points.push_back(point_of(study, s, rows));
  }
  return out;
}

void mark_fronts(WorkGraph& graph, StudyTime time, Better better) {
  std::vector<double> error, run, tick;
  for (const WorkPoint& p : graph.points) {
    // pareto_front leaves out what is not a number.
    error.push_back(p.bound || p.incomplete() || !p.judged ? std::nan("") : badness(better, p.error.centre));
    run.push_back(p.ms_per_s.centre);
    tick.push_back(p.us_per_tick.centre);
  }
  const std::vector<bool> of_run = pareto_front(error, run);
  const std::vector<bool> of_tick = pareto_front(error, tick);
  for (std::size_t p = 0; p < graph.points.size(); ++p) {
    graph.points[p].front_run = time != StudyTime::tick && of_run[p];
    graph.points[p].front_tick = time != StudyTime::run && of_tick[p];
  }
}

/// Marks of one colour and shape: those with bars, and those of one seed alone, which has none.
struct Marks {
  Curve bars, bare;

  void add(const Spread& x, const Spread& y) {
    Curve& to = x.has_sides() && y.has_sides() ? bars : bare;
    to.x.push_back(x.centre);
    to.y.push_back(y.centre);
    if (&to == &bare) return;
    bars.x_low.push_back(x.low);
    bars.x_high.push_back(x.high);
    bars.y_low.push_back(y.low);
    bars.y_high.push_back(y.high);
  }
  /// Those that there are.
  void put_into(Chart& chart) && {
    for (Curve* marks : {&bars, &bare}) {
      if (!marks->x.empty()) chart.curves.push_back(std::move(*marks));
    }
  }
};

template <class Member>
std::vector<std::string> distinct(const std::vector<WorkPoint>& points, Member member) {
  std::vector<std::string> found;
  for (const WorkPoint& p : points) {
    if (std::find(found.begin(), found.end(), p.*member) == found.end()) found.push_back(p.*member);
  }
  return found;
}

/// Nothing but a name in the key.
Curve in_key(std::string name, std::string color, std::size_t mark) {
  return {std::move(name), {}, {}, std::move(color), true, mark};
}

/// A method has a colour, the values of what varies along it have a mark each; the key tells both.
Chart chart_of(const WorkPrecision& found, const WorkGraph& graph, Spread WorkPoint::*time, bool WorkPoint::*front,
               const std::string& x_label) {
  Chart chart{graph.graph, x_label, found.error_label, {}, {}};
  chart.log_x = chart.log_y = chart.close = true;
  const std::vector<std::string> names = distinct(graph.points, &WorkPoint::curve);
  const std::vector<std::string> values = distinct(graph.points, &WorkPoint::values);
  const bool is_varied = values.size() > 1;
  const std::vector<MethodStyle> styles = method_styles(names);
  Curve ring{"not undercut", {}, {}, "#222222"};
  ring.ring = true;
  Curve cross{"incomplete: seeds failed", {}, {}, "#c00000"};
  cross.cross = true;
  const auto put = [](Curve& curve, const Spread& x, const Spread& y) {
    curve.x.push_back(x.centre);
    curve.y.push_back(y.centre);
  };
  for (std::size_t c = 0; c < names.size(); ++c) {
    const bool bound = std::any_of(graph.points.begin(), graph.points.end(),
                                   [&](const WorkPoint& p) { return p.curve == names[c] && p.bound; });
    Curve line{"", {}, {}, styles[c].color};
    line.dash = styles[c].mark;
    std::vector<Marks> marks(values.size());
    for (std::size_t v = 0; v < values.size(); ++v) {
      Curve& mark = marks[v].bars = in_key("", styles[c].color, is_varied ? v : styles[c].mark);
      mark.hollow = bound;
      marks[v].bare = mark;
    }
    for (const WorkPoint& p : graph.points) {
      const Spread& t = p.*time;
      if (p.curve != names[c] || !std::isfinite(p.error.centre) || !std::isfinite(t.centre)) continue;
      const auto value = std::find(values.begin(), values.end(), p.values) - values.begin();
      marks[static_cast<std::size_t>(value)].add(t, p.error);
      put(line, t, p.error);
      if (p.incomplete()) put(cross, t, p.error);
      if (p.*front) put(ring, t, p.error);
    }
    if (line.x.empty()) continue;
    const std::string name = (names[c].empty() ? graph.graph : names[c]) + (bound ? " (bound)" : "");
    Curve key = in_key(name, styles[c].color, is_varied ? 0 : styles[c].mark);
    key.hollow = bound;
    key.points = !is_varied;
    key.dash = styles[c].mark;
    chart.curves.push_back(std::move(key));
    if (line.x.size() > 1) chart.curves.push_back(std::move(line));
    for (Marks& of_value : marks) std::move(of_value).put_into(chart);
  }
  if (chart.curves.empty()) return chart;
  for (std::size_t v = 0; is_varied && v < values.size(); ++v) {
    chart.curves.push_back(in_key(values[v].empty() ? "as it is" : values[v], "#555555", v));
  }
  if (!cross.x.empty()) ring.name += " (complete)";
  if (!ring.x.empty()) chart.curves.push_back(std::move(ring));
  if (!cross.x.empty()) chart.curves.push_back(std::move(cross));
  return chart;
}

std::vector<Chart> charts_of(const WorkPrecision& found, const WorkGraph& graph) {
  std::vector<Chart> charts;
  const auto add = [&](Chart chart, const char* time) {
    chart.name = graph.graph + "/" + time;
    if (!chart.curves.empty()) charts.push_back(std::move(chart));
  };
  if (found.time != StudyTime::tick) {
    add(chart_of(found, graph, &WorkPoint::ms_per_s, &WorkPoint::front_run, "CPU ms per simulated second"), "run");
  }
  if (found.time != StudyTime::run) {
    add(chart_of(found, graph, &WorkPoint::us_per_tick, &WorkPoint::front_tick, "methods, CPU µs a tick"), "tick");
  }
  return charts;
}

std::string chart_file(const std::string& graph) {
  std::string out = "work_precision_" + graph;
  std::replace(out.begin(), out.end(), ' ', '_');
  return out;
}

std::string spread_text(const Spread& s) {
  if (!std::isfinite(s.centre)) return "-";
  if (!s.has_sides()) return pretty(s.centre);
  return fmt::format("{} [{}, {}]", pretty(s.centre), pretty(s.low), pretty(s.high));
}

std::string point_name(const WorkPoint& p) {
  const std::string name = p.curve + (p.curve.empty() || p.values.empty() ? "" : " ") + p.values;
  return name.empty() ? "as it is" : name;
}

std::string front_text(const WorkPoint& p) {
  if (p.incomplete()) {
    return (p.bound ? "a bound, " : "") + of_seeds(p.seeds_done, p.seeds);
  }
  if (!p.judged) return "not ranked";
  if (p.bound) return "a bound";
  return std::string(p.front_run ? "run" : "") + (p.front_run && p.front_tick ? ", " : "") +
         (p.front_tick ? "tick" : "");
}

std::string table_html(const WorkPrecision& found, const WorkGraph& graph) {
  std::string html =
      "<div class=\"wide\"><table><thead><tr><th></th><th>" + escape(found.error_label) +
      "</th><th>CPU ms per simulated second</th><th>methods, µs a tick</th><th>not undercut by</th></tr></thead>"
      "<tbody>\n";
  for (const WorkPoint& p : graph.points) {
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", escape(point_name(p)),
                        spread_text(p.error), spread_text(p.ms_per_s), spread_text(p.us_per_tick), front_text(p));
  }
  return html + "</tbody></table></div>\n";
}

}  // namespace

Spread spread_of(std::span<const double> values) {
  std::vector<double> logs;
  for (const double v : values) logs.push_back(v > 0 ? std::log(v) : std::nan(""));
  const double centre = mean(logs);
  const double sd = logs.size() < 2 ? std::nan("") : standard_deviation(logs);
  return {std::exp(centre), std::exp(centre - sd), std::exp(centre + sd)};
}

std::vector<bool> pareto_front(std::span<const double> x, std::span<const double> y) {
  std::vector<bool> front(x.size(), false);
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(y[i])) continue;
    front[i] = true;
    for (std::size_t j = 0; j < x.size(); ++j) {
      if (x[j] <= x[i] && y[j] <= y[i] && (x[j] < x[i] || y[j] < y[i])) front[i] = false;
    }
  }
  return front;
}

WorkPrecision work_precision(const Study& study) {
  WorkPrecision found{study.spec.error, study.spec.error, Better::lower, study.spec.time, {}};
  if (const MetricInfo* info = study.comparison.info(study.spec.error)) {
    const std::string unit = unit_text(info->unit);
    found.error_label = info->doc + (unit.empty() ? "" : ", ") + unit;
    found.better = info->better;
  }
  const std::size_t count = study.spec.graphs.size();
  std::vector<std::size_t> all;
  for (std::size_t g = 0; g < count; ++g) {
    all.push_back(g);
    found.graphs.push_back(points_of(study, study.comparison.rows[g * study.configurations.size()].graph, {g}));
  }
  if (count > 1) found.graphs.push_back(points_of(study, fmt::format("all {} graphs", count), all));
  for (WorkGraph& graph : found.graphs) mark_fronts(graph, study.spec.time, found.better);
  return found;
}

std::string work_precision_table(const Study& study, const WorkPrecision& found, std::size_t columns) {
  std::string out =
      fmt::format("\n{}: {} over {} seed{} (geometric mean, one geometric deviation)\n", study.spec.name, found.error,
                  study.comparison.seeds.size(), study.comparison.seeds.size() == 1 ? "" : "s");
  using enum TextTable::Align;
  for (const WorkGraph& graph : found.graphs) {
    TextTable table({{""},
                     {"error", right},
                     {"CPU ms per simulated s", right},
                     {"methods, us a tick", right},
                     {"not undercut by"}});
    for (const WorkPoint& p : graph.points) {
      table.add(
          {point_name(p), spread_text(p.error), spread_text(p.ms_per_s), spread_text(p.us_per_tick), front_text(p)});
    }
    out += fmt::format("\n{}\n{}", graph.graph, table.text(columns));
  }
  return wrapped(out + lines_of(timing_note(study)), columns);
}

Json to_json(const WorkPrecision& found) {
  const auto spread = [&](const Spread& s) {
    return Json{{"centre", number_json(s.centre)}, {"low", number_json(s.low)}, {"high", number_json(s.high)}};
  };
  Json json{{"error", found.error}, {"graphs", Json::array()}};
  for (const WorkGraph& graph : found.graphs) {
    Json points = Json::array();
    for (const WorkPoint& p : graph.points) {
      points.push_back({{"curve", p.curve},
                        {"values", p.values},
                        {"error", spread(p.error)},
                        {"cpu_ms_per_s", spread(p.ms_per_s)},
                        {"method_us_per_tick", spread(p.us_per_tick)},
                        {"bound", p.bound},
                        {"seeds_done", p.seeds_done},
                        {"seeds", p.seeds},
                        {"front_run", p.front_run},
                        {"front_tick", p.front_tick}});
    }
    json["graphs"].push_back({{"graph", graph.graph}, {"points", points}});
  }
  return json;
}

std::string write_work_precision(const std::filesystem::path& folder, const Study& study, const WorkPrecision& found) {
  const TimingNote timing = timing_note(study);
  const bool incomplete = std::any_of(found.graphs.begin(), found.graphs.end(), [](const WorkGraph& graph) {
    return std::any_of(graph.points.begin(), graph.points.end(), [](const WorkPoint& p) { return p.incomplete(); });
  });
  std::string body = fmt::format(
      "<p class=\"sub\">{}{}{} seed{} from {}; tactor {}</p>\n<p>Marks are geometric means over the seeds, bars reach "
      "one geometric standard deviation over the seeds to each side; {}both axes are logarithmic. A ring marks what "
      "nothing undercuts: no other method has a {} error in as little time. {}{}{}</p>\n",
      escape(study.spec.title), study.spec.title.empty() ? "" : " · ", study.comparison.seeds.size(),
      study.comparison.seeds.size() == 1 ? "" : "s", study.comparison.seeds.front(), TACTOR_VERSION,
      found.graphs.size() > 1 ? "over all graphs, each seed has the geometric mean of theirs; " : "",
      found.better == Better::higher ? "larger" : "smaller",
      study.spec.bounds.empty() ? "" : "Hollow marks are bounds, which no method can undercut. ",
      incomplete ? "A cross marks a method that lacks seeds because runs failed. It shows the existing seeds only, and "
                   "is excluded from the Pareto front, because the missing seeds may be the hard ones. "
                 : "",
      escape(timing.text));
  body += warnings_html(comparison_warnings(study.comparison));
  if (!timing.warning.empty()) body += "<p class=\"bad\">" + escape(timing.warning) + "</p>\n";
  // What is over all graphs comes first.
  std::vector<const WorkGraph*> order;
  if (found.graphs.size() > 1) order.push_back(&found.graphs.back());
  for (std::size_t g = 0; g < study.spec.graphs.size(); ++g) order.push_back(&found.graphs[g]);
  for (const WorkGraph* graph : order) {
    body += "<h2>" + escape(graph->graph) + "</h2>\n";
    const std::vector<Chart> charts = charts_of(found, *graph);
    if (!charts.empty()) {
      int height = chart_height;
      for (const Chart& chart : charts) height = std::max(height, key_line * static_cast<int>(named_curves(chart)));
      const std::string svg = draw(charts, PictureFormat::svg, chart_width, height);
      write_file(folder / (chart_file(graph->graph) + ".svg"), svg);
      const std::string png = draw(charts, PictureFormat::png, chart_width, height);
      if (!png.empty()) write_file(folder / (chart_file(graph->graph) + ".png"), png);
      body += figure_html(svg, charts, height);
    }
    body += table_html(found, *graph);
    const auto index = static_cast<std::size_t>(graph - found.graphs.data());
    if (index < study.spec.graphs.size()) body += named_metrics_html(study, index);
  }
  const std::string failures = failures_text(study.comparison);
  if (!failures.empty()) body += "<h2>Runs that failed</h2>\n<pre>" + escape(failures) + "</pre>\n";
  body += where_html(study.comparison);
  return page(study.spec.name, body);
}

}  // namespace tactor
