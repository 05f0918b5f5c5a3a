#include "devices/falcon/packet.hpp"

namespace tactor {

namespace {

constexpr std::uint8_t first = '<', last = '>', letter = 0x41;

void put(FalconPacket& packet, std::size_t number, std::int16_t value) {
  const auto bits = static_cast<std::uint16_t>(value);
  for (std::size_t nibble = 0; nibble < 4; ++nibble) {
    packet[1 + 4 * number + nibble] = static_cast<std::uint8_t>(letter + ((bits >> (4 * nibble)) & 0xfU));
  }
}

/// The number, or nothing where a character is no nibble.
std::optional<std::int16_t> get(std::span<const std::uint8_t> packet, std::size_t number) {
  std::uint32_t bits = 0;
  for (std::size_t nibble = 0; nibble < 4; ++nibble) {
    const std::uint8_t character = packet[1 + 4 * number + nibble];
    if (character < letter || character > letter + 15) return std::nullopt;
    bits |= static_cast<std::uint32_t>(character - letter) << (4 * nibble);
  }
  return static_cast<std::int16_t>(bits);
}

bool is_framed(std::span<const std::uint8_t> packet) {
  return packet.size() == falcon_packet_size && packet.front() == first && packet.back() == last;
}

template <class Numbers>
bool get_all(std::span<const std::uint8_t> packet, Numbers& numbers) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto number = get(packet, i);
    if (!number) return false;
    numbers[i] = *number;
  }
  return true;
}

FalconPacket framed(std::uint8_t thirteenth) {
  FalconPacket packet{};
  packet[0] = first;
  packet[13] = static_cast<std::uint8_t>(thirteenth + letter);
  packet[14] = letter;
  packet[15] = last;
  return packet;
}

}  // namespace

FalconPacket encode(const FalconOrder& order) {
  FalconPacket packet = framed(static_cast<std::uint8_t>((order.lights & 0xeU) | (order.home ? 1U : 0U)));
  for (std::size_t i = 0; i < 3; ++i) put(packet, i, order.motors[i]);
  return packet;
}

FalconPacket encode(const FalconState& state) {
  FalconPacket packet = framed(static_cast<std::uint8_t>((state.grip & 0xfU) | ((state.homed & 7U) << 4U)));
  for (std::size_t i = 0; i < 3; ++i) put(packet, i, state.counts[i]);
  return packet;
}

std::optional<FalconState> decode_state(std::span<const std::uint8_t> packet) {
  FalconState state;
  if (!is_framed(packet) || !get_all(packet, state.counts)) return std::nullopt;
  const auto bits = static_cast<std::uint8_t>(packet[13] - letter);
  if ((bits & 0x80U) != 0) return std::nullopt;
  state.grip = bits & 0xfU;
  state.homed = (bits >> 4U) & 7U;
  return state;
}

std::optional<FalconOrder> decode_order(std::span<const std::uint8_t> packet) {
  FalconOrder order;
  if (!is_framed(packet) || !get_all(packet, order.motors)) return std::nullopt;
  const auto bits = static_cast<std::uint8_t>(packet[13] - letter);
  if (bits > 0xfU) return std::nullopt;
  order.lights = bits & 0xeU;
  order.home = (bits & 1U) != 0;
  return order;
}

bool FalconStream::take(std::uint8_t byte) {
  if (size_ == 0 && byte != first) {
    ++stray_;
    return false;
  }
  // A packet that has lost bytes ends early; its end, or the next one's beginning, tells.
  if (size_ > 0 && (byte == first || (byte == last && size_ + 1 < falcon_packet_size))) {
    stray_ += size_;
    size_ = 0;
    if (byte == last) {
      ++stray_;
      return false;
    }
  }
  packet_[size_++] = byte;
  if (size_ < falcon_packet_size) return false;
  size_ = 0;
  if (byte == last) return true;
  stray_ += falcon_packet_size;
  return false;
}

}  // namespace tactor
