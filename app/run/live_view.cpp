#include "app/run/live_view.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <sstream>

#include "app/run/experiment.hpp"
#include "app/run/summary.hpp"
#include "framework/core/shown_text.hpp"
#include "framework/graph/scheduling_words.hpp"
#include "framework/realtime/safety_gate.hpp"

namespace tactor {

namespace {

std::string phase_text(const EngineStatus& status) {
  switch (status.phase) {
    case Phase::starting: {
      std::string names;
      for (const std::string& name : status.waiting_for) names += (names.empty() ? "" : ", ") + name;
      return names.empty() ? "starting" : "starting, waits for " + names;
    }
    case Phase::running:
      return "running";
    case Phase::stopping:
      return "stopping";
  }
  return {};
}

std::string safety_text(const SafetyState& safety) {
  std::string text(name_of(safety.engagement));
  if (safety.cause != SafetyCause::none) text += std::string(" (") + std::string(name_of(safety.cause)) + ")";
  if (safety.engagement == Engagement::ramping) text += fmt::format(" {:.0f} %", 100 * safety.gain);
  return text;
}

/// The steps a second between two states.
std::string rate(std::uint64_t before, std::uint64_t now, Duration between) {
  if (between.ns <= 0) return "-";
  return fmt::format("{:.0f}", static_cast<double>(now - before) / between.seconds());
}

std::string us(Duration d) {
  return fmt::format("{:.0f}", d.microseconds());
}

/// In microseconds; from a second on, where they do not matter any more and would not fit, in seconds.
std::string age(Duration d) {
  return d < Duration{1'000'000'000} ? us(d) : fmt::format("{:.1f} s", d.seconds());
}

std::string lane_text(const Scheduling& scheduling) {
  return word(scheduling.lane) + (scheduling.thread.empty() ? "" : " " + scheduling.thread);
}

std::string follower_text(const FollowerFigures& f) {
  std::string out = "\n  against the reference\n";
  if (f.error.compared == 0) {
    out += "    nothing compared yet\n";
  } else {
    out += fmt::format("    error {:.3f} N RMS in the last second, {:.3f} in all, {:.3f} at most  delay {}\n",
                       f.error.rms_lately_N, f.error.rms_N, f.error.max_N,
                       f.error.delay ? fmt::format("{:.1f} ms", f.error.delay->milliseconds()) : "-");
  }
  out += fmt::format("    {:.2f} s behind", f.behind.seconds());
  if (f.skips > 0)
    out += fmt::format("  skipped {:.1f} s, {} times: this machine is too slow", f.skipped.seconds(), f.skips);
  if (f.dropped > 0) out += fmt::format("  lost {} messages", f.dropped);
  if (f.failure) out += "\n    ended: " + *f.failure;
  return out + "\n";
}

}  // namespace

std::vector<std::string> fitted(const std::string& block, std::size_t rows, std::size_t columns) {
  std::vector<std::string> lines;
  std::istringstream in(block);
  // Names are ASCII, so a byte is a column.
  for (std::string line; std::getline(in, line);) lines.push_back(line.substr(0, columns));
  if (lines.size() <= rows) return lines;
  const std::size_t hidden = lines.size() - rows + 1;
  lines.resize(rows - 1);
  lines.push_back(fmt::format("  ... and {} rows that this terminal has no room for", hidden).substr(0, columns));
  return lines;
}

namespace {

/// The reference, the nodes and the edges.
std::string pipeline_text(const Plan& plan, const EngineStatus& before, const LiveLook& look) {
  const EngineStatus& now = look.status;
  const Duration between = now.now - before.now;
  std::string out = look.follower ? follower_text(*look.follower) : "";
  out += fmt::format("\n  {:<24} {:<18} {:>9} {:>13}\n", "node", "lane", "steps/s", "missed ticks");
  for (std::size_t n = 0; n < now.nodes.size(); ++n) {
    const std::uint64_t steps = before.nodes.empty() ? 0 : before.nodes[n].steps;
    out += fmt::format("  {:<24.24} {:<18.18} {:>9} {:>13}{}\n", plan.nodes[n].name,
                       lane_text(plan.nodes[n].scheduling), rate(steps, now.nodes[n].steps, between),
                       now.nodes[n].missed_ticks, now.nodes[n].stalled ? "  stalled" : "");
  }
  out += fmt::format("\n  {:<45} {:>7} {:>7} {:>7} {:>7}\n", "edge", "age p50", "p99", "max us", "drops");
  for (std::size_t e = 0; e < now.edges.size(); ++e) {
    const EdgeStatus& edge = now.edges[e];
    out += fmt::format("  {:<45.45} {:>7} {:>7} {:>7} {:>7}\n", plan.edges[e].spec.name(), age(edge.age.p50),
                       age(edge.age.p99), age(edge.age.max), edge.metrics.dropped);
  }
  return out;
}

}  // namespace

std::string live_block(const Plan& plan, const EngineStatus& before, const LiveLook& look) {
  const EngineStatus& now = look.status;
  const bool blind = experiment_of(plan).has_value();
  const Duration planned = plan.graph.duration;
  std::string out =
      fmt::format("  {}  {:.1f} {}  {}\n", plan.graph.name, std::max(0.0, now.now.seconds()),
                  planned == until_stopped ? "s" : "of " + pretty(planned.seconds()) + " s", phase_text(now));
  for (std::size_t i = 0; i < now.devices.size(); ++i) {
    const DeviceStatus& d = now.devices[i];
    out += fmt::format("\n  {:<20} {}\n", plan.nodes[d.node].name, look.safety[i] ? safety_text(*look.safety[i]) : "");
    out += fmt::format("    ticks {}  missed {}  allocations {}  page faults {}\n", d.ticks, d.missed,
                       d.heap_calls ? std::to_string(*d.heap_calls) : "-", d.page_faults);
    out += fmt::format("    wake-up p50 {}  p99 {}  p99.9 {}  max {} us", us(d.wake_latency.p50),
                       us(d.wake_latency.p99), us(d.wake_latency.p99_9), us(d.wake_latency.max));
    // How old a force is, and what its evaluation takes, tells a method.
    out += blind ? "\n"
                 : fmt::format("  body p99 {:.1f} us\n    sample to force p50 {:.1f}  p99 {:.1f} ms\n",
                               d.body_time.p99.microseconds(), d.end_to_end.p50.milliseconds(),
                               d.end_to_end.p99.milliseconds());
  }
  if (!blind) out += pipeline_text(plan, before, look);
  if (look.record_dropped > 0) out += fmt::format("  the recording lost {} messages\n", look.record_dropped);
  std::string cut;
  for (const std::string& row : fitted(out, std::string::npos, 100)) cut += row + "\n";
  return cut;
}

LiveView::LiveView(const Plan& plan) : plan_(plan), terminal_(isatty(STDERR_FILENO) == 1) {}

void LiveView::draw(const LiveLook& look) {
  const EngineStatus& status = look.status;
  // A quarter of a second is often enough to read.
  if (!terminal_ || (rows_ > 0 && status.now - drawn_.now < Duration{250'000'000})) return;
  winsize size{};
  const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 1 && size.ws_col > 0;
  // The row below the block is the cursor's.
  const std::vector<std::string> rows =
      fitted(live_block(plan_, drawn_, look), known ? size.ws_row - 1U : 23U, known ? size.ws_col : 80U);
  drawn_ = status;
  // Written in one piece over the block before, each row cleared to its end, so that nothing flickers.
  std::string out = back();
  for (const std::string& row : rows) out += shown_text(row) + "\x1b[K\n";
  draw_on_terminal(STDERR_FILENO, out + "\x1b[J");
  rows_ = rows.size();
}

void LiveView::clear() {
  if (rows_ > 0) draw_on_terminal(STDERR_FILENO, back() + "\x1b[J");
  rows_ = 0;
}

std::string LiveView::back() const {
  return rows_ > 0 ? fmt::format("\r\x1b[{}A", rows_) : "";
}

}  // namespace tactor
