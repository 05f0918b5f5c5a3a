#include "app/run/headline.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "app/run/felt_text.hpp"
#include "app/run/run_metrics.hpp"
#include "app/run/summary.hpp"
#include "app/run/timing.hpp"
#include "framework/core/stability.hpp"
#include "framework/graph/text_table.hpp"

namespace tactor {

namespace {

/// The strict form of stable, where it is told: by the line of the device, which knows what was in force when, else by
/// the port.
std::string port_text(const RunResult& result) {
  double generated = result.metric("device.line.energy_generated_J");
  double allowed = result.metric("device.line.energy_allowed_J");
  if (!std::isfinite(generated)) {
    if (!std::isfinite(result.metric("stability.passive"))) return {};
    generated = result.metric("port.energy_generated_J");
    allowed = result.metric("port.energy_allowed_J");
  }
  if (generated <= allowed) return ", port passive";
  return fmt::format(", port not passive: it gave {} J, while one tick and one rounding explain {} J",
                     pretty(generated), pretty(allowed));
}

std::string stability_text(const RunResult& result) {
  const double number = result.metric("stability.verdict");
  if (!std::isfinite(number)) return {};
  const auto verdict = static_cast<StabilityVerdict>(static_cast<int>(number));
  switch (verdict) {
    case StabilityVerdict::stable:
      return "stable" + port_text(result);
    case StabilityVerdict::limit_cycle:
      return "limit cycle: the tool kept oscillating when it should have been at rest";
    case StabilityVerdict::pushed_through:
      return "pushed through: the tool came to rest where the static balance does not allow it";
    case StabilityVerdict::energy:
      return fmt::format("unstable: {} J of energy came from nowhere",
                         pretty(result.metric("stability.passivity_violation_J")));
    case StabilityVerdict::not_finite:
      return "unstable: a signal was NaN or infinite";
    case StabilityVerdict::refused:
      return "not judged: the run ended before";
  }
  return {};
}

std::string verdict_text(const RunResult& result) {
  std::string text;
  if (result.failure) {
    text = fmt::format("failed after {} s", pretty(result.duration_s));
  } else if (result.interrupted && !result.live) {
    text = fmt::format("interrupted after {} s of {} s; the metrics cover that part", pretty(result.duration_s),
                       pretty(result.planned_s));
  } else if (result.interrupted) {
    text = fmt::format("ended early, after {} s of {} s", pretty(result.duration_s), pretty(result.planned_s));
  } else {
    text = fmt::format("done, {} s", pretty(result.duration_s));
    if (result.reference_interrupted) text += "; its reference run was interrupted, so there are no errors";
  }
  // Of a blind run it would tell how hard the walls were.
  const std::string no_force = no_force_text(result);
  if (!no_force.empty()) text += "; " + no_force;
  // Without a force nothing can be unstable.
  const std::string stability = result.blind || result.force_was_withheld() ? "" : stability_text(result);
  if (!stability.empty()) text += "; " + stability;
  return text;
}

/// Of the force, and of the torque where there is one.
std::string error_text(const RunResult& result) {
  std::string text;
  for (const auto& [quantity, unit, spoken] : {std::tuple{"force", "N", "N"}, {"torque", "Nm", "N m"}}) {
    const double rms = result.metric(fmt::format("delivered.{}.rms_error_{}", quantity, unit));
    const double most = result.metric(fmt::format("delivered.{}.max_error_{}", quantity, unit));
    if (!std::isfinite(rms) || (!text.empty() && most == 0)) continue;
    text += fmt::format("{}{} {} {} RMS, {} {} at most", text.empty() ? "" : "; ", quantity, pretty(rms), spoken,
                        pretty(most), spoken);
  }
  return text;
}

std::string felt_line(const RunResult& result) {
  std::vector<FeltShare> shares;
  for (const auto& [quantity, threshold] : {std::pair{"force", "weber"}, {"torque", "jnd"}}) {
    const double share = result.metric(fmt::format("delivered.{}.share_beyond_{}", quantity, threshold));
    if (std::isfinite(share)) shares.push_back({quantity, share});
  }
  const auto vibration = [&](const char* name) { return result.metric(fmt::format("delivered.force.{}", name)); };
  const double mean_dB = vibration("vibration_above_threshold_dB"), Hz = vibration("vibration_above_threshold_Hz");
  std::optional<FeltVibration> felt;
  if (std::isfinite(mean_dB)) {
    felt = FeltVibration{mean_dB, std::isfinite(Hz) ? Hz : 0, vibration("worst_vibration_above_threshold_dB")};
  }
  return felt_text(shares, felt);
}

/// Which part of the run the metrics are of, where that is not all but the settling at its start.
std::string interval_text(const RunResult& result) {
  if (!result.warmth.since) {
    return fmt::format("the cold start: {} was not warm when the run ended ({})", result.warmth.last,
                       result.warmth.when);
  }
  const double from = result.metric("judged.from_s");
  const std::string because = result.judged_from == Time{} ? ""
                              : result.warmth.last.empty() ? ": as asked"
                                                           : fmt::format(": {} is warm", result.warmth.last);
  if (std::isfinite(from) && !std::isfinite(result.metric("judged.duration_s"))) {
    return fmt::format("nothing: the run was too short, {} s; it is judged from {} s on{}", pretty(result.duration_s),
                       pretty(from), because);
  }
  if (result.judged_from == Time{}) return {};
  std::string text =
      fmt::format("{} s, from {} s on{}", pretty(result.metric("judged.duration_s")), pretty(from), because);
  const double cold = result.metric("cold_start.delivered.force.rms_error_N");
  if (std::isfinite(cold)) text += fmt::format("; before, the error was {} N RMS", pretty(cold));
  return text;
}

std::string delay_text(const RunResult& result) {
  const double delay = result.metric("delivered.force.delay_ms");
  const double rate = result.metric("physics.rate_hz_median");
  std::string text = std::isfinite(delay) ? fmt::format("{} ms", pretty(delay)) : std::string();
  if (std::isfinite(rate)) text += fmt::format("{}physics at {} Hz (median)", text.empty() ? "" : "; ", pretty(rate));
  return text;
}

std::string smoothness_text(const RunResult& result) {
  const double second = result.metric("delivered.force.rms_d2_N_per_ms2");
  if (!std::isfinite(second)) return {};
  return fmt::format("{} {} RMS second difference; largest step {} N", pretty(second), unit_text("N/ms^2"),
                     pretty(result.metric("delivered.force.max_step_N")));
}

/// What the safety gate of the device did.
std::string gate_text(const RunResult& result) {
  const double engaged = result.metric("device.engaged_share");
  if (!std::isfinite(engaged)) return {};
  std::string text;
  const auto add = [&](const std::string& metric, const char* what) {
    const double count = result.metric(metric);
    if (count > 0) text += fmt::format("{}{} {:.0f}", text.empty() ? "" : ", ", what, count);
  };
  add("device.clamped_ticks", "ticks beyond the largest force:");
  add("device.slewed_ticks", "ticks with too fast a change:");
  add("device.rejected_forces", "ticks with a force that was not finite:");
  add("device.faults", "faults:");
  add("device.stale", "times without a fresh force:");
  constexpr std::string_view cause = "device.causes.";
  for (const auto& [name, value] : result.metrics) {
    if (name.starts_with(cause) && value > 0) {
      text += fmt::format("{}{}: {:.0f}", text.empty() ? "" : ", ", name.substr(cause.size()), value);
    }
  }
  return fmt::format("{}; let the force through {} of the time", text.empty() ? "limited nothing" : text,
                     percent(engaged));
}

std::string run_time_text(const RunResult& result) {
  std::string text = result.live ? fmt::format("{} CPU s live", pretty(result.cpu_s))
                                 : fmt::format("{} s, {:.0f} times real time", pretty(result.wall_s),
                                               result.duration_s / result.wall_s);
  const NodeCost* most = nullptr;
  double total = 0;
  for (const NodeCost& node : result.nodes) {
    total += node.total_s;
    if (most == nullptr || node.total_s > most->total_s) most = &node;
  }
  if (total > 0) text += fmt::format("; {} of the steps' time in {}", percent(most->total_s / total), most->node);
  return text + fmt::format("; {:.0f} MB", result.peak_memory_MB);
}

/// True for what tells no condition of an experiment: that it ended, and that the safety gate had to limit it.
bool is_blind(const HeadlineLine& line) {
  return line.name == "verdict" || line.name == "gate";
}

std::string left_out_text(const RunResult& result) {
  std::string text;
  for (const LeftOut& item : result.left_out) text += (text.empty() ? "" : ", ") + item.what;
  return text.empty() ? "nothing" : text;
}

}  // namespace

std::vector<std::string> warnings_of(const RunResult& result) {
  std::vector<std::string> texts;
  if (result.live) {
    for (const std::string& text : result.live->missing) texts.push_back("real time degraded: " + text);
  }
  std::uint64_t dropped = 0;
  for (const EdgeResult& edge : result.edges) {
    dropped += edge.metrics.dropped;
    if (edge.metrics.dropped == 0 || result.blind) continue;
    texts.push_back(
        fmt::format("dropped {} of {} messages on {}", edge.metrics.dropped, edge.metrics.delivered, edge.edge));
  }
  if (result.blind && dropped > 0)
    texts.push_back(fmt::format("dropped {} messages; summary.json tells where", dropped));
  if (!result.warmth.since && !result.failure && !result.interrupted && !result.abandoned) {
    texts.push_back(fmt::format("{} was never warm ({}): the metrics cover a cold start; make the run longer",
                                result.warmth.last, result.warmth.when));
  }
  if (const std::string text = dynamics_warning(result); !text.empty()) texts.push_back(text);
  texts.insert(texts.end(), result.remarks.begin(), result.remarks.end());
  return texts;
}

std::string no_force_text(const RunResult& result) {
  std::string text;
  for (const NoForce& one : result.no_force) {
    if (result.blind && !one.was_withheld()) continue;
    text += fmt::format("{}no force{}: {}", text.empty() ? "" : "; ", result.devices > 1 ? " on " + one.device : "",
                        one.text);
  }
  return text;
}

std::vector<HeadlineLine> headline(const RunResult& result) {
  std::vector<HeadlineLine> lines{
      {"verdict", verdict_text(result), "stability.verdict"},
      {"judged", interval_text(result), "judged.from_s"},
      {"error", error_text(result), "delivered.force.rms_error_N"},
      {"felt", felt_line(result), "delivered.force.vibration_above_threshold_dB"},
      {"delay", delay_text(result), "delivered.force.delay_ms"},
      {"smooth", smoothness_text(result), "delivered.force.rms_d2_N_per_ms2"},
      {"gate", gate_text(result), "device.engaged_share"},
      {"run time", run_time_text(result), ""},
      {"left out", left_out_text(result), ""},
  };
  std::erase_if(lines, [](const HeadlineLine& line) { return line.text.empty(); });
  return lines;
}

std::string headline_text(const RunResult& result, const std::string& report, bool all, std::size_t columns) {
  TextTable table({{""}, {""}});
  for (const std::string& text : warnings_of(result)) table.add({"warning", text});
  for (const HeadlineLine& line : headline(result)) {
    if (!result.blind || is_blind(line)) table.add({line.name, line.text});
  }
  const std::string title = result.title.empty() ? "" : ": " + result.title;
  return wrapped(fmt::format("\n{}{} (seed {})\n", result.graph, title, result.seed), columns) + table.text(columns) +
         wrapped(fmt::format("  {:<8}  {}{}\n", "report", report,
                             result.blind ? " (the run was blind: only the report describes the force)"
                             : all        ? ""
                                          : " (--all prints every metric)"),
                 columns);
}

}  // namespace tactor
