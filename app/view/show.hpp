// A run that is over, as a page replays it: all that it is told, made once.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "framework/session/follower.hpp"
#include "framework/session/session.hpp"

namespace tactor {

class RecordingReader;

/// The messages of a replay, in their order. docs/reference/view_protocol.md
struct Show {
  std::string hello;                ///< without `client`
  std::vector<std::string> meshes;  ///< binary messages
  std::vector<std::string> frames;  ///< binary messages, numbered from 1
};

struct ShowOptions {
  std::function<void(const std::string& note)> note;
  /// Called a few times a second with the share done in [0, 1]; false interrupts.
  std::function<bool(double share)> progress;
};

/// Runs a session of the virtual clock, which has not begun, from its start to its end. `follower`: null, or what gives
/// the reference; it must never skip. Throws RunError where it is interrupted or a step throws.
Show show_of(Session& session, Follower* follower, const ShowOptions& options);

/// The same of what a recording holds of the plan, where its run cannot be made again.
Show show_of(RecordingReader& reader, const Plan& plan, const ShowOptions& options);

}  // namespace tactor
