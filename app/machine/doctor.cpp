// The trials of the verb `doctor`, and its two reports.
#include "app/machine/doctor.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string_view>

#include "app/machine/device_access.hpp"
#include "framework/core/shown_text.hpp"

namespace tactor {

namespace {

constexpr std::size_t text_width = 100;
constexpr std::size_t grade_width = 12;  ///< of the margin that holds the grade, or what the lines below it are
constexpr std::size_t title_width = 20;

std::string_view policy_name(SchedulingPolicy policy) {
  return policy == SchedulingPolicy::fifo          ? "SCHED_FIFO"
         : policy == SchedulingPolicy::round_robin ? "SCHED_RR"
                                                   : "SCHED_OTHER";
}

/// `text` broken at spaces into lines of at most `room` columns; a word that is longer stays whole, to be copied.
std::vector<std::string> wrapped_lines(std::string_view text, std::size_t room) {
  std::vector<std::string> lines;
  std::string line;
  while (!text.empty()) {
    const std::size_t space = text.find(' ');
    const std::string_view word = text.substr(0, space);
    text = space == std::string_view::npos ? std::string_view() : text.substr(space + 1);
    if (!line.empty() && line.size() + 1 + word.size() > room) lines.push_back(std::exchange(line, ""));
    if (!line.empty()) line += ' ';
    line += word;
  }
  lines.push_back(line);
  return lines;
}

/// `head`, which takes up `margin` columns on the terminal, and beside it `text` on as many lines as it takes.
std::string beside(const std::string& head, std::size_t margin, std::string_view text) {
  std::string out;
  for (const std::string& line : wrapped_lines(text, text_width - margin)) {
    out += (out.empty() ? head : std::string(margin, ' ')) + line + "\n";
  }
  return out;
}

/// The same for a command and its comment, each on lines of its own, so that the command can be copied whole.
std::string beside_command(const std::string& head, std::size_t margin, std::string_view command) {
  const std::size_t comment = command.find(" # ");
  std::string out = beside(head, margin, command.substr(0, comment));
  if (comment != std::string_view::npos) out += beside(std::string(margin, ' '), margin, command.substr(comment + 1));
  return out;
}

/// The grade, in green, yellow or red on a terminal, and blanks up to `columns`.
std::string grade_text(Grade grade, bool coloured, std::size_t columns = 0) {
  const std::string_view name = to_string(grade);
  const std::string blanks(columns > name.size() ? columns - name.size() : 0, ' ');
  if (!coloured) return std::string(name) + blanks;
  const int colour = grade == Grade::ok ? 32 : grade == Grade::degraded ? 33 : 31;
  return fmt::format("\x1b[{}m{}\x1b[0m{}", colour, name, blanks);
}

std::string findings_text(const std::vector<Finding>& findings, bool coloured) {
  std::string out;
  for (const Finding& finding : findings) {
    const std::string head =
        fmt::format("  {}  {:<{}}", grade_text(finding.grade, coloured, 8), shown_text(finding.title), title_width);
    // Devices and the system tell of themselves.
    out += beside(head, grade_width + title_width, shown_text(finding.found));
    if (!finding.cost.empty()) out += beside("      cost  ", grade_width, shown_text(finding.cost));
    if (!finding.remedy.empty()) out += beside_command("      fix   ", grade_width, shown_text(finding.remedy));
  }
  return out;
}

std::string trial_table(const Diagnosis& diagnosis) {
  std::string out = fmt::format("  An empty loop at {:g} Hz for {:g} s each; wake-up latency in us:\n\n",
                                diagnosis.rate, diagnosis.length.seconds());
  out += fmt::format("  {:<23}{:<22}{:>9}{:>9}{:>9}{:>9}{:>13}\n", "policy", "beside it", "p50", "p99", "max", "missed",
                     "page faults");
  for (const LoopTrial& trial : diagnosis.trials) {
    std::string policy(policy_name(trial.granted.policy));
    if (trial.nice != 0) policy += fmt::format(", nice {}", trial.nice);
    out += fmt::format("  {:<23}{:<22}{:>9.1f}{:>9.1f}{:>9.1f}{:>9}{:>13}\n", policy,
                       trial.beside_load ? "every core computing" : "the machine as it is", trial.p50.microseconds(),
                       trial.p99.microseconds(), trial.max.microseconds(), trial.missed, trial.page_faults);
  }
  out += fmt::format("\n  The loop itself costs {} ns a tick, {:.3f} % of a period.\n", diagnosis.bookkeeping.ns,
                     100 * diagnosis.bookkeeping.seconds() * diagnosis.rate);
  return out;
}

nlohmann::ordered_json to_json(const std::vector<Finding>& findings) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Finding& finding : findings) {
    json.push_back({{"id", finding.id},
                    {"grade", to_string(finding.grade)},
                    {"found", finding.found},
                    {"cost", finding.cost},
                    {"remedy", finding.remedy}});
  }
  return json;
}

