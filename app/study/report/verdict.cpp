#include "app/study/report/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "app/report/html_page.hpp"
#include "app/run/summary.hpp"
#include "app/study/plan/run_case.hpp"
#include "app/study/table/study.hpp"

namespace tactor {

namespace {

/// How a verdict speaks of a metric.
struct Subject {
  std::string_view metric;
  const char* superlative;  ///< `nearest to the reference`
  const char* comparative;  ///< `nearer to the reference`
  const char* term;         ///< what the metric is called
};
constexpr std::array<Subject, 3> subjects{{
    {"delivered.force.rms_error_N", "nearest to the reference", "nearer to the reference", "RMS error"},
    {"delivered.force.rms_d2_N_per_ms2", "smoothest", "smoother", "RMS second difference"},
    {"delivered.force.delay_ms", "nearest in time", "nearer in time", "delay"},
}};
constexpr Subject cost{"cpu_ms_per_s", "cheapest", "cheaper", "CPU time"};
constexpr std::size_t most_named = 12;

/// Whether the noise of the seeds hides that `mine` is worse than `first`; both have a badness for each seed.
bool noise_hides(const std::vector<double>& first, const std::vector<double>& mine) {
  if (first.size() >= fewest_seeds) {
    const PairedDifference difference = *paired_difference(first, mine);
    if (!difference.interval) return !(difference.mean > 0) || difference.identical == Identical::groups;
    return difference.interval->low <= 0 && difference.interval->high >= 0;
  }
  for (std::size_t s = 0; s < first.size(); ++s) {
    if (!(mine[s] > first[s])) return true;
  }
  return false;
}

/// `a`, `a and b`, `a, b and c`.
std::string listed(const std::vector<std::string>& texts) {
  std::string out;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    if (i > 0) out += i + 1 == texts.size() ? " and " : ", ";
    out += texts[i];
  }
  return out;
}

/// What the sentences of one metric are made of.
class Speaker {
 public:
  Speaker(const Comparison& comparison, const Subject& subject) : comparison_(comparison), subject_(subject) {
    if (const auto column = comparison.column(subject.metric)) {
      column_ = *column;
      ranking_ = ranking(comparison, column_);
    }
  }

  [[nodiscard]] bool exists() const { return column_ < comparison_.columns.size(); }
  [[nodiscard]] const Ranking& order() const { return ranking_; }
  [[nodiscard]] std::string name(std::size_t row) const { return breakable(comparison_.rows[row].name()); }
  [[nodiscard]] std::string term() const { return defined(subject_.term, comparison_.info(subject_.metric)); }
  /// By seed; of a metric that is better near zero its size.
  [[nodiscard]] std::vector<double> values(std::size_t row) const {
    std::vector<double> found = comparison_.rows[row].done(comparison_.rows[row].values[column_]);
    const MetricInfo* info = comparison_.info(subject_.metric);
    for (double& value : found) value = compared_value(info == nullptr ? Better::neither : info->better, value);
    return found;
  }
  [[nodiscard]] double value(std::size_t row) const { return mean(values(row)); }
  /// `0.0177 ± 0.0030 N`.
  [[nodiscard]] std::string value_text(std::size_t row) const {
    const std::vector<double> by_seed = values(row);
    std::string text = pretty(mean(by_seed));
    if (by_seed.size() > 1) text += " ± " + pretty(standard_deviation(by_seed));
    return with_unit(comparison_, text, subject_.metric);
  }
  [[nodiscard]] std::vector<std::string> names(const std::vector<std::size_t>& rows) const {
    std::vector<std::string> texts;
    for (const std::size_t row : rows) texts.push_back(name(row));
    return texts;
  }
  /// The ranked rows that lack this metric, as the end of a sentence.
  [[nodiscard]] std::string lacking() const {
    std::vector<std::string> texts;
    for (std::size_t row = 0; row < comparison_.rows.size(); ++row) {
      if (is_ranked(comparison_, row) && !std::isfinite(value(row))) texts.push_back(name(row));
    }
    return texts.empty() ? std::string() : fmt::format(" No {} is reported of {}.", term(), listed(texts));
  }
  /// Which rows are best, by how much, and which lack the metric.
  [[nodiscard]] std::string sentences() const;

