#include "app/study/report/compare_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "app/report/chart.hpp"
#include "app/report/figure.hpp"
#include "app/report/html_page.hpp"
#include "app/report/method_style.hpp"
#include "app/report/provenance_html.hpp"
#include "app/report/run_curves.hpp"
#include "app/report/run_report.hpp"
#include "app/run/summary.hpp"
#include "app/study/report/report_parts.hpp"
#include "app/study/report/text_tables.hpp"
#include "app/study/report/verdict.hpp"
#include "app/study/report/work_precision.hpp"
#include "app/study/table/warnings.hpp"

namespace tactor {

namespace {

/// The rows as their page shows them.
struct PageRows {
  std::string title;               ///< of the page
  std::vector<std::string> names;  ///< one a row, without what all names begin with
  std::vector<MethodStyle> styles;
};

/// How long the first words are that all names share: `bunny_` of `bunny_off` and `bunny local`.
std::size_t common_beginning(const std::vector<std::string>& names) {
  const auto is_end = [](char c) { return c == '_' || c == ' '; };
  std::size_t common = 0;
  if (names.size() < 2) return 0;
  for (std::size_t i = 0; i < names.front().size(); ++i) {
    const char mine = names.front()[i];
    const bool all = std::all_of(names.begin(), names.end(), [&](const std::string& name) {
      return i + 1 < name.size() && (name[i] == mine || (is_end(name[i]) && is_end(mine)));
    });
    if (!all) break;
    if (is_end(mine)) common = i + 1;
  }
  return common;
}

PageRows page_rows(const Comparison& comparison) {
  constexpr std::size_t most_named = 6;
  PageRows out;
  for (const CompareRow& row : comparison.rows) out.names.push_back(row.full_name());
  const std::size_t common = common_beginning(out.names);
  if (common > 0) out.title = out.names.front().substr(0, common - 1) + ": ";
  for (std::string& name : out.names) name.erase(0, common);
  out.styles = method_styles(out.names);
  const std::size_t named = out.names.size() > most_named ? most_named / 2 : out.names.size();
  for (std::size_t i = 0; i < named; ++i) out.title += (i == 0 ? "" : ", ") + out.names[i];
  if (named < out.names.size()) out.title += fmt::format(" and {} more", out.names.size() - named);
  return out;
}

/// The head of a row's column: its mark in its colour, its name, and how many seeds are done where some are not.
std::string head_of_row(const Comparison& comparison, const PageRows& shown, std::size_t row) {
  return shown.styles[row].html() + " " + breakable(comparison.rows[row].with_seeds(shown.names[row]));
}

/// The mean, marked where the seeds show it to be the best of its row, and the deviation.
std::string compare_cell(const std::vector<double>& values, bool best) {
  const char* mark = best ? " <span role=\"img\" aria-label=\"best\">★</span>" : "";
  std::string html =
      fmt::format("<span><span class=\"{}\">{}{}</span>", best ? "value best" : "value", pretty(mean(values)), mark);
  if (values.size() > 1 && std::isfinite(mean(values)))
    html += " <span class=\"sd\">± " + deviation(values) + "</span>";
  return html + "</span>";
}

/// A part of the methods, each with a column.
class MethodTable {
 public:
  MethodTable(const Comparison& comparison, const PageRows& shown, std::size_t begin, std::size_t end)
      : comparison_(comparison), begin_(begin), end_(end), table_(heads(comparison, shown, begin, end)) {
    table_.make_even();
  }

  void add_group(const std::string& text) { table_.add_group(text); }
  /// `cell`: HTML for the index of a row of the comparison.
  template <class Cell>
  void add(const std::string& name, const Cell& cell) {
    std::vector<std::string> cells{name};
    for (std::size_t row = begin_; row < end_; ++row) cells.push_back(cell(row));
    table_.add(cells);
  }
  void add_column(const std::string& name, std::size_t column) {
    const std::optional<std::size_t> winner = ranking(comparison_, column).winner;
    add(name, [&](std::size_t row) {
      return compare_cell(comparison_.rows[row].done(comparison_.rows[row].values[column]), winner == row);
    });
  }
  [[nodiscard]] std::string html() const { return table_.html(); }

 private:
  static std::vector<std::string> heads(const Comparison& comparison, const PageRows& shown, std::size_t begin,
                                        std::size_t end) {
    std::vector<std::string> texts{""};
    for (std::size_t row = begin; row < end; ++row) texts.push_back(head_of_row(comparison, shown, row));
    return texts;
  }

