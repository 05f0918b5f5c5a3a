// What a view tells its pages, as channels and messages that Foxglove, Lichtblick and PlotJuggler read.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tactor {

struct ChunkSection;

/// Messages of one kind. All are JSON, and their schemas are JSON Schema.
struct FoxgloveChannel {
  std::string topic;  ///< `/device/commanded`
  std::string schema_name;
  std::string schema;
};

struct FoxgloveMessage {
  std::size_t channel = 0;   ///< index into the channels
  std::int64_t time_ns = 0;  ///< of the run
  std::string json;
};

/// Translates hello, meshes and chunks (docs/reference/view_protocol.md). The frame `world` is W. Throws nothing for
/// what ViewSource gives.
class FoxgloveMessages {
 public:
  FoxgloveMessages(const std::string& hello, std::span<const std::string> meshes);

  [[nodiscard]] const std::vector<FoxgloveChannel>& channels() const { return channels_; }
  /// The channels whose messages a late viewer needs too: the bodies, and their first poses.
  [[nodiscard]] const std::vector<FoxgloveMessage>& first() const { return first_; }
  /// Adds what a chunk holds of the channels that are wanted.
  void add(std::string_view chunk, const std::vector<bool>& wanted, std::vector<FoxgloveMessage>& messages);
  /// Graph, title and version, by name.
  [[nodiscard]] const std::map<std::string, std::string>& about() const { return about_; }
  /// The tunable parameters: their values as JSON, by name.
  [[nodiscard]] const std::map<std::string, std::string>& parameters() const { return parameters_; }

 private:
  enum class Kind : std::uint8_t { rows, contacts, patch, left_out };
  struct Stream {
    Kind kind = Kind::rows;
    std::size_t channel = 0;
    std::size_t columns = 0;
    bool is_handle = false;
    bool is_commanded = false;
    std::vector<std::string> pieces;  ///< of rows: the text before each value, and after the last
  };
  std::size_t channel(const std::string& topic, const std::string& schema_name, const std::string& schema);
  void add_rows(const Stream& stream, const ChunkSection& section, const std::vector<bool>& wanted,
                std::vector<FoxgloveMessage>& messages);
  void add_force(double time, const float* force, std::vector<FoxgloveMessage>& messages);

  std::vector<FoxgloveChannel> channels_;
  std::vector<FoxgloveMessage> first_;
  std::map<std::string, std::string> about_, parameters_;
  std::vector<Stream> streams_;
  std::vector<std::size_t> columns_;  // by stream
  std::size_t force_channel_ = 0;
  double size_ = 0.1;  // of the scene's bodies, m
  std::size_t most_handles_ = SIZE_MAX;
  std::map<std::int64_t, std::array<float, 3>> handle_;  // p_WD by time, m and ns
  double next_force_ = 0;                                // s
};

}  // namespace tactor
