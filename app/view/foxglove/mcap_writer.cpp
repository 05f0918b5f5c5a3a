#include "app/view/foxglove/mcap_writer.hpp"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <bit>
#include <ostream>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

// Numbers are written as they lie in memory.
static_assert(std::endian::native == std::endian::little);

constexpr std::string_view magic{"\x89MCAP0\r\n", 8};
constexpr std::size_t chunk_bytes = std::size_t{1} << 20U;  // before compression
constexpr std::size_t head_bytes = 9;                       // of a record: its kind and its length
constexpr int zstd_level = 3;

enum RecordKind : std::uint8_t {
  header_record = 0x01,
  footer_record = 0x02,
  schema_record = 0x03,
  channel_record = 0x04,
  message_record = 0x05,
  chunk_record = 0x06,
  message_index_record = 0x07,
  chunk_index_record = 0x08,
  statistics_record = 0x0B,
  metadata_record = 0x0C,
  metadata_index_record = 0x0D,
  summary_offset_record = 0x0E,
  data_end_record = 0x0F,
};

template <class T>
void put_number(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void put_text(std::string& bytes, std::string_view text) {
  put_number(bytes, static_cast<std::uint32_t>(text.size()));
  bytes += text;
}

void put_texts(std::string& bytes, const std::map<std::string, std::string>& texts) {
  std::string list;
  for (const auto& [name, value] : texts) {
    put_text(list, name);
    put_text(list, value);
  }
  put_text(bytes, list);
}

void put_head(std::string& bytes, RecordKind kind, std::size_t content) {
  put_number(bytes, static_cast<std::uint8_t>(kind));
  put_number(bytes, static_cast<std::uint64_t>(content));
}

std::uint32_t crc_of(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(crc32(0, nullptr, 0), reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::string compressed(const std::string& bytes) {
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size = ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), zstd_level);
  TACTOR_DEMAND(ZSTD_isError(size) == 0);
  packed.resize(size);
  return packed;
}

}  // namespace

McapWriter::McapWriter(std::ostream& out) : out_(out) {
  write(magic);
  std::string content;
  put_text(content, "");  // of no profile
  put_text(content, "tactor");
  write_record(header_record, content);
}

void McapWriter::write(std::string_view bytes) {
  out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  offset_ += bytes.size();
}

void McapWriter::write_record(std::uint8_t kind, std::string_view content) {
  std::string head;
  put_head(head, static_cast<RecordKind>(kind), content.size());
  write(head);
  write(content);
}

void McapWriter::add_metadata(const std::string& name, const std::map<std::string, std::string>& values) {
  finish_chunk();
  std::string content;
  put_text(content, name);
  put_texts(content, values);
  metadata_.push_back({name, offset_, head_bytes + content.size()});
  write_record(metadata_record, content);
}

McapWriter::ChannelId McapWriter::add_channel(const std::string& topic, const std::string& schema_name,
                                              const std::string& schema) {
  TACTOR_DEMAND(records_.empty());
  // 0 stands for no schema.
  const auto [known, is_new] = schema_ids_.emplace(schema_name, static_cast<std::uint16_t>(schema_ids_.size() + 1));
  if (is_new) {
    std::string content;
    put_number(content, known->second);
    put_text(content, schema_name);
    put_text(content, "jsonschema");
    put_text(content, schema);
    write_record(schema_record, content);
    schemas_.push_back(std::move(content));
  }
  const auto id = static_cast<ChannelId>(channels_.size());
  std::string content;
  put_number(content, id);
  put_number(content, known->second);
  put_text(content, topic);
  put_text(content, "json");
  put_texts(content, {});
  write_record(channel_record, content);
  channels_.push_back(std::move(content));
  counts_.push_back(0);
  return id;
}

void McapWriter::add_message(ChannelId channel, std::int64_t time_ns, std::string_view message) {
  const auto time = static_cast<std::uint64_t>(std::max<std::int64_t>(time_ns, 0));
  start_ = records_.empty() ? time : std::min(start_, time);
  end_ = records_.empty() ? time : std::max(end_, time);
  std::string& index = indices_[channel];
  put_number(index, time);
  put_number(index, static_cast<std::uint64_t>(records_.size()));
  put_head(records_, message_record, 22 + message.size());
  put_number(records_, channel);
  put_number(records_, static_cast<std::uint32_t>(counts_[channel]++));
  put_number(records_, time);  // when it was logged, and when it was published
  put_number(records_, time);
  records_ += message;
  if (records_.size() >= chunk_bytes) finish_chunk();
}

