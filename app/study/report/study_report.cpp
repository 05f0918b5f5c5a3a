#include "app/study/report/study_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "app/report/chart.hpp"
#include "app/report/html_page.hpp"
#include "app/report/run_curves.hpp"
#include "app/report/run_report.hpp"
#include "app/run/summary.hpp"
#include "app/study/report/text_tables.hpp"
#include "app/study/table/warnings.hpp"

namespace tactor {

namespace {

std::string ratio_cells(const Study& study, const ErrorRatio& ratio) {
  const std::size_t seeds = study.comparison.seeds.size();
  return "<td>" + ratio_text(ratio.delivered, seeds) + "</td><td>" + ratio_text(ratio.one_step, seeds) + "</td>";
}

/// A cell of a table's head, which tells what the metric is where the pointer rests on it.
std::string head_cell(const Comparison& comparison, const Column& column, const char* tag) {
  const MetricInfo* info = comparison.info(column.metric);
  const std::string title = info == nullptr ? "" : " title=\"" + escape(info->doc) + "\"";
  return fmt::format("<{0}{1}>{2}</{0}>", tag, title, escape(head_of(comparison, column)));
}

/// The deviation of the values, which fewer than two do not have.
std::string deviation(const std::vector<double>& values) {
  return values.size() < 2 ? "-" : pretty(standard_deviation(values));
}

std::string study_head(const Study& study, bool metrics) {
  std::string head = "<tr><th></th><th>delivered RMS, ratio</th><th>one-step RMS, ratio</th>";
  for (const Column& column : study.comparison.columns) {
    if (metrics) head += head_cell(study.comparison, column, "th");
  }
  return "<div class=\"wide\"><table><thead>" + head + "</tr></thead><tbody>\n";
}

std::string study_graph_html(const Study& study, std::size_t first) {
  const Comparison& comparison = study.comparison;
  std::string html = "<h2>" + escape(comparison.rows[first].graph) + "</h2>\n" + study_head(study, true);
  for (std::size_t row = first; row < first + study.configurations.size(); ++row) {
    const std::string seeds = comparison.rows[row].seeds_text();
    html += "<tr><td>" + escape(comparison.rows[row].configuration) + (seeds.empty() ? "" : " (" + seeds + ")") +
            "</td>" + ratio_cells(study, study.ratios[row]);
    for (const std::vector<double>& by_seed : comparison.rows[row].values) {
      const std::vector<double> values = comparison.rows[row].done(by_seed);
      html += fmt::format("<td>{} ± {}</td>", pretty(mean(values)), deviation(values));
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

/// Error over all graphs against run time, a mark a configuration; empty where there is nothing to show.
std::string study_chart(const Study& study) {
  // An axis is short; the whole of what a row is compared with stands above the chart.
  std::string y_label = "RMS error, ratio";
  std::string_view before = " to ";
  for (const AxisValue& at : study.spec.baseline) {
    y_label += fmt::format("{}{} {}", std::exchange(before, ", "), at.axis, at.value);
  }
  Chart chart{"Error against run time", "prediction and interpolation, µs a device tick", y_label, {}, {}};
  chart.log_x = true;
  for (std::size_t s = 0; s < study.configurations.size(); ++s) {
    const std::optional<GeometricMean>& error = study.ratios_over_graphs[s].delivered;
    const double us = study.over_graphs(s, "method_us_per_tick");
    if (!error || !(us > 0)) continue;
    chart.curves.push_back(
        {study.comparison.rows[s].configuration + study.incomplete(s), {us}, {error->ratio}, series_color(s), true});
    chart.curves.back().mark = s / series_colors;
    chart.curves.back().hollow = !study.incomplete(s).empty();
  }
  return chart.curves.size() < 2 ? "" : draw_svg({chart}, 1160, 420);
}

std::string compare_row_html(const Comparison& comparison, std::size_t c) {
  std::string row = "<tr>" + head_cell(comparison, comparison.columns[c], "td");
  for (const CompareRow& graph : comparison.rows) {
    const std::vector<double> values = graph.done(graph.values[c]);
    row += fmt::format("<td>{}</td><td class=\"sd\">± {}</td>", pretty(mean(values)), deviation(values));
  }
  return row + "</tr>\n";
}

std::string difference_cells(const std::optional<PairedDifference>& d, std::size_t seeds) {
  if (!d) return "<td>-</td><td>-</td><td>-</td><td>-</td>";
  return fmt::format("<td>{:+.4f}</td><td>[{:+.4f}, {:+.4f}]{}</td><td>{:+.2f}</td><td>{}</td>", d->mean, d->low,
                     d->high, over_seeds(d->pairs, seeds), d->effect_size, pretty(d->p_wilcoxon));
}

/// Every row that is compared with another; `against` says which that is.
std::string significance_table(const Comparison& comparison, const std::string& against) {
  std::string rows;
  for (std::size_t i = 0; i < comparison.rows.size(); ++i) {
    const CompareRow& row = comparison.rows[i];
    if (row.against == i) continue;
    rows += fmt::format("<tr><td>{}</td>", escape(row.name()));
    rows += row.one_step_anova ? fmt::format("<td>{}{}</td><td>{}</td>", pretty(row.one_step_anova->F),
                                             over_seeds(judged_seeds(comparison, row), comparison.seeds.size()),
                                             pretty(row.one_step_anova->p))
                               : "<td>-</td><td>-</td>";
    const std::size_t seeds = comparison.seeds.size();
    rows += difference_cells(row.one_step, seeds) + difference_cells(row.delivered, seeds) + "</tr>\n";
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

std::string arrows_html() {
  return fmt::format("<p>{}</p>\n", arrows_text);
}

std::string failures_html(const Comparison& comparison) {
  const std::string failures = failures_text(comparison);
  if (failures.empty()) return {};
  return "<h2>Runs that failed</h2>\n<p>Their metrics are missing; means are over the seeds that are "
         "there.</p>\n<pre>" +
         escape(failures) + "</pre>\n";
}

std::string timing_html(const TimingNote& timing) {
  const std::string warning = timing.warning.empty() ? "" : "<p class=\"bad\">" + escape(timing.warning) + "</p>\n";
  return (timing.text.empty() ? "" : "<p>" + escape(timing.text) + "</p>\n") + warning;
}

}  // namespace

std::string compare_report(const Comparison& comparison, const TimingNote& timing) {
  std::string names;
  for (const CompareRow& row : comparison.rows) names += (names.empty() ? "" : ", ") + row.graph;
  std::string body = fmt::format("<p class=\"sub\">mean ± standard deviation over {} seed{}; tactor {}</p>\n",
                                 comparison.seeds.size(), comparison.seeds.size() == 1 ? "" : "s", TACTOR_VERSION);
  body += warnings_html(comparison) + "<ul>\n";
  for (const CompareRow& row : comparison.rows) {
    body += fmt::format("<li><b>{}</b>: {}</li>\n", escape(row.name()), escape(row.title));
  }
  body += "</ul>\n";

  std::string head = "<tr><th></th>";
  for (const CompareRow& row : comparison.rows) head += fmt::format("<th colspan=\"2\">{}</th>", escape(row.name()));
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
  body += "<h2>Error and run time</h2>\n" + arrows_html() + "<div class=\"wide\"><table><thead>" + head +
          "</tr></thead><tbody>\n" + rows + "</tbody></table></div>\n" + timing_html(timing);
  body += significance_table(comparison, comparison.rows.front().graph) + failures_html(comparison);

  // Curves are kept of the first seed alone.
  const auto drawn = std::find_if(comparison.rows.begin(), comparison.rows.end(),
                                  [](const CompareRow& row) { return row.status.front() == RunStatus::done; });
  if (drawn == comparison.rows.end()) return page(names, body);
  const RunResult& first = drawn->runs.front();
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
    for (std::size_t s = 0; s < row.runs.size(); ++s) {
      const RunResult& r = row.runs[s];
      if (row.status[s] != RunStatus::done) continue;
      cost.x.push_back(1e3 * r.cpu_s / r.duration_s);
      cost.y.push_back(r.metric("delivered.force.rms_error_N"));
      roughness.x.push_back(r.metric("delivered.force.rms_d2_N_per_ms2"));
      roughness.y.push_back(r.metric("delivered.force.rms_error_N"));
    }
    if (cost.x.empty()) continue;
    pareto.curves.push_back(std::move(cost));
    trade.curves.push_back(std::move(roughness));
  }
  zoom.curves.push_back(arrivals(first, range, axis));
  body += "<h2>150 ms of the methods against the reference</h2>\n" + draw_svg({zoom}, 1160, 420);
  body += "<h2>The whole run</h2>\n" + draw_svg({whole}, 1160, 320);
  bool any_error = false;
  for (const CompareRow& row : comparison.rows) {
    for (const RunResult& run : row.runs) {
      any_error = any_error || std::isfinite(run.metric("delivered.force.rms_error_N"));
    }
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
  const std::size_t configurations = study.configurations.size();
  const std::string ratios = ratios_text(study.spec);
  std::string body = fmt::format(
      "<p class=\"sub\">{}{}mean ± standard deviation over {} seed{} from {}{}; tactor {}</p>\n",
      escape(study.spec.title), study.spec.title.empty() ? "" : " · ", comparison.seeds.size(),
      comparison.seeds.size() == 1 ? "" : "s", comparison.seeds.front(),
      ratios.empty() ? "" : escape(ratios) + ", by the geometric mean, with their 95 % confidence interval over seeds",
      TACTOR_VERSION);
  body += warnings_html(comparison) + arrows_html();
  if (study.spec.graphs.size() > 1) {
    body += "<h2>All graphs</h2>\n" + study_head(study, false);
    for (std::size_t s = 0; s < configurations; ++s) {
      const ErrorRatio& ratio = study.ratios_over_graphs[s];
      body += "<tr><td>" + escape(comparison.rows[s].configuration) + study.incomplete(s) + "</td>" +
              ratio_cells(study, ratio) + "</tr>\n";
    }
    body += "</tbody></table></div>\n";
  }
  body += study_chart(study);
  for (std::size_t first = 0; first < comparison.rows.size(); first += configurations)
    body += study_graph_html(study, first);
  body += timing_html(timing_note(study));
  body += significance_table(comparison, baseline_text(study.spec)) + failures_html(comparison);
  return page(study.spec.name, body);
}

}  // namespace tactor
