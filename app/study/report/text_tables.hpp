// What comparisons and studies print on the terminal.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "app/study/table/study.hpp"

namespace tactor {

/// Why a difference is not tested, such as `the 6 seeds are identical: not tested`; empty where it is.
std::string untested_text(const PairedDifference& difference);
/// `p = 0.0313`.
std::string p_text(double p);
/// A line for each row that is compared with another: ANOVA of the single one-step errors, and paired differences with
/// their 95 % confidence interval, effect size d_z and Wilcoxon's p, as far as the seeds tell them.
std::string judged_text(const Comparison& comparison);
/// The table that `tactor compare` prints, in so many columns.
std::string comparison_table(const Comparison& comparison, const TimingNote& timing, std::size_t columns);
/// The table that `tactor compare --brief` prints: a line a graph with error, delay, smoothness and run time.
std::string brief_table(const Comparison& comparison, const TimingNote& timing, std::size_t columns);

/// `0.707 [0.650, 0.769]`, with `over 9 seeds` where these are fewer than the `seeds` of the study; `-` for no ratio,
/// and for the interval where there is one seed alone.
std::string ratio_text(const std::optional<GeometricMean>& ratio, std::size_t seeds);
/// `0.240 to 0.690`, the quantiles 0.05 and 0.95 over the seeds, each written by `text`; `-` for none.
std::string quantiles_text(const std::optional<SeedSpread>& spread, std::string (*text)(double));
/// `0.693 (1007)`: the value of the worst seed, and which that is; `-` for none.
std::string worst_text(const std::optional<SeedSpread>& spread, std::string (*text)(double));
/// `0.998`: ratios near 1 are told apart.
std::string ratio_number(double ratio);
/// `; ratios are to method hold with the same tool.stiffness`; empty where nothing is compared with anything.
std::string ratios_text(const StudySpec& spec);
/// What `tactor study` prints, in so many columns: every graph's configurations, then the configurations over all
/// graphs.
std::string study_table(const Study& study, std::size_t columns);

}  // namespace tactor
