// What a hand is predicted to feel of an error of force, in a sentence: for the end of a run, its report and the view.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "framework/core/felt.hpp"

namespace tactor {

/// The share of the time, 0 to 1, in which an error is noticed as a wrong force or torque.
struct FeltShare {
  const char* quantity;  ///< `force` or `torque`
  double share;
};

/// Tells where and how much of the error a hand is predicted to feel, or that it feels nothing. `vibration`: none where
/// it could not be judged, and then it does not say nothing; its worst half second may be NaN. Empty without shares and
/// without vibration.
std::string felt_text(std::span<const FeltShare> shares, const std::optional<FeltVibration>& vibration);

}  // namespace tactor
