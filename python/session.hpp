// A session as Python holds it: every misuse throws, and no lock of the interpreter is held while it works.
#pragma once

#include <pybind11/pybind11.h>
#include <sys/types.h>
#include <unistd.h>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "framework/session/session.hpp"
#include "python/graph.hpp"
#include "python/release_lock.hpp"
#include "python/tap_buffer.hpp"

namespace tactor::python {

/// The session and what guards it. Shared with its taps and feeds, which must not outlive it unnoticed.
class SessionState {
 public:
  SessionState(const Graph& graph, const SessionOptions& options);
  SessionState(const SessionState&) = delete;
  SessionState& operator=(const SessionState&) = delete;
  ~SessionState();

  /// Calls `task(session)` in turn, without the interpreter's lock.
  template <class Task>
  auto use(const Task& task) {
    if (is_foreign()) throw RunError("this session belongs to the process that this one was forked from");
    return without_lock(
        [&] {
          const std::scoped_lock turn(lock_);
          end_forgotten();
          return task(*session_);
        },
        live_);
  }
  /// At the next use these messages end. Any thread; it waits for nothing, so that a destructor may call it.
  void forget(Session::Subscribed messages);

  void start();
  /// Checks for signals about every 20 ms; an interrupted live run is finished before KeyboardInterrupt passes on.
  void advance(Duration duration);
  /// The same for what `part` does: it lets at most `slice()` of the run pass, and returns false once it is done.
  /// `what` is the call that needs a running session. Starts the session if nobody has.
  void advance_while(const char* what, const std::function<bool(Session&)>& part);
  /// The longest part of the run that passes before it looks for signals.
  [[nodiscard]] Duration slice() const { return slice_; }
  /// Returns why a live run ended before its time.
  std::optional<std::string> finish();
  void stop();
  [[nodiscard]] bool is_running();
  [[nodiscard]] double now();
  [[nodiscard]] bool is_live() const { return live_; }
  [[nodiscard]] bool is_started() const { return started_; }
  [[nodiscard]] bool is_finished() const { return finished_; }
  /// Throws RunError where it has not been started or is finished; `what` is the call that needs it.
  void demand_running(const char* what) const;

 private:
  void finish_now(Session& session);
  /// In the child of a fork, which has none of the session's threads.
  [[nodiscard]] bool is_foreign() const { return getpid() != process_; }
  void end_forgotten();

  pid_t process_ = getpid();            // whose session it is
  std::shared_ptr<Registry> registry_;  // outlives the session
  std::unique_ptr<Session> session_;
  bool live_;
  Duration slice_;
  std::atomic<bool> started_ = false, finished_ = false, failed_ = false;
  TurnLock lock_;
  std::mutex forgotten_lock_;
  std::vector<Session::Subscribed> forgotten_;
};

/// Adds the classes Session, Tap and Feed.
void bind_session(pybind11::module_& module);

}  // namespace tactor::python