  const Comparison& comparison_;
  std::size_t begin_, end_;
  HtmlTable table_;
};

/// As many methods as are readable beside each other at 1,280 pixels; more go into further tables.
constexpr std::size_t most_beside = 12;

/// The tables that `fill` makes of all methods.
template <class Fill>
std::string method_tables(const Comparison& comparison, const PageRows& shown, const Fill& fill) {
  const std::size_t count = comparison.rows.size();
  const std::size_t tables = (count + most_beside - 1) / most_beside;
  std::string html;
  for (std::size_t part = 0; part < tables; ++part) {
    MethodTable table(comparison, shown, part * count / tables, (part + 1) * count / tables);
    fill(table);
    html += table.html();
  }
  return html;
}

/// The first questions of a reader, a row each.
std::string summary_tables(const Comparison& comparison, const PageRows& shown) {
  struct Asked {
    std::string_view metric;
    const char* word;
  };
  static constexpr std::array<Asked, 5> asked{
      {{delivered_error, "RMS error"},
       {"delivered.force.delay_ms", "delay behind the reference"},
       {"delivered.force.rms_d2_N_per_ms2", "roughness"},
       {"delivered.force.vibration_above_threshold_dB", "vibration over what is felt"},
       {"cpu_ms_per_s", "run time"}}};
  return method_tables(comparison, shown, [&](MethodTable& table) {
    for (const Asked& one : asked) {
      const std::optional<std::size_t> column = comparison.column(one.metric);
      if (!column) {
        table.add(one.word, [](std::size_t /*row*/) { return std::string("-"); });
        continue;
      }
      Column named = comparison.columns[*column];
      named.label = with_unit(comparison, one.word, one.metric);
      table.add_column(head_text(comparison, named), *column);
    }
    table.add("verdict on the error", [&](std::size_t row) { return escape(verdict_text(comparison, row)); });
  });
}

/// A row a metric, a column a method.
std::string metric_tables(const Comparison& comparison, const PageRows& shown) {
  return method_tables(comparison, shown, [&](MethodTable& table) {
    table.add_group("error, delay, smoothness");
    bool in_run_times = false;
    for (std::size_t c = 0; c < comparison.columns.size(); ++c) {
      if (comparison.columns[c].run_time && !in_run_times) {
        table.add_group("run time (CPU, median of a step)");
        in_run_times = true;
      }
      table.add_column(head_text(comparison, comparison.columns[c]), c);
      if (comparison.columns[c].metric != delivered_error || comparison.seeds.size() < 2) continue;
      const auto spread = [&](std::size_t row) {
        return seed_spread(comparison.seeds, comparison.rows[row].values[c]);
      };
      if (comparison.seeds.size() >= fewest_seeds)
        table.add("5 to 95 % of seeds", [&](std::size_t row) { return quantiles_text(spread(row), pretty); });
      table.add("worst (seed)", [&](std::size_t row) { return worst_text(spread(row), pretty); });
    }
  });
}

/// A quantity over the seeds that are done.
struct OverSeeds {
  double mean = 0, deviation = 0;
};
OverSeeds over_seeds_of(const CompareRow& row, std::string_view metric, const Comparison& comparison) {
  const std::vector<double> values = row.done(row.metric(metric, comparison.columns));
  return {mean(values), values.size() > 1 ? standard_deviation(values) : 0};
}

/// From a little before the smallest to a little behind the largest; logarithmic where the means are far apart.
struct AxisRange {
  std::pair<double, double> range;
  bool log = false;
};
AxisRange axis_of(const std::vector<OverSeeds>& values) {
  constexpr double far = 8;
  double low = std::numeric_limits<double>::infinity(), high = 0, least = low;
  for (const OverSeeds& v : values) {
    if (!std::isfinite(v.mean)) continue;
    low = std::min(low, v.mean);
    high = std::max(high, v.mean + v.deviation);
    if (v.mean > v.deviation) least = std::min(least, v.mean - v.deviation);
  }
  if (low > 0 && high > far * low) return {{std::min(low, least) / 1.4, high * 1.4}, true};
  return {{0, high * 1.1}, false};
}

/// The ends of a bar; on a logarithmic axis it ends where the axis does.
std::pair<double, double> bar_of(const OverSeeds& value, const AxisRange& axis) {
  const double low = value.mean - value.deviation;
  return {axis.log ? std::max(low, axis.range.first) : low, value.mean + value.deviation};
}

/// The error of each method over what it costs, and the front that none is below.
Chart error_against_run_time(const Comparison& comparison, const PageRows& shown) {
  Chart chart{"Error against run time", "run time: CPU ms per simulated second", "RMS error, N", {}, {}};
  chart.name = "error_over_run_time";
  std::vector<OverSeeds> times, errors;
  std::vector<double> ranked_times, ranked_errors;
  for (std::size_t i = 0; i < comparison.rows.size(); ++i) {
    times.push_back(over_seeds_of(comparison.rows[i], "cpu_ms_per_s", comparison));
    errors.push_back(over_seeds_of(comparison.rows[i], delivered_error, comparison));
    // pareto_front leaves out what is not a number.
    ranked_times.push_back(is_ranked(comparison, i) ? times.back().mean : std::nan(""));
    ranked_errors.push_back(errors.back().mean);
  }
  const std::vector<bool> front = pareto_front(ranked_times, ranked_errors);
  std::vector<std::pair<double, double>> corners;
  for (std::size_t i = 0; i < front.size(); ++i) {
    if (front[i]) corners.emplace_back(times[i].mean, errors[i].mean);
  }
  std::sort(corners.begin(), corners.end());
  const AxisRange x = axis_of(times), y = axis_of(errors);
  chart.log_x = x.log;
  chart.log_y = y.log;
  chart.x_range = x.range;
  if (corners.size() > 1) {
    Curve line{"Pareto front", {}, {}, "#888888"};
    line.dash = 1;
    for (const auto& [time, error] : corners) {
      if (!line.x.empty()) {
        line.x.push_back(time);
        line.y.push_back(line.y.back());
      }
      line.x.push_back(time);
      line.y.push_back(error);
    }
    chart.curves.push_back(std::move(line));
  }
  for (std::size_t i = 0; i < comparison.rows.size(); ++i) {
    const OverSeeds &time = times[i], &error = errors[i];
    if (!std::isfinite(time.mean) || !std::isfinite(error.mean)) continue;
    Curve marks{shown.names[i], {time.mean}, {error.mean}, shown.styles[i].color, true, shown.styles[i].mark};
    if (!is_ranked(comparison, i)) {
      marks.name += " (not ranked)";
      marks.hollow = true;
    }
    if (error.deviation > 0 || time.deviation > 0) {
      const auto [left, right] = bar_of(time, x);
      const auto [lower, upper] = bar_of(error, y);
      marks.x_low = {left};
      marks.x_high = {right};
      marks.y_low = {lower};
      marks.y_high = {upper};
    }
    chart.curves.push_back(std::move(marks));
  }
  return chart;
}

/// One mark a seed.
Chart error_against_smoothness(const Comparison& comparison, const PageRows& shown) {
  Chart chart{"Error against smoothness, a mark a seed", "RMS second difference N/ms²", "RMS error, N", {}, {}};
  chart.log_x = true;
  chart.name = "error_over_smoothness";
  for (std::size_t i = 0; i < comparison.rows.size(); ++i) {
    const CompareRow& row = comparison.rows[i];
    const std::vector<double> x = row.done(row.metric("delivered.force.rms_d2_N_per_ms2", comparison.columns));
    const std::vector<double> y = row.done(row.metric(delivered_error, comparison.columns));
    if (x.empty() || y.empty()) continue;
    chart.curves.push_back({shown.names[i], x, y, shown.styles[i].color, true, shown.styles[i].mark});
  }
  return chart;
}

/// A line of a method; lines of one colour differ in their dashes.
Curve line_of(Curve curve, const MethodStyle& style) {
  curve.dash = style.mark;
  return curve;
}

/// The force of the first seed: all of it, and the 150 ms in which it moves most.
struct ForceCharts {
  Chart zoom, whole;
};
std::optional<ForceCharts> force_charts(const Comparison& comparison, const PageRows& shown) {
  // Curves are kept of the first seed alone.
  const auto drawn = std::find_if(comparison.rows.begin(), comparison.rows.end(),
                                  [](const CompareRow& row) { return row.status.front() == RunStatus::done; });
  if (drawn == comparison.rows.end()) return std::nullopt;
  const RunResult& first = drawn->runs.front();
  const std::pair<double, double> range = liveliest_window(first);
  const std::string axis = liveliest_axis(first, range);
  ForceCharts charts{zoom_on(first, range, axis),
                     {fmt::format("Force on the device, seed {}", first.seed),
                      "time s",
                      "N",
                      {},
                      std::pair<double, double>{0, first.duration_s}}};
  charts.whole.name = "force";
  if (const Series* s = first.curve("reference.norm"))
    charts.whole.curves.push_back(thinned(*s, "reference", "#555555"));
  for (std::size_t i = 0; i < comparison.rows.size(); ++i) {
    // Another scene or coupling has another reference.
    if (!comparison.rows[i].unlike.empty()) continue;
    const RunResult& run = comparison.rows[i].runs.front();
    const MethodStyle& style = shown.styles[i];
    if (const Series* s = run.curve("commanded." + axis))
      charts.zoom.curves.push_back(line_of(cut(*s, shown.names[i], style.color, range), style));
    if (const Series* s = run.curve("commanded.norm")) {
      charts.whole.curves.push_back(line_of(thinned(*s, shown.names[i], style.color), style));
      charts.whole.curves.back().width = 1.0;
    }
  }
  charts.zoom.title += fmt::format(", seed {}", first.seed);
  charts.zoom.curves.push_back(arrivals(first, range, axis));
  return charts;
}

bool has_values(const Chart& chart) {
  return std::any_of(chart.curves.begin(), chart.curves.end(), [](const Curve& c) { return !c.x.empty(); });
}

/// What the page makes of so many seeds.
std::string key_of_seeds(std::size_t seeds) {
  if (seeds == 1) return "one seed has no spread, and nothing is tested";
  constexpr const char* spread = "bars and ±: standard deviation over the seeds";
  if (seeds < fewest_seeds) return fmt::format("{}; nothing is tested with fewer than {} seeds", spread, fewest_seeds);
  return fmt::format("★: the best by a paired test over the seeds (95 %); {}", spread);
}

/// The rest of what is known of each run of the first seed.
std::string run_details(const Comparison& comparison, const PageRows& shown) {
  std::string html;
  for (std::size_t i = 0; i < comparison.rows.size(); ++i) {
    const RunResult& run = comparison.rows[i].runs.front();
    std::vector<Chart> charts = run_rows(run, shown.styles[i].color);
    if (std::optional<Chart> error = error_over_time(run, shown.styles[i].color)) charts.insert(charts.begin(), *error);
    if (charts.empty()) continue;
    for (Chart& chart : charts) chart.name = shown.names[i] + "/" + chart.name;
    html += folded(
        "The run of " + breakable(shown.names[i]),
        chart_figure(charts, 1160, 190) + "<p>Chosen and left out in this graph:</p>\n" + chosen_and_left_out(run));
  }
  return html;
}

}  // namespace

std::string compare_report(const Comparison& comparison, const TimingNote& timing, const std::string& scene) {
  constexpr int half_width = 580, first_height = 330;
  const PageRows rows = page_rows(comparison);
  const std::size_t seeds = comparison.seeds.size();
  std::vector<std::string> warnings = comparison_warnings(comparison);
  if (!timing.warning.empty()) warnings.push_back(timing.warning);
  const std::string failures = failures_html(comparison);
  const std::size_t doubts = warnings.size() + (failures.empty() ? 0 : 1);
  std::string body = fmt::format(
      "<p class=\"sub\">{}; tactor {}{}</p>\n",
      seeds == 1 ? std::string("one seed") : fmt::format("mean ± standard deviation over {} seeds", seeds),
      TACTOR_VERSION,
      doubts == 0
          ? std::string()
          : fmt::format("; <a class=\"bad\" href=\"#doubts\">{} warning{}</a>", doubts, doubts == 1 ? "" : "s"));
  const Chart cost = error_against_run_time(comparison, rows);
  const std::optional<ForceCharts> force = force_charts(comparison, rows);
  std::string first = has_values(cost) ? chart_figure({cost}, half_width, first_height)
                                       : std::string("<p>No run reports an error against a reference.</p>\n");
  if (force && has_values(force->zoom)) first += chart_figure({force->zoom}, half_width, first_height);
  body += "<div class=\"pair\">\n" + first + "</div>\n" + summary_tables(comparison, rows);
  body += fmt::format("<p class=\"sub\">{}; {}</p>\n", arrows_text, key_of_seeds(seeds));
  if (doubts > 0) body += "<div id=\"doubts\">\n" + warnings_html(warnings) + failures + "</div>\n";

  body += folded("In words", verdict_html(comparison, timing));
  body += folded("All metrics", judged_html(comparison) + metric_tables(comparison, rows) + timing_html(timing));
  body += folded("Differences over the seeds", significance_html(comparison, comparison.rows.front().full_name()));
  if (force && has_values(force->whole)) body += folded("The whole run", chart_figure({force->whole}, 1160, 320));
  const Chart trade = error_against_smoothness(comparison, rows);
  if (has_values(trade)) body += folded("Error against smoothness", chart_figure({trade}, 1160, 330));
  body += run_details(comparison, rows);
  std::string titles;
  for (std::size_t i = 0; i < comparison.rows.size(); ++i) {
    titles += fmt::format("<li><b>{}</b>: {}</li>\n", breakable(rows.names[i]), escape(comparison.rows[i].title));
  }
  body += folded("The graphs and their scene", "<ul>\n" + titles + "</ul>\n" + scene);
  body += provenance_html(comparison.provenance);
  return page(rows.title, body);
}

}  // namespace tactor