 private:
  const Comparison& comparison_;
  const Subject& subject_;
  std::size_t column_ = static_cast<std::size_t>(-1);
  Ranking ranking_;
};

std::string Speaker::sentences() const {
  if (!exists() || ranking_.rows.empty()) {
    return fmt::format("No method is called {}: no run reports its {}.", subject_.superlative, term());
  }
  const std::vector<std::size_t>& best = ranking_.best;
  if (best.empty()) {
    return fmt::format("Only {} has a value of {}: {}.", name(ranking_.rows.front()), term(),
                       value_text(ranking_.rows.front())) +
           lacking();
  }
  const bool spread = comparison_.rows[best.front()].seeds_done() > 1;
  const char* tie = spread ? "a tie within the spread of the seeds" : "a tie";
  if (best.size() == ranking_.rows.size()) {
    const std::string low = value_text(best.front()), high = value_text(ranking_.rows.back());
    return fmt::format("No method is {} than the others, {}: {} {}.", subject_.comparative, tie, term(),
                       low == high ? low : low + " to " + high) +
           lacking();
  }
  std::string text;
  if (ranking_.winner) {
    text = fmt::format("<b>{}</b> is {}: {} {}", name(best.front()), subject_.superlative, term(),
                       value_text(best.front()));
  } else if (best.size() == 1) {
    text = fmt::format("{} has the least {}: {}", name(best.front()), term(), value_text(best.front()));
  } else {
    std::vector<std::string> bold;
    for (const std::size_t row : best) bold.push_back("<b>" + name(row) + "</b> (" + value_text(row) + ")");
    text = fmt::format("{} are {} by their {}, {}", listed(bold), subject_.superlative, term(), tie);
  }
  const auto next =
      std::find_if(ranking_.rows.begin(), ranking_.rows.end(), [&](std::size_t row) { return !ranking_.is_best(row); });
  text += fmt::format("; next is {} with {}", name(*next), value_text(*next));
  const double ratio = value(*next) / value(best.front());
  if (value(best.front()) > 0 && ratio >= 1.1) text += fmt::format(", {:.1f} times as much", ratio);
  return text + "." + lacking();
}

std::string cost_sentence(const Comparison& comparison, const TimingNote& timing) {
  const Speaker speaker(comparison, cost);
  const std::vector<std::size_t>& rows = speaker.order().rows;
  if (rows.empty()) return {};
  std::string text = fmt::format("{} for each second of the run: ", speaker.term());
  if (rows.size() > most_named) {
    text += fmt::format("from {} ({}) to {} ({})", speaker.value_text(rows.front()), speaker.name(rows.front()),
                        speaker.value_text(rows.back()), speaker.name(rows.back()));
  } else {
    std::vector<std::string> texts;
    for (const std::size_t row : rows) {
      texts.push_back(fmt::format("{} {}{}", speaker.name(row), speaker.value_text(row),
                                  speaker.order().winner == row ? " (least)" : ""));
    }
    text += listed(texts);
  }
  return text + (timing.warning.empty() ? "." : "; the machine was not quiet, so take these with care.") +
         speaker.lacking();
}

/// Why rows are not ranked.
std::string not_ranked(const Comparison& comparison) {
  std::vector<std::string> failed, lacking, unlike, untouched, unjudged;
  std::map<std::string, std::vector<std::string>> too_coarse;
  for (std::size_t row = 0; row < comparison.rows.size(); ++row) {
    const CompareRow& mine = comparison.rows[row];
    if (mine.seeds_done() == 0) {
      failed.push_back(breakable(case_name(mine.graph, mine.configuration)));
    } else if (!mine.too_coarse.empty()) {
      too_coarse[mine.too_coarse].push_back(breakable(mine.name()));
    } else if (!mine.has_reference(comparison.columns)) {
      unjudged.push_back(breakable(mine.name()));
    } else if (!mine.unlike.empty()) {
      unlike.push_back(breakable(mine.name()));
    } else if (mine.never_touches()) {
      untouched.push_back(breakable(mine.name()));
    } else if (!is_ranked(comparison, row)) {
      lacking.push_back(breakable(mine.name()));
    }
  }
  std::string text;
  if (!failed.empty()) text += fmt::format("<br>\nNot ranked, because every run failed: {}.", listed(failed));
  if (!lacking.empty()) {
    text += fmt::format(
        "<br>\nNot ranked, because runs failed and the seeds that are missing may be the hard "
        "ones: {}.",
        listed(lacking));
  }
  if (!untouched.empty()) text += fmt::format("<br>\nNot ranked, because nothing touches: {}.", listed(untouched));
  if (!unlike.empty()) {
    text += fmt::format("<br>\nNot ranked, because more than the method differs: {}.", listed(unlike));
  }
  if (!unjudged.empty()) {
    text += fmt::format("<br>\nNot ranked, because no reference judged the runs: {}.", listed(unjudged));
  }
  for (const auto& [why, names] : too_coarse) {
    text += fmt::format("<br>\nNot ranked, because {}: {}.", escape(why), listed(names));
  }
  return text;
}

std::string sentences_of_one(const Comparison& comparison, std::size_t row) {
  std::vector<std::string> texts;
  for (const Subject& subject : subjects) {
    const Speaker speaker(comparison, subject);
    if (speaker.exists() && std::isfinite(speaker.value(row))) {
      texts.push_back(speaker.term() + " " + speaker.value_text(row));
    }
  }
  const Speaker speaker(comparison, cost);
  if (speaker.exists() && std::isfinite(speaker.value(row))) {
    texts.push_back(speaker.term() + " " + speaker.value_text(row));
  }
  return texts.empty() ? std::string() : fmt::format(" {}: {}.", speaker.name(row), listed(texts));
}

std::string sentences(const Comparison& comparison, const TimingNote& timing) {
  const std::vector<CompareRow>& rows = comparison.rows;
  std::vector<std::size_t> ranked;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    if (is_ranked(comparison, row)) ranked.push_back(row);
  }
  if (rows.size() < 2) {
    return "One graph was run: there is nothing to compare it with." +
           (ranked.empty() ? not_ranked(comparison) : sentences_of_one(comparison, ranked.front()));
  }
  const bool is_judged = std::all_of(rows.begin(), rows.end(), [&](const CompareRow& row) {
    return row.too_coarse.empty() && row.has_reference(comparison.columns);
  });
  if (ranked.empty() && !is_judged) return "No method is ranked." + not_ranked(comparison);
  if (ranked.size() < 2) {
    return (ranked.empty()
                ? std::string("No method can be ranked: nothing is compared.")
                : fmt::format("Only {} can be ranked: nothing is compared.{}", breakable(rows[ranked.front()].name()),
                              sentences_of_one(comparison, ranked.front()))) +
           not_ranked(comparison);
  }
  std::string text;
  for (const Subject& subject : subjects) text += Speaker(comparison, subject).sentences() + "<br>\n";
  text += cost_sentence(comparison, timing) + not_ranked(comparison);
  const std::size_t seeds = rows[ranked.front()].seeds_done();
  const bool identical =
      std::all_of(ranked.begin(), ranked.end(), [&](std::size_t row) { return rows[row].identical_seeds; });
  if (identical) {
    text += fmt::format("<br>\nThe runs of all {} seeds are identical, so it is unknown how much of this is chance.",
                        seeds);
  } else if (seeds == 1) {
    text += "<br>\nWith one seed, it is unknown how much of this is chance.";
  } else if (seeds < fewest_seeds) {
    text += fmt::format("<br>\nWith {} seeds, differences may be chance; {} can be tested.", seeds, fewest_seeds);
  }
  return text;
}

}  // namespace

