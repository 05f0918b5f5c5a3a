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
#include "app/study/report/verdict.hpp"
#include "app/study/table/warnings.hpp"
#include "app/study/table/where.hpp"

namespace tactor {

namespace {

/// What a table's head says of a metric, with the definition.
std::string head_text(const Comparison& comparison, const Column& column) {
  return defined(breakable(head_of(comparison, column)), comparison.info(column.metric));
}

/// The deviation of the values, which fewer than two do not have.
std::string deviation(const std::vector<double>& values) {
  return values.size() < 2 ? "-" : pretty(standard_deviation(values));
}

HtmlTable table_of_study(const Study& study, bool metrics) {
  std::vector<std::string> heads{"", "delivered RMS, ratio", "5 to 95 % of seeds", "worst (seed)",
                                 "one-step RMS, ratio"};
  for (const Column& column : study.comparison.columns) {
    if (metrics) heads.push_back(head_text(study.comparison, column));
  }
  return HtmlTable(std::move(heads));
}

std::vector<std::string> study_cells(const Study& study, const std::string& name, const ErrorRatio& ratio,
                                     const std::optional<SeedSpread>& spread) {
  const std::size_t seeds = study.comparison.seeds.size();
  return {escape(name), ratio_text(ratio.delivered, seeds), quantiles_text(spread, ratio_number),
          worst_text(spread, ratio_number), ratio_text(ratio.one_step, seeds)};
}

/// Which part of the runs is judged, and by which definitions.
std::string judged_html(const Comparison& comparison) {
  std::string html;
  for (const std::string& sentence : judged_sentences(comparison)) html += "<li>" + escape(sentence) + "</li>\n";
  return "<ul>\n" + html + "</ul>\n";
}

/// On a wide screen a table of many metrics is scrolled in its frame.
std::string in_frame(const HtmlTable& table) {
  return "<div class=\"wide\">" + table.html() + "</div>\n";
}

std::string study_graph_html(const Study& study, std::size_t first) {
  const Comparison& comparison = study.comparison;
  HtmlTable table = table_of_study(study, true);
  std::string remarks;
  for (std::size_t row = first; row < first + study.configurations.size(); ++row) {
    const std::string seeds = comparison.rows[row].seeds_text();
    std::vector<std::string> cells =
        study_cells(study, comparison.rows[row].configuration + (seeds.empty() ? "" : " (" + seeds + ")"),
                    study.ratios[row], study.spreads[row]);
    for (const std::vector<double>& by_seed : comparison.rows[row].values) {
      const std::vector<double> values = comparison.rows[row].done(by_seed);
      cells.push_back(fmt::format("{} ± {}", pretty(mean(values)), deviation(values)));
    }
    table.add(cells);
    if (const std::string two = populations_text(study.spreads[row]); !two.empty()) {
      remarks += "<p>" + escape(label(study.configuration(row)) + ": " + two) + "</p>\n";
    }
  }
  return "<h2>" + escape(comparison.rows[first].graph) + "</h2>\n" + in_frame(table) + remarks;
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
  return chart.curves.size() < 2 ? "" : chart_figure({chart}, 1160, 420);
}

/// The mean, marked where it is the best of its row, and the deviation.
std::string compare_cell(const std::vector<double>& values, bool best) {
  const char* mark = best ? " <span role=\"img\" aria-label=\"best\">★</span>" : "";
  std::string html =
      fmt::format("<span><span class=\"{}\">{}{}</span>", best ? "value best" : "value", pretty(mean(values)), mark);
  if (values.size() > 1 && std::isfinite(mean(values)))
    html += " <span class=\"sd\">± " + deviation(values) + "</span>";
  return html + "</span>";
}

/// As many methods as are readable beside each other at 1,280 pixels; more go into further tables.
constexpr std::size_t most_beside = 12;

/// A row a metric, a column a method.
std::string compare_tables(const Comparison& comparison) {
  const std::size_t count = comparison.rows.size();
  const std::size_t tables = (count + most_beside - 1) / most_beside;
  std::string html;
  for (std::size_t part = 0; part < tables; ++part) {
    const std::size_t begin = part * count / tables, end = (part + 1) * count / tables;
    std::vector<std::string> heads{""};
    for (std::size_t row = begin; row < end; ++row) heads.push_back(breakable(comparison.rows[row].name()));
    HtmlTable table(std::move(heads));
    table.make_even();
    table.add_group("error, delay, smoothness");
    bool in_run_times = false;
    for (std::size_t c = 0; c < comparison.columns.size(); ++c) {
      if (comparison.columns[c].run_time && !in_run_times) {
        table.add_group("run time (CPU, median of a step)");
        in_run_times = true;
      }
      const Ranking order = ranking(comparison, c);
      std::vector<std::string> cells{head_text(comparison, comparison.columns[c])};
      for (std::size_t row = begin; row < end; ++row) {
        cells.push_back(compare_cell(comparison.rows[row].done(comparison.rows[row].values[c]), order.is_best(row)));
      }
      table.add(cells);
      if (comparison.columns[c].metric != delivered_error || comparison.seeds.size() < 2) continue;
      std::vector<std::string> quantiles{"5 to 95 % of seeds"}, worst{"worst (seed)"};
      for (std::size_t row = begin; row < end; ++row) {
        const auto spread = seed_spread(comparison.seeds, comparison.rows[row].values[c]);
        quantiles.push_back(quantiles_text(spread, pretty));
        worst.push_back(worst_text(spread, pretty));
      }
      table.add(quantiles);
      table.add(worst);
    }
    html += table.html();
  }
  return html;
}

void add_difference(std::vector<std::string>& cells, const std::optional<PairedDifference>& d, std::size_t seeds) {
  if (!d) {
    cells.insert(cells.end(), 4, "-");
    return;
  }
  cells.push_back(fmt::format("{:+.4f}", d->mean));
  const std::string interval = d->interval ? fmt::format("[{:+.4f}, {:+.4f}]", d->interval->low, d->interval->high)
                               : d->identical == Identical::no ? std::string("-")
                                                               : identical_text(*d);
  cells.push_back(interval + over_seeds(d->pairs, seeds));
  cells.push_back(d->effect_size ? fmt::format("{:+.2f}", *d->effect_size) : "-");
  cells.push_back(d->p_wilcoxon ? pretty(*d->p_wilcoxon) : "-");
}

/// Every row that is compared with another; `against` says which that is.
std::string significance_table(const Comparison& comparison, const std::string& against) {
  HtmlTable table({"", "ANOVA F", "ANOVA p", "one-step RMS N", "95 %", "effect d", "Wilcoxon p", "delivered RMS N",
                   "95 %", "effect d", "Wilcoxon p"});
  bool any = false;
  for (std::size_t i = 0; i < comparison.rows.size(); ++i) {
    const CompareRow& row = comparison.rows[i];
    if (row.against == i) continue;
    any = true;
    const std::size_t seeds = comparison.seeds.size();
    std::vector<std::string> cells{breakable(row.name()), "-", "-"};
    if (row.one_step_anova) {
      cells[1] = pretty(row.one_step_anova->F) + over_seeds(judged_seeds(comparison, row), seeds);
      cells[2] = row.one_step_anova->p > 0 ? pretty(row.one_step_anova->p) : "&lt; 1e-300";
    }
    add_difference(cells, row.one_step, seeds);
    add_difference(cells, row.delivered, seeds);
    table.add(cells);
  }
  if (!any) return {};
  return fmt::format(
      "<h2>Against {}</h2>\n<p>The ANOVA takes every one-step error for an independent sample, as the paper does; "
      "they are not (neighbours are correlated) and F has no sign. The paired differences are over seeds, with their "
      "95 % confidence interval; below zero is better. Wilcoxon's p is counted over all signs, with ties too, and "
      "leaves out seeds without a difference. It cannot go below 2 / 2^n for n seeds, so fewer than 6 never reach .05; "
      "no effect size is told of them. Seeds whose runs are identical tell nothing of chance and are not "
      "tested.</p>\n{}",
      escape(against), table.html());
}

std::string arrows_html() {
  return fmt::format("<p>{}</p>\n", arrows_text);
}

std::string failures_html(const Comparison& comparison) {
  const std::string failures = failures_text(comparison);
  if (failures.empty()) return {};
  return "<h2>Runs that failed</h2>\n<p>Their metrics are missing; means cover only the seeds that "
         "succeeded.</p>\n<pre>" +
         escape(failures) + "</pre>\n";
}

std::string timing_html(const TimingNote& timing) {
  const std::string warning = timing.warning.empty() ? "" : "<p class=\"bad\">" + escape(timing.warning) + "</p>\n";
  return (timing.text.empty() ? "" : "<p>" + escape(timing.text) + "</p>\n") + warning;
}

}  // namespace

std::string compare_report(const Comparison& comparison, const TimingNote& timing, const std::string& scene) {
  std::string names;
  for (const CompareRow& row : comparison.rows) names += (names.empty() ? "" : ", ") + row.graph;
  const std::size_t seeds = comparison.seeds.size();
  std::string body = verdict_html(comparison, timing) + warnings_html(comparison);
  body +=
      fmt::format("<p class=\"sub\">{}; tactor {}</p>\n<ul>\n",
                  seeds == 1 ? std::string("one seed") : fmt::format("mean ± standard deviation over {} seeds", seeds),
                  TACTOR_VERSION);
  for (const CompareRow& row : comparison.rows) {
    body += fmt::format("<li><b>{}</b>: {}</li>\n", breakable(row.name()), escape(row.title));
  }
  body += "</ul>\n" + scene;

  body += "<h2>Error and run time</h2>\n" + judged_html(comparison) + arrows_html() +
          "<p>★: the best of its row, and those that tie with it: equal in three digits, or within the spread of the "
          "seeds</p>\n" +
          compare_tables(comparison) + timing_html(timing);
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
      zoom.curves.back().dashed = i >= series_colors;
    }
    if (const Series* s = run.curve("commanded.norm")) {
      whole.curves.push_back(thinned(*s, row.graph, series_color(i)));
      whole.curves.back().width = 1.0;
      whole.curves.back().dashed = i >= series_colors;
    }
    Curve cost{row.graph, {}, {}, series_color(i), true, i / series_colors};
    Curve roughness = cost;
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
  body += "<h2>150 ms of the methods against the reference</h2>\n" + chart_figure({zoom}, 1160, 420);
  body += "<h2>The whole run</h2>\n" + chart_figure({whole}, 1160, 320);
  bool any_error = false;
  for (const CompareRow& row : comparison.rows) {
    for (const RunResult& run : row.runs) {
      any_error = any_error || std::isfinite(run.metric("delivered.force.rms_error_N"));
    }
  }
  if (any_error) {
    body += "<h2>Error against run time, and against smoothness</h2>\n<p>One mark a seed.</p>\n" +
            chart_figure({pareto, trade}, 1160, 330);
  }
  for (const CompareRow& row : comparison.rows) {
    const std::vector<Chart> charts = four_rows(row.runs.front());
    if (charts.empty()) continue;
    body += "<h2>" + escape(row.graph) + "</h2>\n" + chart_figure(charts, 1160, 190) +
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
  body += warnings_html(comparison) + judged_html(comparison) + arrows_html();
  if (study.spec.graphs.size() > 1) {
    HtmlTable table = table_of_study(study, false);
    for (std::size_t s = 0; s < configurations; ++s) {
      table.add(study_cells(study, comparison.rows[s].configuration + study.incomplete(s), study.ratios_over_graphs[s],
                            study.spreads_over_graphs[s]));
    }
    body += "<h2>All graphs</h2>\n" + in_frame(table);
  }
  body += study_chart(study);
  for (std::size_t first = 0; first < comparison.rows.size(); first += configurations)
    body += study_graph_html(study, first);
  body += timing_html(timing_note(study));
  body +=
      significance_table(comparison, baseline_text(study.spec)) + failures_html(comparison) + where_html(comparison);
  return page(study.spec.name, body);
}

}  // namespace tactor
