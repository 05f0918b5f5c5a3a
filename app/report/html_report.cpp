#include "app/report/html_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/report/chart.hpp"
#include "app/report/html_page.hpp"
#include "app/run/summary.hpp"

namespace tactor {

namespace {

/// Every k-th value, so that a long curve stays light; k keeps at most `most` of them.
Curve thinned(const Series& series, std::string name, std::string color, std::size_t most = 3500) {
  Curve curve;
  curve.name = std::move(name);
  curve.color = std::move(color);
  const std::size_t step = std::max<std::size_t>(1, series.time.size() / most);
  for (std::size_t i = 0; i < series.time.size(); i += step) {
    curve.x.push_back(series.time[i]);
    curve.y.push_back(series.value[i]);
  }
  return curve;
}

Curve cut(const Series& series, std::string name, std::string color, std::pair<double, double> range) {
  Curve curve;
  curve.name = std::move(name);
  curve.color = std::move(color);
  // One sample beyond each end, so that lines reach the border and steps begin with the value held before.
  for (std::size_t i = 0; i < series.time.size(); ++i) {
    const bool before = i + 1 < series.time.size() && series.time[i + 1] < range.first;
    const bool after = i > 0 && series.time[i - 1] > range.second;
    if (before || after) continue;
    curve.x.push_back(series.time[i]);
    curve.y.push_back(series.value[i]);
  }
  return curve;
}

/// The 150 ms in which the reference moves most, where there is one: that is where methods differ.
std::pair<double, double> liveliest_window(const RunResult& run) {
  constexpr double length = 0.150;
  const Series* force = run.curve("reference.norm");
  if (force == nullptr) force = run.curve("commanded.norm");
  if (force == nullptr || force->time.size() < 3) return {0, length};
  const std::vector<double>& t = force->time;
  const std::vector<double>& f = force->value;
  std::vector<double> path(f.size(), 0.0);
  for (std::size_t i = 1; i < f.size(); ++i) path[i] = path[i - 1] + std::abs(f[i] - f[i - 1]);
  std::size_t begin = 0;
  double best = -1;
  double at = t.front();
  for (std::size_t end = 0; end < t.size(); ++end) {
    while (t[end] - t[begin] > length) ++begin;
    if (path[end] - path[begin] > best && t[begin] > 0.3) {
      best = path[end] - path[begin];
      at = t[begin];
    }
  }
  return {at, at + length};
}

/// The axis on which the commanded force varies most: the one to look at in a zoom.
std::string liveliest_axis(const RunResult& run, std::pair<double, double> range) {
  std::string best = "x";
  double most = -1;
  for (const char* axis : {"x", "y", "z"}) {
    const Series* s = run.curve(std::string("commanded.") + axis);
    if (s == nullptr) continue;
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (std::size_t i = 0; i < s->time.size(); ++i) {
      if (s->time[i] < range.first || s->time[i] > range.second) continue;
      low = std::min(low, s->value[i]);
      high = std::max(high, s->value[i]);
    }
    if (high - low > most) {
      most = high - low;
      best = axis;
    }
  }
  return best;
}

/// Force, displacement, contacts and physics rate over the whole run.
std::vector<Chart> four_rows(const RunResult& run) {
  std::vector<Chart> charts;
  const std::pair<double, double> range{0, run.duration_s};
  Chart force{"Force on the device", "", "N", {}, range};
  if (const Series* s = run.curve("reference.norm")) {
    force.curves.push_back(thinned(*s, "reference", "#555555"));
  }
  if (const Series* s = run.curve("commanded.norm")) {
    force.curves.push_back(thinned(*s, "commanded", series_color(0)));
  }
  if (!force.curves.empty()) charts.push_back(std::move(force));
  struct Row {
    const char* series;
    const char* title;
    const char* unit;
    bool steps;
  };
  for (const Row& row : {Row{"displacement", "Device displacement", "m", false}, Row{"contacts", "Contacts", "", true},
                         Row{"physics_rate", "Physics rate", "Hz", true}}) {
    const Series* s = run.curve(row.series);
    if (s == nullptr || s->time.empty()) continue;
    Chart chart{row.title, "", row.unit, {thinned(*s, "", series_color(0))}, range};
    chart.curves.front().steps = row.steps;
    charts.push_back(std::move(chart));
  }
  if (!charts.empty()) charts.back().x_label = "time s";
  return charts;
}

std::string figures_table(const RunResult& run) {
  std::string rows;
  for (const auto& [name, value] : run.figures) {
    rows += fmt::format("<tr><td>{}</td><td>{}</td></tr>\n", escape(name), pretty(value));
  }
  return "<table><thead><tr><th>figure</th><th>value</th></tr></thead><tbody>\n" + rows + "</tbody></table>\n";
}

std::string cost_table(const RunResult& run) {
  std::string rows;
  for (const NodeCost& node : run.nodes) {
    rows +=
        fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", escape(node.node),
                    escape(node.type), node.steps, pretty(node.median_us), pretty(node.p99_us), pretty(node.total_s));
  }
  return "<table><thead><tr><th>node</th><th>type</th><th>steps</th><th>median µs</th><th>p99 µs</th><th>CPU "
         "s</th></tr></thead><tbody>\n" +
         rows + "</tbody></table>\n";
}

std::string edge_table(const RunResult& run) {
  std::string rows;
  for (const EdgeResult& edge : run.edges) {
    rows += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", escape(edge.edge),
                        escape(edge.queue), edge.figures.delivered, edge.figures.dropped, edge.figures.superseded);
  }
  return "<table><thead><tr><th>edge</th><th>queue</th><th>delivered</th><th>dropped</th><th>superseded</th></tr>"
         "</thead><tbody>\n" +
         rows + "</tbody></table>\n";
}

