#include "app/study/report/study_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "app/report/chart.hpp"
#include "app/report/figure.hpp"
#include "app/report/html_page.hpp"
#include "app/report/method_style.hpp"
#include "app/run/summary.hpp"
#include "app/study/report/report_parts.hpp"
#include "app/study/report/text_tables.hpp"
#include "app/study/table/warnings.hpp"
#include "app/study/table/where.hpp"

namespace tactor {

namespace {

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

std::string study_graph_html(const Study& study, std::size_t first) {
  const Comparison& comparison = study.comparison;
  HtmlTable table = table_of_study(study, true);
  std::string remarks;
  for (std::size_t row = first; row < first + study.configurations.size(); ++row) {
    const CompareRow& mine = comparison.rows[row];
    std::vector<std::string> cells =
        study_cells(study, mine.with_seeds(mine.configuration), study.ratios[row], study.spreads[row]);
    add_metric_cells(cells, mine);
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
  chart.name = "error_over_run_time";
  // The values of a method follow each other, so that each has a mark of its own.
  std::vector<std::string> names;
  for (std::size_t s = 0; s < study.configurations.size(); ++s) names.push_back(study.comparison.rows[s].configuration);
  const std::vector<MethodStyle> styles = method_styles(names);
  for (std::size_t s = 0; s < study.configurations.size(); ++s) {
    const std::optional<GeometricMean>& error = study.ratios_over_graphs[s].delivered;
    const double us = study.over_graphs(s, "method_us_per_tick");
    if (!error || !(us > 0)) continue;
    chart.curves.push_back(
        {names[s] + study.incomplete(s), {us}, {error->ratio}, styles[s].color, true, styles[s].mark});
    chart.curves.back().hollow = !study.incomplete(s).empty();
  }
  return chart.curves.size() < 2 ? "" : chart_figure({chart}, 1160, 420);
}

}  // namespace

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
  body += warnings_html(comparison_warnings(comparison)) + judged_html(comparison);
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
  body += significance_html(comparison, baseline_text(study.spec)) + failures_html(comparison) + where_html(comparison);
  return page(study.spec.name, body);
}

}  // namespace tactor
