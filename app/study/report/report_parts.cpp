#include "app/study/report/report_parts.hpp"

#include <fmt/format.h>

#include <utility>

#include "app/run/summary.hpp"
#include "app/study/report/text_tables.hpp"

namespace tactor {

namespace {

void add_difference(std::vector<std::string>& cells, const std::optional<PairedDifference>& d, std::size_t seeds) {
  if (!d) {
    cells.insert(cells.end(), 4, "-");
    return;
  }
  cells.push_back(fmt::format("{:+.4f}", d->mean));
  const std::string interval =
      d->interval ? fmt::format("[{:+.4f}, {:+.4f}]", d->interval->low, d->interval->high) : untested_text(*d);
  cells.push_back((interval.empty() ? "-" : interval) + over_seeds(d->pairs, seeds));
  cells.push_back(d->effect_size ? fmt::format("{:+.2f}", *d->effect_size) : "-");
  cells.push_back(d->p_wilcoxon ? pretty(*d->p_wilcoxon) : "-");
}

}  // namespace

std::string head_text(const Comparison& comparison, const Column& column) {
  return defined(breakable(head_of(comparison, column)), comparison.info(column.metric));
}

std::string deviation(const std::vector<double>& values) {
  return values.size() < 2 ? "-" : pretty(standard_deviation(values));
}

void add_metric_cells(std::vector<std::string>& cells, const CompareRow& row) {
  for (const std::vector<double>& by_seed : row.values) {
    const std::vector<double> values = row.done(by_seed);
    cells.push_back(fmt::format("{} ± {}", pretty(mean(values)), deviation(values)));
  }
}

std::string in_frame(const HtmlTable& table) {
  return "<div class=\"wide\">" + table.html() + "</div>\n";
}

std::string judged_html(const Comparison& comparison) {
  std::string html;
  for (const std::string& sentence : judged_sentences(comparison)) html += "<li>" + escape(sentence) + "</li>\n";
  return fmt::format("<ul>\n{}</ul>\n<p>{}</p>\n", html, arrows_text);
}

std::string named_metrics_html(const Study& study, std::size_t graph) {
  if (study.spec.metrics.empty()) return {};
  const Comparison& comparison = study.comparison;
  std::vector<std::string> heads{""};
  for (const Column& column : comparison.columns) heads.push_back(head_text(comparison, column));
  HtmlTable table(std::move(heads));
  for (std::size_t s = 0; s < study.configurations.size(); ++s) {
    const CompareRow& row = comparison.rows[graph * study.configurations.size() + s];
    std::vector<std::string> cells{escape(row.configuration + study.incomplete(s))};
    add_metric_cells(cells, row);
    table.add(cells);
  }
  return in_frame(table);
}

std::string significance_html(const Comparison& comparison, const std::string& against) {
  if (comparison.seeds.size() < fewest_seeds) {
    return fmt::format(
        "<p>Differences are not tested: that takes {} seeds, because chance alone makes large effects of fewer.</p>\n",
        fewest_seeds);
  }
  HtmlTable table({"", "ANOVA F", "ANOVA p", "one-step RMS N", "95 %", "effect d", "Wilcoxon p", "delivered RMS N",
                   "95 %", "effect d", "Wilcoxon p"});
  bool any = false;
  for (std::size_t i = 0; i < comparison.rows.size(); ++i) {
    const CompareRow& row = comparison.rows[i];
    if (row.against == i) continue;
    any = true;
    const std::size_t seeds = comparison.seeds.size();
    std::vector<std::string> cells{breakable(row.name()), "-", "-"};
    if (const Anova* anova = shown_anova(comparison, row)) {
      cells[1] = pretty(anova->F) + over_seeds(judged_seeds(comparison, row), seeds);
      cells[2] = anova->p > 0 ? pretty(anova->p) : "&lt; 1e-300";
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
      "leaves out seeds without a difference. Rows that share fewer than {} seeds are not tested. Neither are seeds "
      "whose "
      "runs are identical, because they tell nothing of chance.</p>\n{}",
      escape(against), fewest_seeds, table.html());
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

}  // namespace tactor