std::string chosen_and_left_out(const RunResult& run) {
  std::string items;
  for (const Chosen& c : run.chosen) {
    items +=
        fmt::format("<li>node {}: {} is {}: {}</li>\n", escape(c.node), escape(c.asked), escape(c.type), escape(c.why));
  }
  if (run.left_out.empty()) items += "<li>nothing was left out</li>\n";
  for (const LeftOut& item : run.left_out) {
    items += fmt::format("<li>{}: {}</li>\n", escape(item.what), escape(item.why));
  }
  return "<ul>" + items + "</ul>\n";
}

Chart zoom_on(const RunResult& run, std::pair<double, double> range, const std::string& axis) {
  Chart chart{fmt::format("150 ms, force along {}", axis), "time s", "N", {}, range};
  if (const Series* s = run.curve("reference." + axis)) {
    chart.curves.push_back(cut(*s, "reference", "#000000", range));
    chart.curves.back().dashed = true;
  }
  return chart;
}

Curve arrivals(const RunResult& run, std::pair<double, double> range, const std::string& axis) {
  Curve curve;
  if (const Series* s = run.curve("physics." + axis)) curve = cut(*s, "physics results, on arrival", "#888888", range);
  curve.points = true;
  return curve;
}

std::string ratio_cell(const std::optional<GeometricMean>& m) {
  return m ? fmt::format("<td>{:.3f} [{:.3f}, {:.3f}]</td>", m->ratio, m->low, m->high) : "<td>-</td>";
}

std::string study_head(const Study& study, bool figures) {
  std::string head = "<tr><th></th><th>delivered RMS, ratio</th><th>one-step RMS, ratio</th>";
  for (const Column& column : study.comparison.columns) {
    if (figures) head += "<th>" + escape(column.label) + "</th>";
  }
  return "<div class=\"wide\"><table><thead>" + head + "</tr></thead><tbody>\n";
}