void McapWriter::finish_chunk() {
  if (records_.empty()) return;
  Chunk chunk;
  chunk.start = start_;
  chunk.end = end_;
  chunk.offset = offset_;
  chunk.uncompressed = records_.size();
  const std::string packed = compressed(records_);
  chunk.compressed = packed.size();
  std::string content;
  put_number(content, start_);
  put_number(content, end_);
  put_number(content, chunk.uncompressed);
  put_number(content, crc_of(records_));
  put_text(content, "zstd");
  put_number(content, chunk.compressed);
  content += packed;
  write_record(chunk_record, content);
  chunk.bytes = offset_ - chunk.offset;
  for (const auto& [channel, index] : indices_) {
    chunk.index_offsets[channel] = offset_;
    content.clear();
    put_number(content, channel);
    put_text(content, index);
    write_record(message_index_record, content);
  }
  chunk.index_bytes = offset_ - chunk.offset - chunk.bytes;
  chunks_.push_back(std::move(chunk));
  records_.clear();
  indices_.clear();
}

void McapWriter::finish() {
  finish_chunk();
  std::string content;
  put_number(content, std::uint32_t{0});  // 0: the checksum of all data is not known
  write_record(data_end_record, content);
  write_summary();
  write(magic);
}

void McapWriter::write_summary() {
  const std::uint64_t start = offset_;
  std::string summary, offsets;
  auto end_group = [&, from = std::size_t{0}](RecordKind kind) mutable {
    if (summary.size() > from) {
      put_head(offsets, summary_offset_record, 17);
      put_number(offsets, static_cast<std::uint8_t>(kind));
      put_number(offsets, start + from);
      put_number(offsets, static_cast<std::uint64_t>(summary.size() - from));
    }
    from = summary.size();
  };
  const auto add = [&summary](RecordKind kind, const std::string& content) {
    put_head(summary, kind, content.size());
    summary += content;
  };
  for (const std::string& schema : schemas_) add(schema_record, schema);
  end_group(schema_record);
  for (const std::string& channel : channels_) add(channel_record, channel);
  end_group(channel_record);

  std::string content;
  std::uint64_t messages = 0, first = 0, last = 0;
  for (const std::uint64_t count : counts_) messages += count;
  for (std::size_t i = 0; i < chunks_.size(); ++i) {
    first = i == 0 ? chunks_[i].start : std::min(first, chunks_[i].start);
    last = std::max(last, chunks_[i].end);
  }
  put_number(content, messages);
  put_number(content, static_cast<std::uint16_t>(schemas_.size()));
  put_number(content, static_cast<std::uint32_t>(channels_.size()));
  put_number(content, std::uint32_t{0});  // attachments
  put_number(content, static_cast<std::uint32_t>(metadata_.size()));
  put_number(content, static_cast<std::uint32_t>(chunks_.size()));
  put_number(content, first);
  put_number(content, last);
  put_number(content, static_cast<std::uint32_t>(10 * counts_.size()));
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    put_number(content, static_cast<ChannelId>(i));
    put_number(content, counts_[i]);
  }
  add(statistics_record, content);
  end_group(statistics_record);

  for (const Chunk& chunk : chunks_) {
    content.clear();
    put_number(content, chunk.start);
    put_number(content, chunk.end);
    put_number(content, chunk.offset);
    put_number(content, chunk.bytes);
    put_number(content, static_cast<std::uint32_t>(10 * chunk.index_offsets.size()));
    for (const auto& [channel, offset] : chunk.index_offsets) {
      put_number(content, channel);
      put_number(content, offset);
    }
    put_number(content, chunk.index_bytes);
    put_text(content, "zstd");
    put_number(content, chunk.compressed);
    put_number(content, chunk.uncompressed);
    add(chunk_index_record, content);
  }
  end_group(chunk_index_record);
  for (const Metadata& metadata : metadata_) {
    content.clear();
    put_number(content, metadata.offset);
    put_number(content, metadata.bytes);
    put_text(content, metadata.name);
    add(metadata_index_record, content);
  }
  end_group(metadata_index_record);

  // The checksum covers the footer as far as itself.
  std::string tail = summary + offsets;
  put_head(tail, footer_record, 20);
  put_number(tail, start);
  put_number(tail, start + summary.size());
  put_number(tail, crc_of(tail));
  write(tail);
}

}  // namespace tactor
