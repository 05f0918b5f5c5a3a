// A recording in the place of the reference run: a truth that another program has made.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "framework/engine/reference.hpp"
#include "framework/graph/plan.hpp"

namespace tactor {

/// What the sinks of a plan are compared with, read from a recording: for each of their reference inputs the stream
/// named as the output that feeds it (`coupling.force`). Its stamps say when a value holds, and grow by 50 ms at most;
/// its values are finite; it covers the run but for 0.1 s at either end. Throws InputError with the file where it does
/// not, or where the stream is missing or of another type; and where no recording can judge runs of the plan, because
/// the hand's path is not known before the run: the loop is closed, or the clock is real.
Reference recorded_reference(const std::filesystem::path& recording, const Plan& plan);

/// The path with `{graph}` and `{seed}` replaced by those of a run.
std::filesystem::path recording_of(const std::string& pattern, const std::string& graph, std::uint64_t seed);

}  // namespace tactor
