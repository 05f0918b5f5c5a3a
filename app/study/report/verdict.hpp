// Which method of a comparison is best at what: the sentences that a report begins with, and the marks in its table.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/study/table/comparison.hpp"

namespace tactor {

/// The rows of a comparison in the order of one metric.
struct Ranking {
  std::vector<std::size_t> rows;  ///< those with a value, the best first; none where the metric has no direction
  /// The first of `rows`, and those that tie with it: they are alike in three digits, or the noise of the seeds hides
  /// the difference. It does where the 95 % confidence interval of the paired difference includes zero; of fewer than
  /// `fewest_seeds`, where they do not agree which is better. None where fewer than two rows have a value.
  std::vector<std::size_t> best;
  /// The row that the seeds show to be best. None where rows tie, where fewer than `fewest_seeds` are done, and where
  /// the seeds are copies of one run.
  std::optional<std::size_t> winner;

  [[nodiscard]] bool is_best(std::size_t row) const;
};

/// Whether the row has every seed that some row has, a reference that is finer than its runs, contacts, and the scene
/// and coupling of the others. One that lacks a seed is not ranked: the seeds that it lacks may be the hard ones.
bool is_ranked(const Comparison& comparison, std::size_t row);

/// The ranking by the metric of that column, with the direction that the metric declares.
Ranking ranking(const Comparison& comparison, std::size_t column);

/// How near to the reference the row is, in a few words for a cell: `least error`, `2.10 × the least error`, or why
/// it is not ranked.
std::string verdict_text(const Comparison& comparison, std::size_t row);

/// In plain words: which method is nearest to the reference, smoothest and least late, what each costs, and which are
/// not ranked and why. HTML, with the definition of each metric.
std::string verdict_html(const Comparison& comparison, const TimingNote& timing);

}  // namespace tactor
