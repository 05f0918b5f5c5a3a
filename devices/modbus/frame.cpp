#include "devices/modbus/frame.hpp"

#include <algorithm>
#include <cstdio>

#include "framework/core/check.hpp"

namespace tactor::modbus {

namespace {

constexpr std::size_t mbap_length = 6;  // without the unit, which its length counts
constexpr int exception_flag = 0x80;

std::size_t head_of(const Framing& framing) {
  return framing.serial ? 1 : mbap_length + 1;
}
std::size_t tail_of(const Framing& framing) {
  return framing.serial ? 2 : 0;
}

void put_word(std::vector<std::uint8_t>& bytes, int word) {
  bytes.push_back(static_cast<std::uint8_t>(word >> 8 & 0xff));
  bytes.push_back(static_cast<std::uint8_t>(word & 0xff));
}

int word_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  return bytes[at] << 8 | bytes[at + 1];
}

/// Bytes of a good answer from its function on.
std::size_t body_length(const Transaction& t) {
  return t.function == 6 || t.function == 16 ? 5 : 2 + 2 * static_cast<std::size_t>(t.read_count);
}

AnswerState incomplete(std::size_t missing) {
  AnswerState state;
  state.missing = missing;
  return state;
}

AnswerState wrong(LinkError error, std::string text, int exception = 0) {
  AnswerState state;
  state.kind = AnswerState::Kind::wrong;
  state.error = error;
  state.exception = exception;
  state.text = std::move(text);
  return state;
}

AnswerState mismatch(const char* what, int expected, int found) {
  char text[120];
  std::snprintf(text, sizeof text, "expected an answer with %s %d, found %d", what, expected, found);
  return wrong(LinkError::protocol, text);
}

const char* name_of_exception(int number) {
  switch (number) {
    case 1:
      return "illegal function";
    case 2:
      return "illegal data address";
    case 3:
      return "illegal data value";
    case 4:
      return "device failure";
    case 5:
      return "acknowledge";
    case 6:
      return "device busy";
    case 8:
      return "memory parity error";
    case 10:
      return "gateway path unavailable";
    case 11:
      return "the device behind the gateway does not answer";
    default:
      return "not a number of the standard";
  }
}

/// Compares what an answer repeats of its request: bytes `from` to `to` of both bodies.
bool repeats(std::span<const std::uint8_t> body, std::span<const std::uint8_t> asked, std::size_t from,
             std::size_t to) {
  return std::equal(body.begin() + static_cast<std::ptrdiff_t>(from), body.begin() + static_cast<std::ptrdiff_t>(to),
                    asked.begin() + static_cast<std::ptrdiff_t>(from));
}

}  // namespace

std::uint16_t check_sum(std::span<const std::uint8_t> bytes) {
  std::uint16_t sum = 0xffff;
  for (const std::uint8_t byte : bytes) {
    sum = static_cast<std::uint16_t>(sum ^ byte);
    for (int bit = 0; bit < 8; ++bit) {
      sum = static_cast<std::uint16_t>((sum & 1U) != 0 ? (sum >> 1) ^ 0xa001U : sum >> 1);
    }
  }
  return sum;
}

void put_request(const Transaction& t, const std::uint16_t* written, const Framing& framing,
                 std::vector<std::uint8_t>& frame) {
  frame.clear();
  frame.reserve(longest_frame);
  if (!framing.serial) {
    put_word(frame, framing.transaction);
    put_word(frame, 0);
    put_word(frame, 0);  // the length, below
  }
  frame.push_back(static_cast<std::uint8_t>(framing.unit));
  frame.push_back(static_cast<std::uint8_t>(t.function));
  const auto put_written = [&] {
    frame.push_back(static_cast<std::uint8_t>(2 * t.write_count));
    for (int i = 0; i < t.write_count; ++i) put_word(frame, written[i]);
  };
  switch (t.function) {
    case 3:
    case 4:
      put_word(frame, t.read_address);
      put_word(frame, t.read_count);
      break;
    case 6:
      put_word(frame, t.write_address);
      put_word(frame, written[0]);
      break;
    case 16:
      put_word(frame, t.write_address);
      put_word(frame, t.write_count);
      put_written();
      break;
    case 23:
      put_word(frame, t.read_address);
      put_word(frame, t.read_count);
      put_word(frame, t.write_address);
      put_word(frame, t.write_count);
      put_written();
      break;
    default:
      TACTOR_DEMAND(!"a function that is known");
  }
  if (framing.serial) {
    const std::uint16_t sum = check_sum(frame);
    frame.push_back(static_cast<std::uint8_t>(sum & 0xffU));
    frame.push_back(static_cast<std::uint8_t>(sum >> 8));
  } else {
    const std::size_t length = frame.size() - mbap_length;
    frame[4] = static_cast<std::uint8_t>(length >> 8);
    frame[5] = static_cast<std::uint8_t>(length & 0xff);
  }
  TACTOR_DEMAND(frame.size() <= longest_frame);
}

