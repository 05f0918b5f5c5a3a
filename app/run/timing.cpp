#include "app/run/timing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "app/run/cpu_time.hpp"
#include "app/statistics.hpp"

namespace tactor {

double measure_control() {
  static thread_local std::array<double, 4096> values{};
  const double begin = clock_seconds(CLOCK_THREAD_CPUTIME_ID);
  double x = 0.5;
  for (int pass = 0; pass < 40; ++pass) {
    for (double& value : values) {
      x = 3.9 * x * (1 - x);  // the logistic map: each value needs the one before
      value += x;
    }
  }
  const volatile double kept = values[17];
  static_cast<void>(kept);
  return 1e6 * (clock_seconds(CLOCK_THREAD_CPUTIME_ID) - begin);
}

double spread_of_repeats(std::span<const double> times) {
  if (times.size() < 2) return std::numeric_limits<double>::quiet_NaN();
  const auto [low, high] = std::minmax_element(times.begin(), times.end());
  return (*high - *low) / median(times);
}

std::string percent(double share) {
  return std::isfinite(share) ? fmt::format("{:.0f} %", 100 * share) : "-";
}

TimingNote timing_note(std::span<const double> control_us, std::span<const double> spreads, Repeats repeats,
                       double judged, const std::string& anew) {
  TimingNote note{.repeats = repeats, .text = {}, .warning = {}};
  if (control_us.empty()) return note;
  std::vector<double> known;
  std::copy_if(spreads.begin(), spreads.end(), std::back_inserter(known), [](double s) { return std::isfinite(s); });
  note.control_us = median(control_us);
  note.control_spread = (quantile(control_us, 0.95) - quantile(control_us, 0.05)) / note.control_us;
  note.text = known.empty() ? "Run times are CPU times of a single run each. "
                            : fmt::format(
                                  "Run times are CPU times, the median of {} repeats after {} that did not count; the "
                                  "repeats of a run spread by {:.1f} % in the median and {:.1f} % at most. ",
                                  repeats.count, repeats.warm_up, 100 * median(known), 100 * quantile(known, 1));
  note.text += fmt::format(
      "A fixed computation before each run took {:.0f} us in the median and spread by {:.1f} % (5th to 95th "
      "percentile).",
      note.control_us, 100 * note.control_spread);
  const double worst = std::max(note.control_spread, known.empty() ? 0 : quantile(known, judged));
  if (worst > 0.1) {
    note.warning = fmt::format(
        "The machine was not quiet: run times spread by {:.0f} %, more than 10 %. Compare them with care, or {}.",
        100 * worst, anew);
  }
  return note;
}

nlohmann::ordered_json to_json(const TimingNote& note) {
  return {{"repeats", note.repeats.count},
          {"warm_up", note.repeats.warm_up},
          {"control_us", note.control_us},
          {"control_spread", note.control_spread},
          {"warning", note.warning}};
}

}  // namespace tactor
