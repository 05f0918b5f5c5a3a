// Fewer samples a second of a recorded force, without the aliases that leaving some out would make.
#pragma once

#include <string>
#include <vector>

#include "framework/core/messages.hpp"

namespace tactor {

/// Every `factor`-th sample, the first included, of the samples through a low-pass of zero phase: 10 factor + 1 weights
/// of a sinc with its cut-off (-6 dB) at 0.8 of half the new rate, under a Hamming window, which sum to 1. So a sample
/// knows of the 5 new periods after it too, which for content below the cut-off makes no difference. Beyond its ends
/// the signal goes on as its reflection through the end point. Factor 1 changes nothing.
///
/// Throws InputError, its text beginning with `where`, where two stamps are apart by other than the mean of all by more
/// than a hundredth of it, and where there are fewer than 10 factor + 1 samples.
std::vector<Stamped<Wrench>> decimated(std::vector<Stamped<Wrench>> samples, int factor, const std::string& where);

}  // namespace tactor
