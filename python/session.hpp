// A session as Python holds it: every misuse throws, and no lock of the interpreter is held while it works.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <memory>
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

  /// Calls `work(session)` in turn, without the interpreter's lock.
  template <class Work>
  auto use(const Work& work) {
    const pybind11::gil_scoped_release released;
    const std::scoped_lock turn(lock_);
    return work(*session_);
  }

  void start();
  /// Checks for signals about every 20 ms; an interrupted live run is finished before KeyboardInterrupt passes on.
  void advance(Duration duration);
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

  std::shared_ptr<Registry> registry_;  // outlives the session
  std::unique_ptr<Session> session_;
  bool live_;
  std::atomic<bool> started_ = false, finished_ = false, failed_ = false;
  TurnLock lock_;
};

/// Adds the classes Session, Tap and Feed.
void bind_session(pybind11::module_& module);

}  // namespace tactor::python
