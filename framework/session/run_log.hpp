// The log of a live session: writing it into the recording and reading it back.
#pragma once

#include "framework/engine/replay_engine.hpp"
#include "framework/record/recorder.hpp"
#include "framework/session/session.hpp"

namespace tactor {

/// Writes a message of a recorder's stream.
using Write = std::function<void(std::size_t stream, const Stamp& stamp, const void* value)>;

/// Adds the streams `steps`, `ticks`, `sets` and `stop` to a recording that takes no message yet, and, for each output
/// that a program feeds and somebody reads, its messages as `NODE.OUTPUT`, where the graph does not record them.
/// Records them while the session goes on; before its start.
void record_run(Session& session, Recorder& recorder, const Write& write);

/// The log of a recorded live run of that plan. Throws InputError if the recording has none, or has lost a part.
RunLog read_run_log(RecordingReader& reader, const Plan& plan);

}  // namespace tactor
