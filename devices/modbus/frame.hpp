// Requests and answers of Modbus as bytes: what goes over the line, and whether what comes back answers it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "devices/hardware/link.hpp"
#include "devices/modbus/cycle_plan.hpp"

namespace tactor::modbus {

/// The longest frame, of a serial line and of TCP.
inline constexpr std::size_t longest_frame = 260;

/// What a frame has around its function and data: the unit and a check sum on a serial line, the MBAP header over TCP.
struct Framing {
  bool serial = false;
  int unit = 1;
  int transaction = 0;  ///< over TCP, 0 to 65535
};

/// The check sum of a serial line (CRC-16, polynomial 0xa001), its low byte goes first.
std::uint16_t check_sum(std::span<const std::uint8_t> bytes);

/// Makes `frame` the whole frame of a request, without allocating where it has room for the longest one. `written`
/// holds write_count words where the function writes.
void put_request(const Transaction& request, const std::uint16_t* written, const Framing& framing,
                 std::vector<std::uint8_t>& frame);

/// What has come so far of an answer.
struct AnswerState {
  enum class Kind : std::uint8_t { incomplete, good, wrong };
  Kind kind = Kind::incomplete;
  std::size_t missing = 0;            ///< of an incomplete one: bytes to read next, never more than the frame has
  LinkError error = LinkError::none;  ///< of a wrong one: crc, exception or protocol
  int exception = 0;                  ///< its number, of an exception
  std::string text;                   ///< of a wrong one: what was expected and what came
};

/// Judges the first bytes of an answer to `request`, which went out as `sent`. Every field is compared as soon as it is
/// there: over TCP the transaction number, the protocol id, the length that the header states, and the unit; on a
/// serial line the unit and the check sum; on both the function, the count of bytes, and what an answer to a write
/// repeats (address and count, with function 6 the word).
AnswerState judge_answer(std::span<const std::uint8_t> bytes, const Transaction& request,
                         std::span<const std::uint8_t> sent, const Framing& framing);

/// Copies the words that a good answer carries.
void take_words(std::span<const std::uint8_t> answer, const Transaction& request, const Framing& framing,
                std::uint16_t* words);

}  // namespace tactor::modbus