bool Ranking::is_best(std::size_t row) const {
  return std::find(best.begin(), best.end(), row) != best.end();
}

bool is_ranked(const Comparison& comparison, std::size_t row) {
  const CompareRow& asked = comparison.rows[row];
  if (!asked.too_coarse.empty() || !asked.has_reference(comparison.columns)) return false;
  if (!asked.unlike.empty() || asked.never_touches()) return false;
  const std::vector<RunStatus>& mine = comparison.rows[row].status;
  bool any = false;
  for (std::size_t s = 0; s < mine.size(); ++s) {
    any = any || mine[s] == RunStatus::done;
    const bool somebody = std::any_of(comparison.rows.begin(), comparison.rows.end(),
                                      [s](const CompareRow& other) { return other.status[s] == RunStatus::done; });
    if (somebody && mine[s] != RunStatus::done) return false;
  }
  return any;
}

Ranking ranking(const Comparison& comparison, std::size_t column) {
  Ranking found;
  const MetricInfo* info = comparison.info(comparison.columns[column].metric);
  if (info == nullptr || info->better == Better::neither) return found;
  const auto badnesses = [&](std::size_t row) {
    std::vector<double> values = comparison.rows[row].done(comparison.rows[row].values[column]);
    for (double& value : values) value = badness(info->better, value);
    return values;
  };
  for (std::size_t row = 0; row < comparison.rows.size(); ++row) {
    if (is_ranked(comparison, row) && std::isfinite(mean(badnesses(row)))) found.rows.push_back(row);
  }
  std::stable_sort(found.rows.begin(), found.rows.end(),
                   [&](std::size_t a, std::size_t b) { return mean(badnesses(a)) < mean(badnesses(b)); });
  if (found.rows.size() < 2) return found;
  const std::vector<double> first = badnesses(found.rows.front());
  for (const std::size_t row : found.rows) {
    const std::vector<double> mine = badnesses(row);
    if (pretty(mean(first)) == pretty(mean(mine)) || noise_hides(first, mine)) found.best.push_back(row);
  }
  const CompareRow& front = comparison.rows[found.rows.front()];
  if (found.best.size() == 1 && front.seeds_done() >= fewest_seeds && !front.identical_seeds) {
    found.winner = found.best.front();
  }
  return found;
}

