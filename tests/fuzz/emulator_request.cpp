// What an emulated device is sent: Modbus requests over TCP and on a serial line, and usbip. Nothing is read beyond
// what has come, a request is answered with a frame of Modbus, and a refused one changes nothing.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "devices/modbus/emulator/request.hpp"
#include "devices/modbus/frame.hpp"
#include "devices/usb/emulator/emulated_device.hpp"
#include "devices/usb/emulator/known_devices.hpp"
#include "devices/usb/emulator/usbip.hpp"
#include "require.hpp"

namespace {

using namespace tactor;
using fuzz::require;

void modbus_line(std::span<const std::uint8_t> bytes, bool serial) {
  using namespace tactor::modbus;
  static modbus::EmulatedDevice device(read_profile(TACTOR_SOURCE_DIR "/devices/modbus/profiles/iris_orca.yaml"));
  while (!bytes.empty()) {
    // A copy of its own size, so that a read beyond it is seen.
    const std::vector<std::uint8_t> exact(bytes.begin(), bytes.end());
    const TakenRequest taken = take_request(exact, serial);
    if (taken.kind == TakenRequest::Kind::incomplete || taken.kind == TakenRequest::Kind::broken) return;
    require(taken.length > 0 && taken.length <= bytes.size(), "a request is among what has come");
    bytes = bytes.subspan(taken.length);
    const Request& r = taken.request;
    require(r.exception != 0 || r.written.size() == static_cast<std::size_t>(r.what.write_count),
            "all words are there");
    const std::uint64_t before = device.state().commands;
    const std::vector<std::uint8_t> answer = answer_request(r, serial, device);
    require(answer.size() <= longest_frame && answer.size() >= 5, "an answer is a frame");
    const bool refused = (answer[serial ? 1 : 7] & 0x80U) != 0;
    require(!refused || device.state().commands == before, "a refused request changes nothing");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  const std::span<const std::uint8_t> bytes(data + 1, size - 1);
  if (data[0] % 3 < 2) {
    modbus_line(bytes, data[0] % 3 == 1);
    return 0;
  }
  static const auto device = make_emulated_device(falcon_emulation(), map_state(""));
  UsbipServer server(*device);
  for (std::size_t at = 0; at < bytes.size(); at += 61) {
    const std::span<const std::uint8_t> piece = bytes.subspan(at, std::min<std::size_t>(61, bytes.size() - at));
    if (!server.receive(piece).empty()) break;
    server.frame();
    static_cast<void>(server.take());
  }
  return 0;
}
