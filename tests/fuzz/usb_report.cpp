// Reports of USB devices: bytes read by the layout of the shipped profile, and the stream of packets of a Falcon. What
// is read is finite but for a float that is not, a packet that is decoded is encoded as the same, and no byte is lost.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "devices/falcon/packet.hpp"
#include "devices/usb/profile.hpp"
#include "require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactor;
  using fuzz::require;
  static const UsbProfile profile = read_usb_profile(TACTOR_SOURCE_DIR "/devices/usb/profiles/polhem.yaml");
  const std::span<const std::uint8_t> bytes(data, size);
  const std::size_t length = profile.input.size;
  for (std::size_t at = 0; at + length <= size; at += length) {
    const std::span<const std::uint8_t> report = bytes.subspan(at, length);
    for (const ReportField& field : profile.input.fields) {
      const double value = field.read(report);
      if (!field.is_whole()) continue;
      require(value >= field.least() && value <= field.most(), "a number is one of its type");
      std::vector<std::uint8_t> back(length);
      field.write(back, value);
      require(field.read(back) == value, "it is written as it was read");
      const double away = count_from(0, value, field.span());
      require(std::abs(away) <= field.span(), "a counter is less than a turn away");
    }
    for (const auto* flags : {&profile.input.buttons, &profile.input.faults}) {
      for (const Flag& flag : *flags) static_cast<void>(flag.is_set(profile.input.fields, report));
    }
  }
  // Any type, byte order and place.
  if (size >= 3) {
    ReportField field;
    field.type = static_cast<FieldType>(data[0] % 7);
    field.order = static_cast<ByteOrder>(data[0] / 7 % 2);
    field.at = data[1];
    if (field.at + field.size() <= size) static_cast<void>(field.read(bytes));
  }
  FalconStream stream;
  std::uint64_t packets = 0;
  for (const std::uint8_t byte : bytes) {
    if (!stream.take(byte)) continue;
    ++packets;
    if (const auto state = decode_state(stream.packet())) {
      const auto again = decode_state(encode(*state));
      require(again.has_value() && *again == *state, "a state is encoded as it was decoded");
    }
    if (const auto order = decode_order(stream.packet())) {
      const auto again = decode_order(encode(*order));
      require(again.has_value() && *again == *order, "an order is encoded as it was decoded");
    }
  }
  require(stream.stray() + packets * stream.packet().size() <= size, "no byte is counted twice");
  return 0;
}
