#include "app/view/samples.hpp"

#include <bit>
#include <type_traits>

namespace tactor {

namespace {

// Written as they lie in memory.
static_assert(std::endian::native == std::endian::little);

constexpr std::size_t chunk_header = 16;

template <class T>
void put(std::string& bytes, T value) {
  static_assert(std::is_trivially_copyable_v<T>);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <class T>
void put_all(std::string& bytes, std::span<const T> values) {
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
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
  bytes_.append((8 - bytes_.size() % 8) % 8, '\0');
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
