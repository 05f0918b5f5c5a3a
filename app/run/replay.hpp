// Makes the run of a live recording again under the virtual clock.
#pragma once

#include <filesystem>

namespace tactor {

class Registry;
struct Plan;
struct RecordingHeader;

/// The plan of the graph that a recording holds. Throws YamlError where it cannot be loaded here.
Plan recorded_plan(const RecordingHeader& header, Registry& registry);

/// Makes the run of `recording` again and records it into `folder`/recording.h5, which is the same file to the byte.
/// Throws InputError where the recording is of no live run, or of one that cannot be made again.
void replay_recording(const std::filesystem::path& recording, const std::filesystem::path& folder, Registry& registry);

}  // namespace tactor
