#include "devices/usb/emulator/usb_function.hpp"

#include <algorithm>
#include <cstring>

namespace tactor {

namespace {

constexpr std::uint8_t get_status = 0, set_address = 5, get_descriptor = 6, get_configuration = 8,
                       set_configuration = 9, set_interface = 11;
constexpr std::uint8_t kind_device = 1, kind_configuration = 2, kind_string = 3;
constexpr std::size_t device_descriptor_size = 18;

std::size_t answer(std::span<std::uint8_t> room, std::span<const std::uint8_t> bytes) {
  const std::size_t n = std::min(room.size(), bytes.size());
  std::copy_n(bytes.begin(), n, room.begin());
  return n;
}

std::vector<std::uint8_t> string_descriptor(const char* text) {
  std::vector<std::uint8_t> bytes{0, kind_string};
  for (; *text != '\0' && bytes.size() < 254; ++text) {
    bytes.push_back(static_cast<std::uint8_t>(*text));
    bytes.push_back(0);  // UTF-16, little end first
  }
  bytes[0] = static_cast<std::uint8_t>(bytes.size());
  return bytes;
}

}  // namespace

std::optional<std::size_t> answer_standard_request(const UsbSetup& setup, std::span<std::uint8_t> data,
                                                   std::span<const std::uint8_t> descriptors,
                                                   std::span<const char* const> texts) {
  if ((setup.type & 0x60U) != 0) return std::nullopt;  // of a class or a maker
  switch (setup.request) {
    case set_address:
    case set_configuration:
    case set_interface:
      return 0;
    case get_configuration: {
      const std::uint8_t first[1] = {1};
      return answer(data, first);
    }
    case get_status: {
      const std::uint8_t none[2] = {0, 0};
      return answer(data, none);
    }
    case get_descriptor:
      break;
    default:
      return std::nullopt;
  }
  const auto kind = static_cast<std::uint8_t>(setup.value >> 8U);
  const std::size_t index = setup.value & 0xffU;
  if (kind == kind_device) return answer(data, descriptors.first(device_descriptor_size));
  if (kind == kind_configuration) return answer(data, descriptors.subspan(device_descriptor_size));
  if (kind != kind_string || index > texts.size()) return std::nullopt;
  const std::uint8_t languages[4] = {4, kind_string, 0x09, 0x04};  // English alone
  if (index == 0) return answer(data, languages);
  return answer(data, string_descriptor(texts[index - 1]));
}

std::vector<std::uint8_t> make_descriptors(std::uint16_t vendor, std::uint16_t product, std::uint8_t interface_class,
                                           std::span<const EndpointDescription> endpoints) {
  const auto low = [](std::uint16_t v) { return static_cast<std::uint8_t>(v & 0xffU); };
  const auto high = [](std::uint16_t v) { return static_cast<std::uint8_t>(v >> 8U); };
  const auto whole = static_cast<std::uint16_t>(9 + 9 + 7 * endpoints.size());
  std::vector<std::uint8_t> bytes{18, kind_device, 0x00, 0x02, 0, 0, 0, 64, low(vendor), high(vendor), low(product),
                                  high(product), 0x00, 0x01, 1, 2, 3, 1,
                                  // the configuration: powered by the bus, 500 mA
                                  9, kind_configuration, low(whole), high(whole), 1, 1, 0, 0x80, 250,
                                  // its interface
                                  9, 4, 0, 0, static_cast<std::uint8_t>(endpoints.size()), interface_class, 0, 0, 0};
  for (const EndpointDescription& e : endpoints) {
    bytes.insert(bytes.end(), {7, 5, e.address, e.attributes, low(e.packet), high(e.packet), e.interval});
  }
  return bytes;
}

}  // namespace tactor
