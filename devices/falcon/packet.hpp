// The packets of the Falcon's firmware in run mode: 16 characters each way.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

namespace tactor {

inline constexpr std::size_t falcon_packet_size = 16;
using FalconPacket = std::array<std::uint8_t, falcon_packet_size>;

/// What the firmware tells: `<`, three counts of 16 bits as four nibbles each, the lowest first, a byte of the grip and
/// the homing, one without a known meaning, `>`. Every nibble and byte has 0x41 added.
struct FalconState {
  std::array<std::int16_t, 3> counts{};
  std::uint8_t grip = 0;   ///< bits of the four buttons
  std::uint8_t homed = 0;  ///< bits 0 to 2: the encoder of that motor has found its zero
  [[nodiscard]] bool all_homed() const { return (homed & 7U) == 7U; }
  bool operator==(const FalconState&) const = default;
};

/// What the firmware is told, in the same form.
struct FalconOrder {
  static constexpr std::uint8_t green = 2, blue = 4, red = 8;
  std::array<std::int16_t, 3> motors{};
  std::uint8_t lights = 0;
  bool home = false;  ///< encoders take their zero where the arms pass their marks
  bool operator==(const FalconOrder&) const = default;
};

FalconPacket encode(const FalconOrder& order);
FalconPacket encode(const FalconState& state);
/// Empty if the packet is invalid.
std::optional<FalconState> decode_state(std::span<const std::uint8_t> packet);
std::optional<FalconOrder> decode_order(std::span<const std::uint8_t> packet);

/// Finds packets in a stream of bytes that may begin and end anywhere.
class FalconStream {
 public:
  /// Takes a byte in; true where it ends a packet, which `packet` then holds.
  bool take(std::uint8_t byte);
  [[nodiscard]] const FalconPacket& packet() const { return packet_; }
  /// Bytes that belonged to no packet, so far.
  [[nodiscard]] std::uint64_t stray() const { return stray_; }
  void clear() { size_ = 0; }

 private:
  FalconPacket packet_{};
  std::size_t size_ = 0;
  std::uint64_t stray_ = 0;
};

}  // namespace tactor
