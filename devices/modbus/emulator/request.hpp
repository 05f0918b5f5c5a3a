// Requests as an emulated device reads them from its line, and its answers as bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "devices/modbus/cycle_plan.hpp"
#include "devices/modbus/emulator/device.hpp"

namespace tactor::modbus {

/// A request that has come whole.
struct Request {
  int unit = 0;
  int transaction = 0;  ///< over TCP
  int function = 0;
  Transaction what;                    ///< of a good one
  std::vector<std::uint16_t> written;  ///< write_count words
  int exception = 0;                   ///< 1: a function that the device lacks; 3: counts that do not fit each other
};

/// What the first bytes of a line are. `length` bytes of them are then done with, except where more must come.
struct TakenRequest {
  enum class Kind : std::uint8_t { incomplete, whole, ignored, broken };
  Kind kind = Kind::incomplete;  ///< ignored: not Modbus; broken: nothing behind it can be read either
  std::size_t length = 0;
  Request request;
};
TakenRequest take_request(std::span<const std::uint8_t> bytes, bool serial);

/// Reads and writes the device's words; an exception where the device has not all of them.
std::vector<std::uint8_t> answer_request(const Request& request, bool serial, EmulatedDevice& device);

/// The answer that refuses a request.
std::vector<std::uint8_t> exception_frame(const Request& request, bool serial, int exception);

}  // namespace tactor::modbus
