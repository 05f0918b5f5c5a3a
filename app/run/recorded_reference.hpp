// A recording in the place of the reference run: a truth that another program has made.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "framework/engine/reference.hpp"
#include "framework/graph/plan.hpp"

namespace tactor {

/// What the sinks of a plan are compared with, read from a recording: for each of their reference inputs the stream
/// named as the output that feeds it (`coupling.force`). Its stamps say when a value holds, and grow; its values are
/// finite; it reaches to the end of the run, or to 0.1 s before it. Throws InputError with the file where it does not,
/// or where the stream is missing or of another type.
Reference recorded_reference(const std::filesystem::path& recording, const Plan& plan);

/// The path with `{graph}` and `{seed}` replaced by those of a run.
std::filesystem::path recording_of(const std::string& pattern, const std::string& graph, std::uint64_t seed);

}  // namespace tactor
