// The samples of a session for a page: a tap for each stream, read as chunks.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "app/view/samples.hpp"
#include "app/view/shown_streams.hpp"
#include "framework/session/follower.hpp"
#include "framework/session/session.hpp"

namespace tactor {

/// Made and ended on the session's thread; `collect` may be called on another one.
class StreamTaps {
 public:
  /// Session and follower outlive it. `follower`: null, or what gives the reference; not started yet. `drawn`: of the
  /// session's graph.
  StreamTaps(Session& session, Follower* follower, const DrawnScene& drawn, bool blind = false);
  /// In the order of `hello`.
  [[nodiscard]] const std::vector<ShownStream>& streams() const { return streams_; }
  /// What has come since the last call as a chunk; empty where nothing has.
  [[nodiscard]] std::string collect();
  /// Messages that were lost because `collect` was not called in time.
  [[nodiscard]] std::uint64_t dropped() const;

 private:
  struct Source {
    std::unique_ptr<Session::OutputTap> tap;  // null: the reference
    double next_row = 0;                      // s, rows before are left out
  };
  void collect(std::size_t stream);
  void take_reference();

  std::vector<ShownStream> streams_;
  std::vector<Source> sources_;
  ChunkWriter writer_;
  ShownRows rows_;
  double end_ = 0;    // s
  std::mutex mutex_;  // over reference_
  std::vector<Stamped<Wrench>> reference_;
};

}  // namespace tactor
