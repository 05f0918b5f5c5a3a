// What the Falcon's serial chip (FTDI) and its loader are asked, as libnifalcon (BSD licence) publishes it.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace tactor::falcon {

inline constexpr std::uint16_t vendor = 0x0403, product = 0xcb48;
inline constexpr std::uint8_t in_endpoint = 0x81, out_endpoint = 0x02;

/// Requests of the chip; bmRequestType is `to_chip`, wIndex 0.
inline constexpr std::uint8_t to_chip = 0x40;
inline constexpr std::uint8_t reset = 0, modem = 1, flow = 2, baud = 3, data_bits = 4, latency = 9;
inline constexpr std::uint16_t purge_in = 1, purge_out = 2;  // of reset
inline constexpr std::uint16_t rts_low = 0x200, dtr_low = 0x100, dtr_high = 0x101;
inline constexpr std::uint16_t eight_bits = 8;
/// Divisors: 9600 baud asks the loader, 140 kbaud takes the firmware, 1.5 Mbaud runs it.
inline constexpr std::uint16_t baud_ask = 0x4138, baud_load = 0x15, baud_run = 0x02;

/// Status bytes of the chip before the data of each packet to the host.
inline constexpr std::size_t status_bytes = 2;
/// The data that a packet holds beside them, and so what a block of firmware may be long.
inline constexpr std::size_t block = 62;

inline constexpr std::array<std::uint8_t, 3> hello{0x0a, 0x43, 0x0d};
inline constexpr std::array<std::uint8_t, 4> answer{0x0a, 0x44, 0x2c, 0x0d};
inline constexpr std::uint8_t load = 0x41;  // and its own answer

/// Encoders: theta = 35 deg + 0.03643 deg a count (320 slots, four edges each, 14.25 mm shaft on a 110 mm arm).
inline constexpr double degree = std::numbers::pi / 180;
inline constexpr double theta_zero = 35 * degree, theta_step = 0.03643 * degree;
/// A motor's word is -1e4 a N m.
inline constexpr double words_per_Nm = -1e4;
inline constexpr double word_max = 4096;  ///< what the published drivers send at most: 0.41 N m

/// Fewer bytes are no firmware; the published images have some tens of thousands.
inline constexpr std::size_t least_firmware = 1024, most_firmware = 1024 * 1024;

}  // namespace tactor::falcon
