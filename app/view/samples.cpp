#include "app/view/samples.hpp"

#include <bit>
#include <cstring>
#include <type_traits>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

// Written as they lie in memory.
static_assert(std::endian::native == std::endian::little);

constexpr std::size_t chunk_header = 16, frame_header_bytes = 16;

template <class T>
void put(std::string& bytes, T value) {
  static_assert(std::is_trivially_copyable_v<T>);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <class T>
void put_all(std::string& bytes, std::span<const T> values) {
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
}

template <class T>
T get(std::string_view bytes, std::size_t at) {
  TACTOR_DEMAND(at + sizeof(T) <= bytes.size());
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

template <class T>
void get_all(std::string_view bytes, std::size_t& at, std::vector<T>& values, std::size_t count) {
  TACTOR_DEMAND(count <= (bytes.size() - at) / sizeof(T));
  values.resize(count);
  if (count > 0) std::memcpy(values.data(), bytes.data() + at, count * sizeof(T));
  at += count * sizeof(T);
}

constexpr std::size_t aligned(std::size_t bytes) {
  return (bytes + 7) / 8 * 8;
}

}  // namespace

ChunkWriter::ChunkWriter() : bytes_(chunk_header, '\0') {}

void ChunkWriter::begin(std::uint16_t kind, std::size_t stream, std::size_t count) {
  put(bytes_, kind);
  put(bytes_, static_cast<std::uint16_t>(stream));
  put(bytes_, static_cast<std::uint32_t>(count));
  ++sections_;
}

void ChunkWriter::add_values(std::span<const float> values) {
  put_all(bytes_, values);
  bytes_.resize(aligned(bytes_.size()), '\0');
}

void ChunkWriter::add_rows(std::size_t stream, std::span<const double> times, std::span<const float> values) {
  begin(0, stream, times.size());
  put_all(bytes_, times);
  add_values(values);
}

void ChunkWriter::add_set(std::size_t stream, double time, std::size_t count, std::span<const float> values) {
  begin(1, stream, count);
  put(bytes_, time);
  add_values(values);
}

std::string ChunkWriter::take(double end) {
  std::string header;
  put(header, static_cast<std::uint32_t>(bytes_.size()));
  put(header, sections_);
  put(header, end);
  std::string chunk(chunk_header, '\0');
  chunk.swap(bytes_);
  chunk.replace(0, chunk_header, header);
  sections_ = 0;
  return chunk;
}

void for_each_section(std::string_view chunk, std::span<const std::size_t> columns,
                      const std::function<void(const ChunkSection& section)>& take) {
  ChunkSection section;
  std::size_t at = chunk_header;
  for (std::uint32_t left = get<std::uint32_t>(chunk, 4); left > 0; --left) {
    section.is_set = get<std::uint16_t>(chunk, at) == 1;
    section.stream = get<std::uint16_t>(chunk, at + 2);
    const std::size_t rows = get<std::uint32_t>(chunk, at + 4);
    TACTOR_DEMAND(section.stream < columns.size());
    at += 8;
    get_all(chunk, at, section.times, section.is_set ? 1 : rows);
    get_all(chunk, at, section.values, rows * columns[section.stream]);
    at = aligned(at);
    take(section);
  }
}

double chunk_end(std::string_view chunk) {
  return get<double>(chunk, 8);
}

void for_each_chunk(std::string_view frame, const std::function<void(std::string_view chunk)>& take) {
  std::size_t at = frame_header_bytes;
  for (std::uint32_t left = get<std::uint32_t>(frame, 4); left > 0; --left) {
    const std::size_t bytes = get<std::uint32_t>(frame, at);
    TACTOR_DEMAND(bytes >= chunk_header && bytes <= frame.size() - at);
    take(frame.substr(at, bytes));
    at += bytes;
  }
}

std::string frame_header(std::size_t chunks, std::uint64_t number) {
  std::string bytes;
  put(bytes, std::uint32_t{1});
  put(bytes, static_cast<std::uint32_t>(chunks));
  put(bytes, number);
  return bytes;
}

std::string mesh_message(std::size_t index, std::span<const float> positions, std::span<const std::uint32_t> indices) {
  std::string bytes;
  put(bytes, std::uint32_t{2});
  put(bytes, static_cast<std::uint32_t>(index));
  put(bytes, static_cast<std::uint32_t>(positions.size() / 3));
  put(bytes, static_cast<std::uint32_t>(indices.size() / 3));
  put_all(bytes, positions);
  put_all(bytes, indices);
  return bytes;
}

}  // namespace tactor