AnswerState judge_answer(std::span<const std::uint8_t> bytes, const Transaction& t, std::span<const std::uint8_t> sent,
                         const Framing& framing) {
  const std::size_t head = head_of(framing), tail = tail_of(framing);
  // Unit, function and the byte behind it: that tells how long it is.
  const std::size_t beginning = head + 2;
  if (bytes.size() < beginning) return incomplete(beginning - bytes.size());
  if (!framing.serial) {
    if (word_at(bytes, 0) != framing.transaction) {
      return mismatch("transaction number", framing.transaction, word_at(bytes, 0));
    }
    if (word_at(bytes, 2) != 0) return mismatch("protocol id", 0, word_at(bytes, 2));
  }
  const bool exception = bytes[head] == (t.function | exception_flag);
  const std::size_t length = head + tail + (exception ? 2 : body_length(t));
  if (!framing.serial) {
    // A header that states another length may hide another frame in this one.
    const auto stated = static_cast<std::size_t>(word_at(bytes, 4));
    if (stated != length - mbap_length && (exception || bytes[head] == t.function)) {
      return mismatch("length in its header", static_cast<int>(length - mbap_length), static_cast<int>(stated));
    }
  }
  if (bytes[head - 1] != framing.unit) return mismatch("unit", framing.unit, bytes[head - 1]);
  if (!exception && bytes[head] != t.function) return mismatch("function", t.function, bytes[head]);
  const bool is_read = t.function != 6 && t.function != 16;
  if (!exception && is_read && bytes[head + 1] != 2 * t.read_count) {
    return mismatch("count of bytes", 2 * t.read_count, bytes[head + 1]);
  }
  if (bytes.size() < length) return incomplete(length - bytes.size());
  const std::span<const std::uint8_t> frame = bytes.first(length);
  if (framing.serial) {
    const std::uint16_t sum = check_sum(frame.first(length - 2));
    if (frame[length - 2] != (sum & 0xffU) || frame[length - 1] != sum >> 8) {
      return wrong(LinkError::crc, "an answer with a wrong check sum");
    }
  }
  if (exception) {
    const int number = frame[head + 1];
    return wrong(LinkError::exception, "exception " + std::to_string(number) + " (" + name_of_exception(number) + ")",
                 number);
  }
  const std::span<const std::uint8_t> body = frame.subspan(head, length - head - tail);
  if (!is_read && !repeats(body, sent.subspan(head), 1, 3)) {
    return mismatch("address", word_at(sent, head + 1), word_at(body, 1));
  }
  if (!is_read && !repeats(body, sent.subspan(head), 3, 5)) {
    return mismatch(t.function == 6 ? "word" : "count of words", word_at(sent, head + 3), word_at(body, 3));
  }
  AnswerState good;
  good.kind = AnswerState::Kind::good;
  return good;
}

void take_words(std::span<const std::uint8_t> answer, const Transaction& t, const Framing& framing,
                std::uint16_t* words) {
  const std::size_t data = head_of(framing) + 2;
  for (std::size_t i = 0; i < static_cast<std::size_t>(t.read_count); ++i) {
    words[i] = static_cast<std::uint16_t>(word_at(answer, data + 2 * i));
  }
}

}  // namespace tactor::modbus
