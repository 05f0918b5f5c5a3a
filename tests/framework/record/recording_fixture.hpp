// A folder of its own for a test, and a small recording whose values follow from their row.
#pragma once

#include <cstddef>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "framework/core/messages.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/record/recorder.hpp"

namespace tactor::testing {

class Folder : public TemporaryFolder {
 public:
  [[nodiscard]] std::filesystem::path operator/(const char* name) const { return path() / name; }
};

inline std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

inline const RecordingHeader header{"clock: virtual\nname: \u00fc\n", 0xfedcba9876543210ULL, "0.1.0"};

/// Row i of the stream of forces: valid after i ms, visible 0.25 ms later.
inline Stamp stamp_of(std::int64_t i) {
  return {Time{i * 1'000'000}, Time{i * 1'000'000 + 250'000}, static_cast<std::uint64_t>(i)};
}
inline Wrench wrench_of(std::int64_t i) {
  const auto v = static_cast<double>(i);
  return {{0.1 * v, -v, 1 / (v + 1)}, {1e-3 * v, 0, 1e300}};
}
inline DeviceState device_of(std::int64_t i) {
  DeviceState state;
  state.X_WD.p = {0.5 * static_cast<double>(i), 1, 2};
  state.buttons = static_cast<std::int32_t>(i % 3) - 1;
  return state;
}

/// Writes `rows` forces and a device state for every tenth; flushes after every `flush_every` rows where that is not 0.
inline void write_rows(Recorder& recorder, std::int64_t rows, std::int64_t flush_every = 0) {
  const std::size_t force = recorder.add_stream("coupling.force", message_type<Wrench>());
  const std::size_t state = recorder.add_stream("device.state", message_type<DeviceState>());
  for (std::int64_t i = 0; i < rows; ++i) {
    const Wrench wrench = wrench_of(i);
    recorder.write(force, stamp_of(i), &wrench);
    if (i % 10 == 0) {
      const DeviceState device = device_of(i);
      recorder.write(state, stamp_of(i), &device);
    }
    if (flush_every > 0 && i % flush_every == 0) recorder.flush();
  }
}

/// The number of rows of the stream of forces where all read rows hold what was written; -1 where one does not.
inline std::int64_t read_and_compare(RecordingReader& reader) {
  std::int64_t rows = 0;
  for (std::size_t s = 0; s < reader.streams().size(); ++s) {
    const RecordedStream& stream = reader.streams()[s];
    MessageBatch messages(stream.type);
    reader.read(s, 0, stream.count, messages);
    const bool forces = same_type(stream.type, message_type<Wrench>());
    for (std::size_t i = 0; i < messages.size(); ++i) {
      const std::int64_t row = static_cast<std::int64_t>(i) * (forces ? 1 : 10);
      const Stamp expected = stamp_of(row);
      const Stamp& stamp = messages.stamp(i);
      if (stamp.valid != expected.valid || stamp.produced != expected.produced || stamp.sequence != expected.sequence) {
        return -1;
      }
      const std::byte* at = messages.value(i);
      if (forces) {
        const Wrench wrench = wrench_of(row);
        if (std::memcmp(at, &wrench, sizeof wrench) != 0) return -1;
      } else {
        // Up to the padding at the end, which is no field.
        const DeviceState device = device_of(row);
        if (std::memcmp(at, &device, offsetof(DeviceState, buttons) + sizeof device.buttons) != 0) return -1;
      }
    }
    if (forces) rows = static_cast<std::int64_t>(messages.size());
  }
  return rows;
}

}  // namespace tactor::testing
