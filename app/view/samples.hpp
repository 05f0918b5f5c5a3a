// The bytes of what a page draws: chunks of samples, frames of chunks, meshes. docs/reference/view_protocol.md
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "framework/core/time.hpp"

namespace tactor {

/// Makes a chunk, section by section.
class ChunkWriter {
 public:
  ChunkWriter();
  /// Rows of stream `stream`: their times in s, and as many rows of values.
  void add_rows(std::size_t stream, std::span<const double> times, std::span<const float> values);
  /// A set of stream `stream`: `count` rows of values that hold from `time` on.
  void add_set(std::size_t stream, double time, std::size_t count, std::span<const float> values);
  [[nodiscard]] bool empty() const { return sections_ == 0; }
  /// The chunk, which ends at `end` s. The writer begins anew.
  std::string take(double end);

 private:
  void begin(std::uint16_t kind, std::size_t stream, std::size_t count);
  void add_values(std::span<const float> values);

  std::string bytes_;
  std::uint32_t sections_ = 0;
};

/// A section of a chunk: rows with a time each, or a set with one.
struct ChunkSection {
  bool is_set = false;
  std::size_t stream = 0;
  std::vector<double> times;  ///< s
  std::vector<float> values;
};

/// Calls `take` with each section of a chunk that a ChunkWriter made. `columns`: of each stream.
void for_each_section(std::string_view chunk, std::span<const std::size_t> columns,
                      const std::function<void(const ChunkSection& section)>& take);

/// The time at the end of a chunk, s.
double chunk_end(std::string_view chunk);

/// Calls `take` with each chunk of a frame.
void for_each_chunk(std::string_view frame, const std::function<void(std::string_view chunk)>& take);

/// What precedes `chunks` chunks in frame `number`.
std::string frame_header(std::size_t chunks, std::uint64_t number);

/// A mesh: positions in m, x y z by vertex, and indices, three by triangle.
std::string mesh_message(std::size_t index, std::span<const float> positions, std::span<const std::uint32_t> indices);

}  // namespace tactor
