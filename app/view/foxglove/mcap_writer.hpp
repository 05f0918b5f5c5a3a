// Writes MCAP, the file of Foxglove and its kin: messages by channel in compressed chunks, with an index at the end.
// https://mcap.dev/spec
#pragma once

#include <cstdint>
#include <iosfwd>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace tactor {

/// One file, from its beginning to its end. A write that fails is seen at the stream.
class McapWriter {
 public:
  using ChannelId = std::uint16_t;

  explicit McapWriter(std::ostream& out);
  void add_metadata(const std::string& name, const std::map<std::string, std::string>& values);
  /// A channel of JSON messages, before the first message. Channels with one schema name share the schema.
  ChannelId add_channel(const std::string& topic, const std::string& schema_name, const std::string& schema);
  void add_message(ChannelId channel, std::int64_t time_ns, std::string_view message);
  /// Writes what waits and the index.
  void finish();

 private:
  struct Chunk {
    std::uint64_t start = 0, end = 0, offset = 0, bytes = 0, index_bytes = 0, compressed = 0, uncompressed = 0;
    std::map<ChannelId, std::uint64_t> index_offsets;
  };
  struct Metadata {
    std::string name;
    std::uint64_t offset = 0, bytes = 0;
  };
  void write(std::string_view bytes);
  void write_record(std::uint8_t kind, std::string_view content);
  void finish_chunk();
  void write_summary();

  std::ostream& out_;
  std::uint64_t offset_ = 0;
  std::map<std::string, std::uint16_t> schema_ids_;
  std::vector<std::string> schemas_, channels_;  // records, without their heads
  std::vector<std::uint64_t> counts_;            // messages, by channel
  std::vector<Chunk> chunks_;
  std::vector<Metadata> metadata_;
  std::string records_;  // of the chunk that is open
  std::uint64_t start_ = 0, end_ = 0;
  std::map<ChannelId, std::string> indices_;
};

}  // namespace tactor
