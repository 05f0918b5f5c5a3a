#include "app/run/felt_text.hpp"

#include <fmt/format.h>

#include <cmath>

#include "app/run/summary.hpp"
#include "app/run/timing.hpp"

namespace tactor {

std::string felt_text(std::span<const FeltShare> shares, const std::optional<FeltVibration>& vibration) {
  std::string felt, calm;
  const auto add = [](std::string& text, const std::string& more) { text += (text.empty() ? "" : "; ") + more; };
  for (const auto& [quantity, share] : shares) {
    if (share > 0) {
      add(felt, fmt::format("the {}'s error {} of the time", quantity, share < 0.005 ? "under 1 %" : percent(share)));
    } else {
      add(calm, fmt::format("the {}'s error is too small", quantity));
    }
  }
  if (vibration) {
    const auto by = [](double dB) { return fmt::format("{:.0f} dB {}", std::abs(dB), dB < 0 ? "under" : "above"); };
    std::string text = "vibration" +
                       (vibration->mean_Hz > 0 ? fmt::format(" at {} Hz", pretty(vibration->mean_Hz)) : "") + ", " +
                       by(vibration->mean_dB) + " its threshold";
    if (std::isfinite(vibration->worst_dB)) text += " (" + by(vibration->worst_dB) + " in the worst half second)";
    add(vibration->mean_dB >= 0 || vibration->worst_dB >= 0 ? felt : calm, text);
  }
  if (!vibration && !shares.empty()) return (felt.empty() ? calm : felt) + "; vibration was not judged";
  return !felt.empty() ? felt : calm.empty() ? "" : "nothing: " + calm;
}

}  // namespace tactor
