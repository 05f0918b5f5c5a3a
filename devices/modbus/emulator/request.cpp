#include "devices/modbus/emulator/request.hpp"

#include "devices/modbus/frame.hpp"

namespace tactor::modbus {

namespace {

constexpr std::size_t mbap_length = 6;
constexpr int most_read = 125, most_written = 123, most_written_combined = 121;

int word_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  return bytes[at] << 8 | bytes[at + 1];
}

void put_word(std::vector<std::uint8_t>& bytes, int word) {
  bytes.push_back(static_cast<std::uint8_t>(word >> 8 & 0xff));
  bytes.push_back(static_cast<std::uint8_t>(word & 0xff));
}

/// Bytes of a request from its function on; 0: not known yet, -1: of no function that is known.
int body_length(std::span<const std::uint8_t> body) {
  if (body.empty()) return 0;
  const int function = body[0];
  if (function >= 1 && function <= 6) return 5;
  const std::size_t count_at = function == 15 || function == 16 ? 5 : function == 23 ? 9 : 0;
  if (count_at == 0) return -1;
  return body.size() > count_at ? static_cast<int>(count_at) + 1 + body[count_at] : 0;
}

/// Reads the function and what follows it, all of which is there. Nothing beyond `body` is looked at.
void read_body(std::span<const std::uint8_t> body, Request& request) {
  request.function = body[0];
  Transaction& t = request.what;
  t.function = request.function;
  const bool reads = t.function == 3 || t.function == 4 || t.function == 23;
  const bool writes = t.function == 6 || t.function == 16 || t.function == 23;
  if (!reads && !writes) {
    request.exception = 1;
    return;
  }
  // What a request over TCP has beyond or short of its function's bytes.
  if (body_length(body) != static_cast<int>(body.size())) {
    request.exception = 3;
    return;
  }
  if (reads) {
    t.read_address = word_at(body, 1);
    t.read_count = word_at(body, 3);
  }
  std::span<const std::uint8_t> data;
  if (t.function == 6) {
    t.write_address = word_at(body, 1);
    t.write_count = 1;
    data = body.subspan(3);
  } else if (writes) {
    const std::size_t at = t.function == 16 ? 1 : 5;
    t.write_address = word_at(body, at);
    t.write_count = word_at(body, at + 2);
    data = body.subspan(at + 5);
  }
  const int most = t.function == 23 ? most_written_combined : most_written;
  const bool fits = (!reads || (t.read_count >= 1 && t.read_count <= most_read)) &&
                    (!writes || (t.write_count >= 1 && t.write_count <= most &&
                                 data.size() == 2 * static_cast<std::size_t>(t.write_count)));
  if (!fits) {
    request.exception = 3;
    return;
  }
  for (std::size_t i = 0; i < data.size(); i += 2) {
    request.written.push_back(static_cast<std::uint16_t>(word_at(data, i)));
  }
}

std::vector<std::uint8_t> framed(const Request& request, bool serial, const std::vector<std::uint8_t>& body) {
  std::vector<std::uint8_t> frame;
  if (!serial) {
    put_word(frame, request.transaction);
    put_word(frame, 0);
    put_word(frame, static_cast<int>(body.size()) + 1);
  }
  frame.push_back(static_cast<std::uint8_t>(request.unit));
  frame.insert(frame.end(), body.begin(), body.end());
  if (serial) {
    const std::uint16_t sum = check_sum(frame);
    frame.push_back(static_cast<std::uint8_t>(sum & 0xffU));
    frame.push_back(static_cast<std::uint8_t>(sum >> 8));
  }
  return frame;
}

TakenRequest take_over_tcp(std::span<const std::uint8_t> bytes) {
  using Kind = TakenRequest::Kind;
  TakenRequest taken;
  if (bytes.size() < mbap_length) return taken;
  const auto stated = static_cast<std::size_t>(word_at(bytes, 4));
  if (stated < 2 || mbap_length + stated > longest_frame) {
    taken.kind = Kind::broken;
    return taken;
  }
  if (bytes.size() < mbap_length + stated) return taken;
  taken.length = mbap_length + stated;
  taken.kind = word_at(bytes, 2) == 0 ? Kind::whole : Kind::ignored;
  taken.request.transaction = word_at(bytes, 0);
  taken.request.unit = bytes[mbap_length];
  read_body(bytes.subspan(mbap_length + 1, stated - 1), taken.request);
  return taken;
}

TakenRequest take_from_line(std::span<const std::uint8_t> bytes) {
  using Kind = TakenRequest::Kind;
  TakenRequest taken;
  if (bytes.size() < 2) return taken;
  const int body = body_length(bytes.subspan(1));
  if (body == 0) return taken;
  const std::size_t length = 1 + static_cast<std::size_t>(std::max(0, body)) + 2;
  if (body < 0 || length > longest_frame) {
    taken.kind = Kind::broken;
    return taken;
  }
  if (bytes.size() < length) return taken;
  const std::uint16_t sum = check_sum(bytes.first(length - 2));
  if (bytes[length - 2] != (sum & 0xffU) || bytes[length - 1] != sum >> 8) {
    taken.kind = Kind::broken;
    return taken;
  }
  taken.kind = Kind::whole;
  taken.length = length;
  taken.request.unit = bytes[0];
  read_body(bytes.subspan(1, length - 3), taken.request);
  return taken;
}

}  // namespace

TakenRequest take_request(std::span<const std::uint8_t> bytes, bool serial) {
  return serial ? take_from_line(bytes) : take_over_tcp(bytes);
}

std::vector<std::uint8_t> exception_frame(const Request& request, bool serial, int exception) {
  return framed(request, serial,
                {static_cast<std::uint8_t>(request.function | 0x80), static_cast<std::uint8_t>(exception)});
}

std::vector<std::uint8_t> answer_request(const Request& request, bool serial, EmulatedDevice& device) {
  constexpr int illegal_address = 2;
  if (request.exception != 0) return exception_frame(request, serial, request.exception);
  const Transaction& t = request.what;
  std::vector<std::uint16_t> words(static_cast<std::size_t>(t.read_count));
  // Before anything is written, so that a refused request changes nothing.
  bool good = t.read_count == 0 || device.read(t.read_address, t.read_count, words.data());
  if (good && t.write_count > 0) {
    good = device.write(t.write_address, t.write_count, request.written.data()) &&
           (t.read_count == 0 || device.read(t.read_address, t.read_count, words.data()));
  }
  if (!good) return exception_frame(request, serial, illegal_address);
  std::vector<std::uint8_t> body{static_cast<std::uint8_t>(t.function)};
  if (t.read_count > 0) {
    body.push_back(static_cast<std::uint8_t>(2 * t.read_count));
    for (const std::uint16_t word : words) put_word(body, word);
  } else {
    put_word(body, t.write_address);
    put_word(body, t.function == 6 ? request.written[0] : t.write_count);
  }
  return framed(request, serial, body);
}

}  // namespace tactor::modbus
