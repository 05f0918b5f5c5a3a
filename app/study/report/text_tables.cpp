#include "app/study/report/text_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "app/run/summary.hpp"
#include "app/study/table/warnings.hpp"
#include "framework/core/check.hpp"
#include "framework/graph/text_table.hpp"

namespace tactor {

std::string untested_text(const PairedDifference& difference) {
  switch (difference.identical) {
    case Identical::no:
      return difference.pairs < fewest_seeds
                 ? fmt::format("{} seeds are too few to test ({} are the fewest)", difference.pairs, fewest_seeds)
                 : std::string();
    case Identical::groups:
      return fmt::format("the same in each of {} seeds", difference.pairs);
    case Identical::pairs:
      return fmt::format("the {} seeds are identical: not tested", difference.pairs);
  }
  TACTOR_DEMAND(false);
}

std::string p_text(double p) {
  return p > 0 ? "p = " + pretty(p) : "p < 1e-300";
}

namespace {

/// `-0.0210 N [-0.0290, -0.0130], d_z = -1.40, p = 0.0020`, without what the pairs do not tell.
std::string difference_text(const PairedDifference& d) {
  const std::string same = untested_text(d);
  if (d.identical == Identical::groups) return same;
  std::string text = fmt::format("{:+.4f} N", d.mean);
  if (d.interval) text += fmt::format(" [{:+.4f}, {:+.4f}]", d.interval->low, d.interval->high);
  if (d.effect_size) text += fmt::format(", d_z = {:+.2f}", *d.effect_size);
  if (d.p_wilcoxon) text += ", " + p_text(*d.p_wilcoxon);
  return same.empty() ? text : text + ", " + same;
}

}  // namespace

std::string judged_text(const Comparison& comparison) {
  std::string out;
  for (std::size_t i = 0; i < comparison.rows.size(); ++i) {
    const CompareRow& row = comparison.rows[i];
    if (row.against == i) continue;
    std::string found;
    if (row.never_touches() && comparison.rows[row.against].never_touches()) found = ": not tested, nothing touches";
    if (!row.unlike.empty() || !comparison.rows[row.against].unlike.empty()) {
      found = ": not tested, more than the method differs";
    }
    if (!row.too_coarse.empty() || !comparison.rows[row.against].too_coarse.empty()) {
      found = ": delivered not compared, the reference is no finer than the run";
    }
    const auto add = [&](const std::string& text) { found += (found.empty() ? ": " : "; ") + text; };
    if (const Anova* anova = shown_anova(comparison, row)) {
      add(fmt::format("one-step ANOVA F = {}, {}{}", pretty(anova->F), p_text(anova->p),
                      over_seeds(judged_seeds(comparison, row), comparison.seeds.size())));
    }
    for (const auto& [name, d] : {std::pair{"one-step", row.one_step}, {"delivered", row.delivered}}) {
      if (!d) continue;
      add(fmt::format("{} {}", name, difference_text(*d)));
      found += over_seeds(d->pairs, comparison.seeds.size());
    }
    out += "  " + row.name() + found + "\n";
  }
  return out;
}

namespace {

/// How the values of a column lie over the seeds: quantiles of enough seeds, the worst one, two populations where there
/// are.
void add_spread(TextTable& table, const Comparison& comparison, std::size_t column) {
  if (comparison.seeds.size() < 2) return;
  std::vector<std::string> quantiles{"  5 to 95 % of seeds"}, worst{"  worst (seed)"}, two{"  two populations"};
  bool any = false;
  for (const CompareRow& row : comparison.rows) {
    const auto spread = seed_spread(comparison.seeds, row.values[column]);
    quantiles.push_back(quantiles_text(spread, pretty));
    worst.push_back(worst_text(spread, pretty));
    const bool split = spread && spread->populations;
    any = any || split;
    two.push_back(split ? fmt::format("{} + {} seeds", spread->populations->low_count, spread->populations->high_count)
                        : "");
  }
  if (comparison.seeds.size() >= fewest_seeds) table.add(std::move(quantiles));
  table.add(std::move(worst));
  if (any) table.add(std::move(two));
}

}  // namespace

std::string comparison_table(const Comparison& comparison, const TimingNote& timing, std::size_t columns) {
  std::string out = warning_lines(comparison);
  out += fmt::format("\nmean over {} seed{}\n\n", comparison.seeds.size(), comparison.seeds.size() == 1 ? "" : "s");
  std::vector<TextTable::Column> heads{{""}};
  std::vector<std::string> seeds{""};
  bool all_done = true;
  for (const CompareRow& row : comparison.rows) {
    heads.push_back({row.full_name(), TextTable::Align::right});
    seeds.push_back(row.seeds_text());
    all_done = all_done && row.seeds_text().empty();
  }
  TextTable table(std::move(heads));
  if (!all_done) table.add(std::move(seeds));
  bool in_run_times = false;
  for (std::size_t c = 0; c < comparison.columns.size(); ++c) {
    if (comparison.columns[c].run_time && !in_run_times) {
      table.add({"run time (CPU)"});
      in_run_times = true;
    }
    std::vector<std::string> cells{head_of(comparison, comparison.columns[c])};
    for (const CompareRow& row : comparison.rows) cells.push_back(pretty(mean(row.done(row.values[c]))));
    table.add(std::move(cells));
    if (comparison.columns[c].metric == delivered_error) add_spread(table, comparison, c);
  }
  out += table.text(columns);
  out += fmt::format("\n  {}\n", arrows_text);
  for (const std::string& sentence : judged_sentences(comparison)) out += fmt::format("  {}\n", sentence);
  out += lines_of(timing, "  ");
  out += fmt::format("\n  against {}\n", comparison.rows.front().full_name());
  out += judged_text(comparison);
  return wrapped(out, columns);
}

std::string brief_table(const Comparison& comparison, const TimingNote& timing, std::size_t columns) {
  std::string out = warning_lines(comparison);
  out += fmt::format("\nmean over {} seed{}\n\n", comparison.seeds.size(), comparison.seeds.size() == 1 ? "" : "s");
  std::vector<TextTable::Column> heads{{""}};
  std::vector<const Column*> shown;
  for (const std::string_view metric :
       {delivered_error, std::string_view("delivered.force.delay_ms"),
        std::string_view("delivered.force.rms_d2_N_per_ms2"), std::string_view("cpu_ms_per_s")}) {
    const std::optional<std::size_t> column = comparison.column(metric);
    if (!column) continue;
    shown.push_back(&comparison.columns[*column]);
    heads.push_back({head_of(comparison, *shown.back()), TextTable::Align::right});
  }
  TextTable table(std::move(heads));
  for (const CompareRow& row : comparison.rows) {
    std::vector<std::string> cells{row.name()};
    for (const Column* column : shown) cells.push_back(pretty(row.mean_of(column->metric, comparison.columns)));
    table.add(std::move(cells));
  }
  out += table.text(columns);
  out += fmt::format("\n  {}\n", arrows_text);
  if (!timing.warning.empty()) out += fmt::format("  {}\n", timing.warning);
  out += "\n";
  for (const CompareRow& row : comparison.rows) out += fmt::format("  {}: {}\n", row.full_name(), row.title);
  return wrapped(out, columns);
}

std::string ratio_text(const std::optional<GeometricMean>& ratio, std::size_t seeds) {
  if (!ratio) return "-";
  const std::string interval =
      std::isfinite(ratio->low) ? fmt::format("{:.3f}, {:.3f}", ratio->low, ratio->high) : std::string("-");
  return fmt::format("{:.3f} [{}]{}", ratio->ratio, interval, over_seeds(ratio->count, seeds));
}

std::string quantiles_text(const std::optional<SeedSpread>& spread, std::string (*text)(double)) {
  return spread ? fmt::format("{} to {}", text(spread->low), text(spread->high)) : "-";
}

std::string worst_text(const std::optional<SeedSpread>& spread, std::string (*text)(double)) {
  return spread ? fmt::format("{} ({})", text(spread->worst), spread->worst_seed) : "-";
}

std::string ratio_number(double ratio) {
  return fmt::format("{:.3f}", ratio);
}

std::string ratios_text(const StudySpec& spec) {
  const std::string baseline = baseline_text(spec);
  return baseline.empty() ? std::string() : "; ratios are to " + baseline;
}

std::string study_table(const Study& study, std::size_t columns) {
  const Comparison& comparison = study.comparison;
  const std::size_t configurations = study.configurations.size();
  const auto name_of_row = [&](std::size_t row) {
    const std::string seeds = comparison.rows[row].seeds_text();
    return label(study.configuration(row)) + (seeds.empty() ? "" : " (" + seeds + ")");
  };
  const auto text_of = [&](const std::optional<GeometricMean>& ratio) {
    return ratio_text(ratio, comparison.seeds.size());
  };
  const auto add = [&](TextTable& table, const std::string& name, const ErrorRatio& ratio,
                       const std::optional<SeedSpread>& spread, const auto& value) {
    const auto metric = [&](std::string_view f) { return pretty(value(f)); };
    table.add({name, metric(delivered_error), text_of(ratio.delivered), quantiles_text(spread, ratio_number),
               worst_text(spread, ratio_number), metric("delivered.force.delay_ms"),
               metric("delivered.force.rms_d2_N_per_ms2"), metric(one_step_error), text_of(ratio.one_step),
               metric("method_us_per_result"), metric("method_us_per_tick")});
  };
  using enum TextTable::Align;
  const auto head = [&comparison](const char* text, std::string_view metric) {
    return TextTable::Column{with_unit(comparison, text, metric), right};
  };
  const TextTable empty({{""},
                         head("RMS err", delivered_error),
                         {"ratio [95 %]", right},
                         {"5 to 95 % of seeds", right},
                         {"worst (seed)", right},
                         head("delay", "delivered.force.delay_ms"),
                         {"2nd diff", right},
                         head("1-step", one_step_error),
                         {"ratio [95 %]", right},
                         {"us/result", right},
                         {"us/tick", right}});
  std::string out =
      fmt::format("\n{}: {} seed{} from {}{}\n", study.spec.name, comparison.seeds.size(),
                  comparison.seeds.size() == 1 ? "" : "s", comparison.seeds.front(), ratios_text(study.spec));
  for (std::size_t first = 0; first < comparison.rows.size(); first += configurations) {
    TextTable table = empty;
    for (std::size_t row = first; row < first + configurations; ++row) {
      add(table, name_of_row(row), study.ratios[row], study.spreads[row],
          [&](std::string_view metric) { return comparison.rows[row].mean_of(metric, comparison.columns); });
    }
    out += fmt::format("\n{}\n{}", comparison.rows[first].graph, table.text(columns));
    for (std::size_t row = first; row < first + configurations; ++row) {
      const std::string two = populations_text(study.spreads[row]);
      if (!two.empty()) out += fmt::format("  {}: {}\n", name_of_row(row), two);
    }
  }
  if (study.spec.graphs.size() > 1) {
    TextTable table = empty;
    for (std::size_t s = 0; s < configurations; ++s) {
      add(table, label(study.configurations[s]) + study.incomplete(s), study.ratios_over_graphs[s],
          study.spreads_over_graphs[s], [&](std::string_view metric) { return study.over_graphs(s, metric); });
    }
    out += fmt::format("\nall {} graphs\n{}", study.spec.graphs.size(), table.text(columns));
  }
  for (const std::string& sentence : judged_sentences(comparison)) out += "\n" + sentence;
  out += "\n" + lines_of(timing_note(study));
  const std::string judged = judged_text(comparison);
  if (!judged.empty()) out += fmt::format("\nagainst {}\n{}", baseline_text(study.spec), judged);
  return wrapped(out, columns);
}

}  // namespace tactor
