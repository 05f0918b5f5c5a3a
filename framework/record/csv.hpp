// Recorded streams as comma-separated values, and back.
//
// One message a row: `valid_s`, `produced_s`, `sequence`, then every value of the message with its SI unit in the
// heading (`force_x [N]`). Vectors are x y z, quaternions w x y z, other arrays numbered from 0; fields of records have
// a dot (`contact[3].distance [m]`). An enumeration stands by its word. A field that changes size has one column for
// each value of an element; a cell holds those of all elements, separated by spaces. Times are exact; numbers have as
// many digits (at most 17) as it takes to read back the same bits.
#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>

#include "framework/record/recorder.hpp"

namespace tactor {

/// Writes a stream. Throws InputError where the recording is damaged and RunError where `out` does not take the text.
void export_csv(RecordingReader& reader, std::size_t stream, std::ostream& out);

/// Reads what `export_csv` has written of messages of that type, and hands on one message after the other. Columns may
/// be in any order; all must be there. Throws InputError with file and line where the text is another.
void import_csv(const std::filesystem::path& path, const MessageType& type,
                const std::function<void(const Stamp& stamp, const void* value)>& take);

}  // namespace tactor
