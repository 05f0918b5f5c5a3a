// The parameters of a period estimate, declared alike by every node that keeps one.
#pragma once

#include "framework/core/period_estimate.hpp"
#include "framework/node/declare.hpp"

namespace tactor {

/// Adds the parameters of PeriodOptions to a node whose Params derive from it.
template <class N>
Declare<N>& declare_period(Declare<N>& node) {
  using P = typename N::Params;
  // A pointer to a member of the base does not deduce as one of Params.
  return node
      .choice("period_estimate", static_cast<PeriodMode P::*>(&P::period_estimate),
              {{"last", PeriodMode::last}, {"mean", PeriodMode::mean}}, std::optional(PeriodMode::last),
              "how the next physics period is estimated: the last interval between stamps (last), or a mean of several "
              "(mean)")
      .integer(
          "period_count", static_cast<std::int32_t P::*>(&P::period_count),
          {.doc = "number of intervals in the mean", .default_value = 8, .min = 1, .max = PeriodEstimate::max_count})
      .real("period_initial", static_cast<Duration P::*>(&P::period_initial),
            {.doc = "the period assumed before the second message",
             .unit = "s",
             .default_value = 0.01,
             .min = 1e-6,
             .max = 1})
      .real("period_max", static_cast<Duration P::*>(&P::period_max),
            {.doc = "a longer interval counts as a pause of this length",
             .unit = "s",
             .default_value = 0.1,
             .min = 1e-6,
             .max = 10});
}

}  // namespace tactor
