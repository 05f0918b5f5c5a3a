// One task of a study on a cluster: what a job script starts.
#pragma once

#include <cstddef>
#include <filesystem>

namespace tactor {

/// Makes what is missing of one chunk, or all that a stage of one task does. Returns the exit code: 0 where all of it
/// is there. Asked to end, it keeps what it has and returns 1. Throws InputError and RunError. `submission` and
/// `index`: which, as in Submission. Forks workers, so the program must have no other thread.
int run_cluster_task(const std::filesystem::path& out, std::size_t submission, std::size_t index);

}  // namespace tactor