/// What SCHED_FIFO is worth here, in the measured metrics.
void measure_fifo(Diagnosis& diagnosis) {
  std::string metrics;
  for (const LoopTrial& trial : diagnosis.trials) {
    if (!trial.beside_load) continue;
    metrics += fmt::format("{}{:.0f} us {}", metrics.empty() ? "" : ", ", trial.p99.microseconds(),
                           trial.granted.policy != SchedulingPolicy::other ? "with it"
                           : trial.nice < 0                                ? "with niceness instead"
                                                                           : "without it");
  }
  const std::string text = "beside computing threads, p99 of the wake-up here: " + metrics;
  for (Finding& finding : diagnosis.findings) {
    if (finding.id != "fifo") continue;
    if (finding.cost.empty()) finding.found += "; " + text;
    if (!finding.cost.empty()) finding.cost += " Measured " + text + ".";
  }
}

}  // namespace

Diagnosis diagnose(Duration length) {
  const SystemFacts facts = probe_system();
  Diagnosis diagnosis{.kernel = facts.kernel, .findings = judge(facts), .devices = device_findings(), .length = length};
  diagnosis.bookkeeping = measure_bookkeeping();
  std::vector<ThreadSettings> policies{{}};
  if (!facts.fifo_refused || facts.least_nice < 0) policies.push_back({SchedulingPolicy::fifo, 80, std::nullopt});
  for (const bool beside_load : {false, true}) {
    for (const ThreadSettings& settings : policies)
      diagnosis.trials.push_back(try_loop(settings, diagnosis.rate, length, beside_load));
  }
  measure_fifo(diagnosis);
  return diagnosis;
}

nlohmann::ordered_json to_json(const Diagnosis& diagnosis) {
  nlohmann::ordered_json json;
  json["grade"] = to_string(worst(diagnosis.findings));
  json["kernel"] = diagnosis.kernel;
  json["findings"] = to_json(diagnosis.findings);
  json["devices"] = to_json(diagnosis.devices);
  json["bookkeeping_ns"] = diagnosis.bookkeeping.ns;
  json["trials"] = nlohmann::ordered_json::array();
  for (const LoopTrial& trial : diagnosis.trials) {
    json["trials"].push_back(
        {{"policy", policy_name(trial.granted.policy)},
         {"priority", trial.granted.priority},
         {"nice", trial.nice},
         {"beside_load", trial.beside_load},
         {"rate_hz", diagnosis.rate},
         {"length_s", diagnosis.length.seconds()},
         {"ticks", trial.ticks},
         {"missed", trial.missed},
         {"page_faults", trial.page_faults},
         {"wake_latency_us",
          {{"p50", trial.p50.microseconds()}, {"p99", trial.p99.microseconds()}, {"max", trial.max.microseconds()}}}});
  }
  return json;
}

std::string diagnosis_text(const Diagnosis& diagnosis, bool coloured) {
  std::string out = fmt::format("\n  Real time on this machine: {}\n  Linux {}\n\n",
                                grade_text(worst(diagnosis.findings), coloured), shown_text(diagnosis.kernel));
  out += findings_text(diagnosis.findings, coloured);
  out += "\n  Devices\n\n" + findings_text(diagnosis.devices, coloured);
  return out + "\n" + trial_table(diagnosis);
}

}  // namespace tactor
