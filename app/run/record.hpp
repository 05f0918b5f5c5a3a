// Gives the messages of a session to a recorder.
#pragma once

#include <memory>

#include "framework/record/recorder.hpp"
#include "framework/session/session.hpp"

namespace tactor {

/// Records the plan's streams from the start of the session on, and of a live run, or of its replay, what a replay asks
/// for (see record_run). The recorder takes no stream of others. True in the result once the recorder has thrown: then
/// it takes nothing more.
std::shared_ptr<bool> record(Session& session, Recorder& recorder);

}  // namespace tactor
