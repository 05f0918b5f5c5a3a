// Export of a recorded stream as comma-separated values.
#pragma once

#include <ostream>

#include "framework/record/recorder.hpp"

namespace tactor {

/// Writes the stream, one message a row: `valid_s`, `produced_s`, `sequence`, then every value of the message with its
/// SI unit in the header (`force_x [N]`). Vectors are x y z, quaternions w x y z, longer fields are numbered from 0.
/// Times are exact; numbers have as many digits (at most 17) as it takes to read back the same double.
/// Throws InputError where the recording is damaged and RunError where `out` does not take the text.
void export_csv(RecordingReader& reader, std::size_t stream, std::ostream& out);

}  // namespace tactor
