#include "app/run/event_log.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <nlohmann/json.hpp>

#include "app/run/headline.hpp"
#include "framework/core/check.hpp"
#include "framework/graph/texts.hpp"
#include "framework/realtime/safety_gate.hpp"

namespace tactor {

namespace {

constexpr Duration between_counts{60'000'000'000};

std::string_view level_name(LogLevel level) {
  switch (level) {
    case LogLevel::error:
      return "error";
    case LogLevel::warning:
      return "warning";
    case LogLevel::notice:
      return "notice";
    case LogLevel::info:
      return "info";
  }
  return {};
}

/// `2026-11-30T22:37:41.123Z`
std::string utc_text(std::int64_t unix_ms) {
  return fmt::format("{:%FT%T}.{:03}Z", fmt::gmtime(static_cast<std::time_t>(unix_ms / 1000)), unix_ms % 1000);
}

/// A hand that lets go of a button is no trouble, and neither is the begin or the end of a run.
LogLevel level_of(const SafetyState& gate) {
  if (gate.engagement == Engagement::fault) return LogLevel::error;
  const bool is_usual = gate.cause == SafetyCause::none || gate.cause == SafetyCause::dead_man ||
                        gate.cause == SafetyCause::not_permitted;
  return is_usual ? LogLevel::info : LogLevel::warning;
}

}  // namespace

std::string_view name_of(EventKind kind) {
  switch (kind) {
    case EventKind::note:
      return "note";
    case EventKind::started:
      return "started";
    case EventKind::privilege:
      return "privilege";
    case EventKind::running:
      return "running";
    case EventKind::gate:
      return "gate";
    case EventKind::stalled:
      return "stalled";
    case EventKind::missed_ticks:
      return "missed_ticks";
    case EventKind::dropped:
      return "dropped";
    case EventKind::ended:
      return "ended";
    case EventKind::failed:
      return "failed";
  }
  return {};
}

std::string to_json_line(const RunEvent& event, std::int64_t unix_ms) {
  using Line = nlohmann::ordered_json;
  const Line line{{"time", utc_text(unix_ms)},
                  {"run_s", event.at ? Line(event.at->seconds()) : Line()},
                  {"level", level_name(event.level)},
                  {"kind", name_of(event.kind)},
                  {"node", event.node.empty() ? Line() : Line(event.node)},
                  {"message", event.message}};
  return line.dump(-1, ' ', false, Line::error_handler_t::replace);
}

EventLog::EventLog(const std::optional<std::filesystem::path>& json) {
  if (!json) return;
  name_ = json->string();
  json_.reset(name_ == "-" ? stdout : std::fopen(json->c_str(), "ae"));
  if (!json_) throw InputError("--log-json " + name_ + ": cannot write this file: " + std::strerror(errno));
}

void EventLog::tell(const RunEvent& event) {
  const bool always = event.kind == EventKind::note || event.kind == EventKind::failed;
  if (always || tells_the_journal()) tactor::tell("tactor: " + event.message + "\n", event.level);
  write(event);
}

void EventLog::write(const RunEvent& event) {
  if (!json_) return;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const std::string line =
      to_json_line(event, std::chrono::duration_cast<std::chrono::milliseconds>(now).count()) + "\n";
  if (std::fputs(line.c_str(), json_.get()) >= 0 && std::fflush(json_.get()) == 0) return;
  tell_failure("--log-json " + name_ + ": " + std::strerror(errno) + "; the run goes on without this log");
  json_.reset();
}

LiveEvents::LiveEvents(const Plan& plan, EventLog& log)
    : plan_(plan), log_(log), stalled_(plan.nodes.size(), false), dropped_(plan.edges.size()) {}

bool LiveEvents::Counted::is_news(std::uint64_t count, Time now) {
  if (count <= told || (at && now - *at < between_counts)) return false;
  told = count;
  at = now;
  return true;
}

void LiveEvents::tell(LogLevel level, EventKind kind, const std::string& node, std::string message) {
  log_.tell({level, kind, node, now_, std::move(message)});
}

void LiveEvents::look(const LiveLook& seen) {
  now_ = std::max(seen.status.now, Time{});
  if (!started_) {
    started_ = true;
    tell(LogLevel::info, EventKind::started, "",
         fmt::format("{} has started, duration {}", plan_.graph.name, duration_text(plan_.graph.duration)));
    for (const std::string& text : seen.status.missing) {
      tell(LogLevel::warning, EventKind::privilege, "", "real time degraded: " + text);
    }
  }
  if (!running_ && seen.status.phase == Phase::running) {
    running_ = true;
    tell(LogLevel::info, EventKind::running, "", "every node has stepped: the devices may engage");
  }
  look_at_gates(seen);
  look_at_steps(seen.status);
}

void LiveEvents::look_at_gates(const LiveLook& seen) {
  gates_.resize(seen.safety.size());
  for (std::size_t d = 0; d < seen.safety.size(); ++d) {
    const std::optional<SafetyState>& now = seen.safety[d];
    std::optional<SafetyState>& told = gates_[d];
    if (!now || (now->engagement == Engagement::ramping && now->cause == SafetyCause::none)) continue;
    if (told && told->engagement == now->engagement && told->cause == now->cause) continue;
    told = now;
    const std::string& device = plan_.nodes[seen.status.devices[d].node].name;
    std::string text = fmt::format("the gate of {} is {}", device, name_of(now->engagement));
    if (now->cause != SafetyCause::none) text += fmt::format(": {}", name_of(now->cause));
    tell(level_of(*now), EventKind::gate, device, std::move(text));
  }
}

void LiveEvents::look_at_steps(const EngineStatus& status) {
  for (std::size_t n = 0; n < status.nodes.size(); ++n) {
    if (status.nodes[n].stalled == stalled_[n]) continue;
    stalled_[n] = status.nodes[n].stalled;
    tell(stalled_[n] ? LogLevel::warning : LogLevel::info, EventKind::stalled, plan_.nodes[n].name,
         fmt::format("node {} {}", plan_.nodes[n].name, stalled_[n] ? "has stalled" : "steps again"));
  }
  missed_.resize(status.devices.size());
  for (std::size_t d = 0; d < status.devices.size(); ++d) {
    if (!plan_.nodes[status.devices[d].node].info->actuator) continue;
    const std::uint64_t before = missed_[d].told;
    if (!missed_[d].is_news(status.devices[d].missed, now_)) continue;
    const std::string& name = plan_.nodes[status.devices[d].node].name;
    tell(LogLevel::warning, EventKind::missed_ticks, name,
         fmt::format("node {} has missed {} ticks more, {} in all", name, status.devices[d].missed - before,
                     status.devices[d].missed));
  }
  for (std::size_t e = 0; e < status.edges.size(); ++e) {
    const std::uint64_t before = dropped_[e].told;
    const std::uint64_t now = status.edges[e].metrics.dropped;
    if (!dropped_[e].is_news(now, now_)) continue;
    const EdgeSpec& edge = plan_.edges[e].spec;
    tell(LogLevel::warning, EventKind::dropped, edge.to_node,
         fmt::format("the edge {} has dropped {} messages more, {} in all", edge.name(), now - before, now));
  }
}

RunEvent last_event(const Plan& plan, const RunResult& result) {
  const Time end = Time::from_seconds(result.duration_s);
  if (!result.failure) {
    const std::vector<HeadlineLine> lines = headline(result);
    return {LogLevel::info, EventKind::ended, "", end, lines.empty() ? "done" : lines.front().text};
  }
  std::string node;
  if (result.live) {
    const std::vector<NodeStatus>& nodes = result.live->nodes;
    const auto is_to_blame = [&nodes](const auto& test) { return std::find_if(nodes.begin(), nodes.end(), test); };
    auto found = is_to_blame([](const NodeStatus& one) { return one.failed; });
    if (found == nodes.end()) found = is_to_blame([](const NodeStatus& one) { return one.stalled; });
    if (found != nodes.end()) node = plan.nodes[static_cast<std::size_t>(found - nodes.begin())].name;
  }
  return {LogLevel::error, EventKind::failed, std::move(node), end, *result.failure};
}

}  // namespace tactor
