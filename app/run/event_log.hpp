// What happens in a run, told to programs: JSON lines, and levels for the journal of systemd.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/output.hpp"
#include "app/run/live_look.hpp"
#include "app/run/run.hpp"

namespace tactor {

/// The kinds of events. The log has the words of these names.
enum class EventKind : std::uint8_t {
  note,          ///< something about the input that does not stop the run
  started,       ///< the run has begun
  privilege,     ///< the system has refused one, so real time is degraded
  running,       ///< every node upstream of a device has stepped: the devices may engage
  gate,          ///< the safety gate of a device has opened or closed, with the cause
  stalled,       ///< a step does not come back, or has come back after that
  missed_ticks,  ///< the loop of a device was late; at most once a minute
  dropped,       ///< an edge has dropped messages; at most once a minute
  ended,         ///< the run is over, as it should
  failed,        ///< the run has failed
};

/// `missed_ticks`
std::string_view name_of(EventKind kind);

struct RunEvent {
  LogLevel level = LogLevel::info;
  EventKind kind = EventKind::note;
  std::string node;        ///< the node that it is about; empty: the run
  std::optional<Time> at;  ///< by the clock of the run; empty: before its start
  std::string message;     ///< a sentence that names the node
};

/// One line of JSON without its end: `time` (UTC, ISO 8601), `run_s` (s or null), `level`, `kind`, `node` (or null) and
/// `message`. Bytes that are no UTF-8 are replaced.
std::string to_json_line(const RunEvent& event, std::int64_t unix_ms);

/// Where the events of a run go. Used by one thread. A disk or a pipe that refuses a line is told once on standard
/// error and gets no more: it must not end a run that holds a force.
class EventLog {
 public:
  /// `json`: the file that gets a line at its end for each event, `-` for standard output; absent: none. Throws
  /// InputError where it cannot be opened.
  explicit EventLog(const std::optional<std::filesystem::path>& json);
  /// Notes and failures go to standard error as they always did. If standard error is the journal, all events do.
  void tell(const RunEvent& event);
  /// The JSON line alone, of what the command prints by itself.
  void write(const RunEvent& event);

 private:
  struct Close {
    void operator()(std::FILE* file) const {
      if (file != stdout) std::fclose(file);
    }
  };
  std::unique_ptr<std::FILE, Close> json_;
  std::string name_;
};

/// Tells what changes from one look at a live run to the next. `plan` and `log` outlive it.
class LiveEvents {
 public:
  LiveEvents(const Plan& plan, EventLog& log);
  void look(const LiveLook& seen);

 private:
  /// A count that only grows, and is told at most once a minute.
  struct Counted {
    std::uint64_t told = 0;
    std::optional<Time> at;
    /// True, and taken as told, if `count` is new and the last time is a minute ago.
    bool is_news(std::uint64_t count, Time now);
  };
  void tell(LogLevel level, EventKind kind, const std::string& node, std::string message);
  void look_at_gates(const LiveLook& seen);
  void look_at_steps(const EngineStatus& status);

  const Plan& plan_;
  EventLog& log_;
  Time now_;
  bool started_ = false, running_ = false;
  std::vector<std::optional<SafetyState>> gates_;  // by device, as told last
  std::vector<bool> stalled_;                      // by node
  std::vector<Counted> missed_;                    // by device
  std::vector<Counted> dropped_;                   // by edge
};

/// The last event of a run: `ended` with its verdict, or `failed` with the node whose step threw or stalled, if it was
/// one.
RunEvent last_event(const Plan& plan, const RunResult& result);

}  // namespace tactor