std::string study_graph_html(const Study& study, std::size_t first) {
  const Comparison& comparison = study.comparison;
  std::string html = "<h2>" + escape(comparison.rows[first].graph) + "</h2>\n" + study_head(study, true);
  for (std::size_t row = first; row < first + study.settings.size(); ++row) {
    html += "<tr><td>" + escape(comparison.rows[row].setting) + "</td>" + ratio_cell(study.ratios[row].delivered) +
            ratio_cell(study.ratios[row].one_step);
    for (const std::vector<double>& values : comparison.rows[row].values) {
      html += fmt::format("<td>{} ± {}</td>", pretty(mean(values)), pretty(standard_deviation(values)));
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

/// Error over all graphs against run time, a mark a setting; empty where there is nothing to show.
std::string study_chart(const Study& study) {
  Chart chart{"Error against run time", "prediction and interpolation, µs a device tick", "RMS error, ratio", {}, {}};
  chart.log_x = true;
  for (std::size_t s = 0; s < study.settings.size(); ++s) {
    const std::optional<GeometricMean>& error = study.settings[s].over_graphs.delivered;
    const double us = study.over_graphs(s, "method_us_per_tick");
    if (!error || !(us > 0)) continue;
    chart.curves.push_back({study.comparison.rows[s].setting, {us}, {error->ratio}, series_color(s), true});
    chart.curves.back().mark = s / series_colors;
  }
  return chart.curves.size() < 2 ? "" : draw_svg({chart}, 1160, 420);
}

std::string compare_row_html(const Comparison& comparison, std::size_t c) {
  std::string row = fmt::format("<tr><td>{}</td>", escape(comparison.columns[c].label));
  for (const CompareRow& graph : comparison.rows) {
    const std::vector<double>& values = graph.values[c];
    row +=
        fmt::format("<td>{}</td><td class=\"sd\">± {}</td>", pretty(mean(values)), pretty(standard_deviation(values)));
  }
  return row + "</tr>\n";
}

std::string difference_cells(const std::optional<PairedDifference>& d) {
  if (!d) return "<td>-</td><td>-</td><td>-</td><td>-</td>";
  return fmt::format("<td>{:+.4f}</td><td>[{:+.4f}, {:+.4f}]</td><td>{:+.2f}</td><td>{}</td>", d->mean, d->low, d->high,
                     d->effect_size, pretty(d->p_wilcoxon));
}

/// Every row that is judged against another; `against` says which that is.
std::string significance_table(const Comparison& comparison, const std::string& against) {
  std::string rows;
  for (std::size_t i = 0; i < comparison.rows.size(); ++i) {
    const CompareRow& row = comparison.rows[i];
    if (row.against == i) continue;
    rows += fmt::format("<tr><td>{} {}</td>", escape(row.graph), escape(row.setting));
    rows += row.one_step_anova
                ? fmt::format("<td>{}</td><td>{}</td>", pretty(row.one_step_anova->F), pretty(row.one_step_anova->p))
                : "<td>-</td><td>-</td>";
    rows += difference_cells(row.one_step) + difference_cells(row.delivered) + "</tr>\n";
  }
  if (rows.empty()) return {};
  return fmt::format(
      "<h2>Against {}</h2>\n<p>The ANOVA takes every one-step error for an independent sample, as the paper does; "
      "they are not (neighbours are correlated) and F has no sign. The paired differences are over seeds, with their "
      "95 % confidence interval; below zero is better. Wilcoxon's p cannot go below 2 / 2^n for n seeds, so fewer than "
      "6 "
      "never reach .05.</p>\n"
      "<div class=\"wide\"><table><thead><tr><th></th><th>ANOVA F</th><th>p</th><th>one-step RMS N</th><th>95 %</th>"
      "<th>effect d</th><th>Wilcoxon p</th><th>delivered RMS N</th><th>95 %</th><th>effect d</th><th>Wilcoxon p</th>"
      "</tr></thead><tbody>\n{}</tbody></table></div>\n",
      escape(against), rows);
}

std::string timing_html(const TimingNote& timing) {
  const std::string warning = timing.warning.empty() ? "" : "<p class=\"bad\">" + escape(timing.warning) + "</p>\n";
  return "<p>" + escape(timing.text) + "</p>\n" + warning;
}

}  // namespace

std::string run_report(const RunResult& run) {
  const std::string time = run.live ? "live" : fmt::format("of virtual time in {} s", pretty(run.wall_s));
  std::string body = fmt::format("<p class=\"sub\">{}{}seed {}, {} s {}, {} MB, tactor {}</p>\n", escape(run.title),
                                 run.title.empty() ? "" : " · ", run.seed, pretty(run.duration_s), time,
                                 pretty(run.peak_memory_MB), TACTOR_VERSION);
  if (run.failure) body += "<p class=\"bad\">The run has failed: " + escape(*run.failure) + "</p>\n";
  if (run.interrupted) body += "<p>The run was ended early.</p>\n";
  if (run.live) {
    for (const std::string& text : run.live->missing) body += "<p>Real time degraded: " + escape(text) + "</p>\n";
  }
  const std::vector<Chart> rows = four_rows(run);
  if (!rows.empty()) body += "<h2>The run</h2>\n" + draw_svg(rows, 1160, 210);
  const std::pair<double, double> range = liveliest_window(run);
  const std::string axis = liveliest_axis(run, range);
  Chart zoom = zoom_on(run, range, axis);
  if (const Series* s = run.curve("commanded." + axis))
    zoom.curves.push_back(cut(*s, "commanded", series_color(0), range));
  if (!zoom.curves.empty()) {
    zoom.curves.push_back(arrivals(run, range, axis));
    body += "<h2>Zoom</h2>\n" + draw_svg({zoom}, 1160, 360);
  }
  body += "<h2>Figures</h2>\n" + figures_table(run);
  body += "<h2>Run time</h2>\n<p>CPU time of each step on one core.</p>\n" + cost_table(run);
  body += "<h2>Edges</h2>\n" + edge_table(run);
  body += "<h2>Chosen and left out</h2>\n" + chosen_and_left_out(run);
  body += "<h2>Graph, resolved</h2>\n<pre>" + escape(run.graph_yaml) + "</pre>\n";
  return page(run.graph, body);
}

std::string compare_report(const Comparison& comparison, const TimingNote& timing) {
  std::string names;
  for (const CompareRow& row : comparison.rows) names += (names.empty() ? "" : ", ") + row.graph;
  std::string body = fmt::format("<p class=\"sub\">mean ± standard deviation over {} seed{}; tactor {}</p>\n",
                                 comparison.seeds.size(), comparison.seeds.size() == 1 ? "" : "s", TACTOR_VERSION);
  body += "<ul>\n";
  for (const CompareRow& row : comparison.rows) {
    body += fmt::format("<li><b>{}</b>: {}</li>\n", escape(row.graph), escape(row.title));
  }
  body += "</ul>\n";

  std::string head = "<tr><th></th>";
  for (const CompareRow& row : comparison.rows) head += fmt::format("<th colspan=\"2\">{}</th>", escape(row.graph));
  std::string rows = fmt::format("<tr class=\"group\"><td colspan=\"{}\">error, delay, smoothness</td></tr>\n",
                                 1 + 2 * comparison.rows.size());
  bool in_run_times = false;
  for (std::size_t c = 0; c < comparison.columns.size(); ++c) {
    if (comparison.columns[c].run_time && !in_run_times) {
      rows += fmt::format("<tr class=\"group\"><td colspan=\"{}\">run time (CPU, median of a step)</td></tr>\n",
                          1 + 2 * comparison.rows.size());
      in_run_times = true;
    }
    rows += compare_row_html(comparison, c);
  }
  body += "<h2>Error and run time</h2>\n<div class=\"wide\"><table><thead>" + head + "</tr></thead><tbody>\n" + rows +
          "</tbody></table></div>\n" + timing_html(timing);
  body += significance_table(comparison, comparison.rows.front().graph);

  const RunResult& first = comparison.rows.front().runs.front();
  const std::pair<double, double> range = liveliest_window(first);
  const std::string axis = liveliest_axis(first, range);
  Chart zoom = zoom_on(first, range, axis);
  Chart whole{"Force on the device, seed " + std::to_string(first.seed),
              "time s",
              "N",
              {},
              std::pair<double, double>{0, first.duration_s}};
  if (const Series* s = first.curve("reference.norm")) whole.curves.push_back(thinned(*s, "reference", "#555555"));
  Chart pareto{"Error against run time", "CPU ms per second of virtual time", "delivered RMS error N", {}, {}};
  Chart trade{"Error against smoothness", "RMS second difference N/ms²", "delivered RMS error N", {}, {}};
  trade.log_x = true;
  for (std::size_t i = 0; i < comparison.rows.size(); ++i) {
    const CompareRow& row = comparison.rows[i];
    const RunResult& run = row.runs.front();
    if (const Series* s = run.curve("commanded." + axis)) {
      zoom.curves.push_back(cut(*s, row.graph, series_color(i), range));
    }
    if (const Series* s = run.curve("commanded.norm")) {
      whole.curves.push_back(thinned(*s, row.graph, series_color(i)));
      whole.curves.back().width = 1.0;
    }
    Curve cost{row.graph, {}, {}, series_color(i), true};
    Curve roughness{row.graph, {}, {}, series_color(i), true};
    for (const RunResult& r : row.runs) {
      cost.x.push_back(1e3 * r.cpu_s / r.duration_s);
      cost.y.push_back(r.figure("delivered.force.rms_error_N"));
      roughness.x.push_back(r.figure("delivered.force.rms_d2_N_per_ms2"));
      roughness.y.push_back(r.figure("delivered.force.rms_error_N"));
    }
    pareto.curves.push_back(std::move(cost));
    trade.curves.push_back(std::move(roughness));
  }
  zoom.curves.push_back(arrivals(first, range, axis));
  body += "<h2>150 ms of the methods against the reference</h2>\n" + draw_svg({zoom}, 1160, 420);
  body += "<h2>The whole run</h2>\n" + draw_svg({whole}, 1160, 320);
  bool any_error = false;
  for (const CompareRow& row : comparison.rows) {
    any_error = any_error || std::isfinite(row.runs.front().figure("delivered.force.rms_error_N"));
  }
  if (any_error) {
    body += "<h2>Error against run time, and against smoothness</h2>\n<p>One mark a seed.</p>\n" +
            draw_svg({pareto, trade}, 1160, 330);
  }
  for (const CompareRow& row : comparison.rows) {
    const std::vector<Chart> charts = four_rows(row.runs.front());
    if (charts.empty()) continue;
    body += "<h2>" + escape(row.graph) + "</h2>\n" + draw_svg(charts, 1160, 190) +
            "<p>Chosen and left out in this graph:</p>\n" + chosen_and_left_out(row.runs.front());
  }
  return page(names, body);
}

std::string study_report(const Study& study) {
  const Comparison& comparison = study.comparison;
  const std::size_t settings = study.settings.size();
  std::string body = fmt::format(
      "<p class=\"sub\">{}{}mean ± standard deviation over {} seed{} from {}; ratios are to the first line, by the "
      "geometric mean, with their 95 % confidence interval over seeds; tactor {}</p>\n",
      escape(study.spec.title), study.spec.title.empty() ? "" : " · ", comparison.seeds.size(),
      comparison.seeds.size() == 1 ? "" : "s", comparison.seeds.front(), TACTOR_VERSION);
  if (study.spec.graphs.size() > 1) {
    body += "<h2>All graphs</h2>\n" + study_head(study, false);
    for (std::size_t s = 0; s < settings; ++s) {
      const ErrorRatio& ratio = study.settings[s].over_graphs;
      body += "<tr><td>" + escape(comparison.rows[s].setting) + "</td>" + ratio_cell(ratio.delivered) +
              ratio_cell(ratio.one_step) + "</tr>\n";
    }
    body += "</tbody></table></div>\n";
  }
  body += study_chart(study);
  for (std::size_t first = 0; first < comparison.rows.size(); first += settings) body += study_graph_html(study, first);
  body += timing_html(timing_note(study));
  body += significance_table(comparison, "the first line of each graph");
  return page(study.spec.name, body);
}

}  // namespace tactor