std::string verdict_text(const Comparison& comparison, std::size_t row) {
  const CompareRow& mine = comparison.rows[row];
  if (mine.seeds_done() == 0) return "every run failed";
  if (!mine.too_coarse.empty()) return "no error: the reference is no finer than the run";
  if (!mine.has_reference(comparison.columns)) return "no error: no reference judged the runs";
  if (!mine.unlike.empty()) return "not ranked: another scene or coupling";
  if (mine.never_touches()) return "nothing touches";
  if (!is_ranked(comparison, row)) return "not ranked: runs failed";
  const auto error = [&](std::size_t of) { return comparison.rows[of].mean_of(delivered_error, comparison.columns); };
  if (!std::isfinite(error(row))) return "no error is known";
  const Ranking order = ranking(comparison, *comparison.column(delivered_error));
  if (order.rows.size() < 2) return "nothing to compare with";
  if (order.winner == row) return "least error";
  if (order.is_best(row)) return order.best.size() > 1 ? "tied for the least error" : "least error, not tested";
  constexpr double little = 1.1;
  const double ratio = error(row) / error(order.rows.front());
  if (!std::isfinite(ratio) || ratio < little) return "a little above the least error";
  return fmt::format("{} × the least error", pretty(ratio));
}

std::string verdict_html(const Comparison& comparison, const TimingNote& timing) {
  return "<p class=\"verdict\">" + sentences(comparison, timing) + "</p>\n";
}

}  // namespace tactor
