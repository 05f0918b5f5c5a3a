#include "app/run/timing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "app/run/summary.hpp"
#include "app/statistics.hpp"
#include "framework/core/clock.hpp"

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

namespace {

std::vector<double> finite(std::span<const double> values) {
  std::vector<double> out;
  std::copy_if(values.begin(), values.end(), std::back_inserter(out), [](double v) { return std::isfinite(v); });
  return out;
}

/// How the run times were taken, without how far they spread.
std::string taken_text(Repeats repeats) {
  const std::string before = repeats.warm_up == 0 ? ""
                                                  : fmt::format(" after {} run{} that did not count", repeats.warm_up,
                                                                repeats.warm_up == 1 ? "" : "s");
  if (repeats.count > 1) {
    return fmt::format("Run times are CPU times, the median of {} repeats{}", repeats.count, before);
  }
  return fmt::format("Run times are CPU times of a single run each{}; how far repeats would spread is unknown", before);
}

}  // namespace

std::string spread_warning(std::span<const double> spreads) {
  const std::vector<double> known = finite(spreads);
  const auto beyond = std::count_if(known.begin(), known.end(), [](double s) { return s > TimingNote::quiet_spread; });
  if (beyond == 0) return {};
  return fmt::format("the repeats of {} of {} runs spread by more than 10 %, by {} at most", beyond, known.size(),
                     percent(quantile(known, 1)));
}

TimingNote timing_note(std::span<const double> control_us, std::span<const double> spreads, Repeats repeats,
                       const std::string& of_repeats, const std::string& anew) {
  const std::vector<double> known = finite(spreads);
  TimingNote note;
  note.repeats = repeats;
  note.spread_median = median(known);
  note.spread_worst = quantile(known, 1);
  if (control_us.empty()) return note;
  note.control_us = median(control_us);
  note.control_spread = (quantile(control_us, 0.95) - quantile(control_us, 0.05)) / note.control_us;
  note.text = taken_text(repeats);
  if (!known.empty()) {
    note.text += fmt::format("; the repeats of a run spread by {:.1f} % in the median and {:.1f} % at most",
                             100 * note.spread_median, 100 * note.spread_worst);
  }
  note.text += fmt::format(
      ". A fixed computation before each run took {:.0f} us in the median and spread by {:.1f} % (5th to 95th "
      "percentile).",
      note.control_us, 100 * note.control_spread);
  std::string found = of_repeats;
  if (note.control_spread > TimingNote::quiet_spread) {
    found += fmt::format("{}the fixed computation spread by {:.0f} %, more than 10 %", found.empty() ? "" : "; ",
                         100 * note.control_spread);
  }
  if (!found.empty()) {
    note.warning = fmt::format("The machine was not quiet: {}. Compare run times with care, or {}.", found, anew);
  }
  return note;
}

nlohmann::ordered_json to_json(const TimingNote& note) {
  return {{"repeats", note.repeats.count},
          {"warm_up", note.repeats.warm_up},
          {"spread_median", number_json(note.spread_median)},
          {"spread_worst", number_json(note.spread_worst)},
          {"control_us", number_json(note.control_us)},
          {"control_spread", number_json(note.control_spread)},
          {"text", note.text},
          {"warning", note.warning}};
}

std::string lines_of(const TimingNote& note, const std::string& indent) {
  std::string lines;
  for (const std::string& text : {note.text, note.warning}) {
    if (!text.empty()) lines += (lines.empty() ? "\n" : "") + indent + text + "\n";
  }
  return lines;
}

}  // namespace tactor
