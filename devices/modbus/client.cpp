#include "devices/modbus/client.hpp"

#include <fcntl.h>
#include <modbus/modbus-rtu.h>
#include <modbus/modbus-tcp.h>
#include <modbus/modbus.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>

#include "framework/core/check.hpp"
#include "framework/realtime/monotonic_clock.hpp"

namespace tactor::modbus {

namespace {

void sleep_for(Duration length) {
  MonotonicClock::sleep_until(MonotonicClock::now() + length);
}

std::uint32_t microseconds(Duration d) {
  return static_cast<std::uint32_t>(d.ns / 1000 % 1'000'000);
}
std::uint32_t whole_seconds(Duration d) {
  return static_cast<std::uint32_t>(d.ns / 1'000'000'000);
}

LinkError kind_of(int error) {
  if (error > MODBUS_ENOBASE && error < EMBBADCRC) return LinkError::exception;
  switch (error) {
    case ETIMEDOUT:
      return LinkError::timeout;
    case EMBBADCRC:
      return LinkError::crc;
    case EMBBADDATA:
    case EMBBADEXC:
    case EMBMDATA:
    case EMBBADSLAVE:
    case EINVAL:
      return LinkError::protocol;
    default:
      return LinkError::reset;
  }
}

/// Whatever libmodbus does or a test hands over: a write to this file takes what there is room for, and returns.
void never_block(int file) {
  const int flags = fcntl(file, F_GETFL);
  if (flags >= 0) fcntl(file, F_SETFL, flags | O_NONBLOCK);
}

std::string milliseconds(Duration d) {
  return std::to_string(d.ns / 1'000'000) + " ms";
}

std::string what_of(const Transaction& t) {
  char text[80];
  if (t.function == 6 || t.function == 16) {
    std::snprintf(text, sizeof text, "function %d, %d words at %d", t.function, t.write_count, t.write_address);
  } else {
    std::snprintf(text, sizeof text, "function %d, %d words at %d", t.function, t.read_count, t.read_address);
  }
  return text;
}

}  // namespace

std::string Endpoint::text() const {
  return serial ? "rtu:" + path : "tcp:" + host + ":" + std::to_string(port);
}

Endpoint parse_endpoint(const std::string& text) {
  Endpoint endpoint;
  if (text.starts_with("rtu:") && text.size() > 4) {
    endpoint.serial = true;
    endpoint.path = text.substr(4);
    return endpoint;
  }
  const std::size_t colon = text.rfind(':');
  if (text.starts_with("tcp:") && colon != std::string::npos && colon > 4) {
    endpoint.host = text.substr(4, colon - 4);
    const char* end = text.data() + text.size();
    const auto result = std::from_chars(text.data() + colon + 1, end, endpoint.port);
    if (result.ec == std::errc{} && result.ptr == end && endpoint.port >= 1 && endpoint.port <= 65535) return endpoint;
  }
  throw InputError(
      "connect: expected tcp:HOST:PORT or rtu:PATH, such as tcp:192.168.1.5:502 or rtu:/dev/ttyUSB0, found \"" + text +
      "\"");
}

void Client::Free::operator()(void* context) const {
  // Closing a serial port waits, by default for 30 s, until what was written has gone out. What is not out by now was
  // never answered.
  const int file = modbus_get_socket(static_cast<modbus_t*>(context));
  if (file >= 0) tcflush(file, TCOFLUSH);
  modbus_close(static_cast<modbus_t*>(context));
  modbus_free(static_cast<modbus_t*>(context));
}

Client::Client(Endpoint endpoint, LineSettings line, Fence fence, int longest_answer)
    : endpoint_(std::move(endpoint)),
      line_(line),
      fence_(fence),
      longest_answer_{longest_answer * line.character().ns} {}

Client::~Client() = default;

bool Client::make_context() {
  modbus_t* context = endpoint_.serial
                          ? modbus_new_rtu(endpoint_.path.c_str(), line_.baud, line_.parity, 8, line_.stop_bits)
                          : modbus_new_tcp_pi(endpoint_.host.c_str(), std::to_string(endpoint_.port).c_str());
  if (context == nullptr) return false;
  context_.reset(context);
  modbus_set_error_recovery(context, MODBUS_ERROR_RECOVERY_NONE);
  modbus_set_response_timeout(context, whole_seconds(line_.response_timeout), microseconds(line_.response_timeout));
  // Zero: the whole answer must be there by the response timeout, so that dripping bytes do not prolong it.
  modbus_set_byte_timeout(context, 0, 0);
  modbus_set_slave(context, line_.unit);
  return true;
}

void Client::attach(int file) {
  disconnect();
  TACTOR_DEMAND(make_context());
  modbus_set_socket(static_cast<modbus_t*>(context_.get()), file);
  never_block(file);
  unclear_ = false;
}

bool Client::connect(LinkFailure& failure) {
  disconnect();
  if (!make_context()) {
    failure = {LinkError::disconnected, std::string("cannot be opened: ") + modbus_strerror(errno), true};
    return false;
  }
  if (modbus_connect(static_cast<modbus_t*>(context_.get())) != 0) {
    const int error = errno;
    context_.reset();
    failure = {LinkError::disconnected, std::string("no connection: ") + modbus_strerror(error), true};
    return false;
  }
  never_block(modbus_get_socket(static_cast<modbus_t*>(context_.get())));
  unclear_ = endpoint_.serial;
  return true;
}

void Client::disconnect() {
  context_.reset();
}

void Client::keep_silence() {
  if (!endpoint_.serial) return;
  const Instant until{silent_from_ns_ + line_.silent().ns};
  MonotonicClock::sleep_until(until);
}

// At most so much at once, because a peer that never stops sending may be quicker.
bool Client::throw_away() {
  constexpr int most_reads = 16;
  const int file = modbus_get_socket(static_cast<modbus_t*>(context_.get()));
  if (endpoint_.serial) return tcflush(file, TCIOFLUSH) == 0;
  std::array<char, 4096> bytes{};
  for (int i = 0; i < most_reads; ++i) {
    const ssize_t n = recv(file, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (n < 0) return errno == EAGAIN || errno == EWOULDBLOCK;
    if (n < static_cast<ssize_t>(bytes.size())) break;
  }
  return true;
}

bool Client::drain() {
  const int file = modbus_get_socket(static_cast<modbus_t*>(context_.get()));
  const Duration look = std::max(Duration{2'000'000}, line_.silent() + Duration{2 * line_.character().ns});
  const Instant give_up = MonotonicClock::now() + line_.response_timeout + longest_answer_;
  // Silent twice in a row.
  for (int silent = 0; silent < 2;) {
    int waiting = 0;
    if (ioctl(file, FIONREAD, &waiting) != 0) return false;
    if (waiting > 0) {
      silent = 0;
      if (!throw_away()) return false;
      if (MonotonicClock::now() > give_up) return false;
    } else {
      ++silent;
    }
    sleep_for(look);
  }
  return true;
}

bool Client::clear_line(LinkFailure& failure) {
  ++fences_;
  if (endpoint_.serial) {
    sleep_for(line_.response_timeout + longest_answer_);
  }
  if (!drain()) {
    failure = {LinkError::protocol, "the line does not fall silent", true};
    return false;
  }
  std::vector<std::uint16_t> words(static_cast<std::size_t>(fence_.count));
  if (!request({.function = fence_.function, .read_address = fence_.address, .read_count = fence_.count}, nullptr,
               words.data(), failure)) {
    if (failure.error != LinkError::exception) return false;
    if (endpoint_.serial) {
      failure.text = "the fence is refused, so that late answers cannot be told from new ones: " + failure.text +
                     "; give the profile a fence that the device answers with words";
      failure.reopen = true;
      return false;
    }
  }
  unclear_ = false;
  return true;
}

bool Client::transfer(const Transaction& transaction, const std::uint16_t* written, std::uint16_t* read,
                      LinkFailure& failure) {
  if (context_ == nullptr) {
    failure = {LinkError::disconnected, "not connected", true};
    return false;
  }
  if (unclear_ && !clear_line(failure)) return false;
  return request(transaction, written, read, failure);
}

bool Client::has_room(const Transaction& t, LinkFailure& failure) {
  pollfd file{modbus_get_socket(static_cast<modbus_t*>(context_.get())), POLLOUT, 0};
  const Instant give_up = MonotonicClock::now() + line_.response_timeout;
  for (;;) {
    const std::int64_t left = std::max<std::int64_t>(0, (give_up - MonotonicClock::now()).ns);
    const timespec time{left / 1'000'000'000, left % 1'000'000'000};
    const int ready = ppoll(&file, 1, &time, nullptr);
    if (ready < 0 && errno == EINTR) continue;
    // What is wrong with the file the request finds out.
    if (ready != 0) return true;
    failure = {LinkError::timeout,
               "the line takes no request within " + milliseconds(line_.response_timeout) +
                   ": what was sent before is still waiting to go out (" + what_of(t) + ")",
               true};
    unclear_ = true;
    return false;
  }
}

bool Client::request(const Transaction& t, const std::uint16_t* written, std::uint16_t* read, LinkFailure& failure) {
  auto* context = static_cast<modbus_t*>(context_.get());
  keep_silence();
  if (!has_room(t, failure)) return false;
  errno = 0;
  int done = -1, expected = 0;
  switch (t.function) {
    case 3:
      done = modbus_read_registers(context, t.read_address, expected = t.read_count, read);
      break;
    case 4:
      done = modbus_read_input_registers(context, t.read_address, expected = t.read_count, read);
      break;
    case 6:
      done = modbus_write_register(context, t.write_address, written[0]);
      expected = 1;
      break;
    case 16:
      done = modbus_write_registers(context, t.write_address, expected = t.write_count, written);
      break;
    case 23:
      done = modbus_write_and_read_registers(context, t.write_address, t.write_count, written, t.read_address,
                                             expected = t.read_count, read);
      break;
    default:
      TACTOR_DEMAND(!"a function that is known");
  }
  const int error = done < 0 ? errno : done == expected ? 0 : EMBBADDATA;
  silent_from_ns_ = MonotonicClock::now().ns;
  if (error == 0) return true;
  explain(error, t, failure);
  return false;
}

void Client::explain(int error, const Transaction& t, LinkFailure& failure) {
  failure.error = kind_of(error);
  failure.reopen = failure.error == LinkError::reset;
  unclear_ = unclear_ || (failure.error != LinkError::exception);
  std::string text = modbus_strerror(error);
  if (error == ETIMEDOUT) {
    text = "no whole answer within " + milliseconds(line_.response_timeout);
  } else if (failure.error == LinkError::exception) {
    text = "exception " + std::to_string(error - MODBUS_ENOBASE) + " (" + text + ")";
  }
  failure.text = text + " (" + what_of(t) + ")";
}

}  // namespace tactor::modbus
