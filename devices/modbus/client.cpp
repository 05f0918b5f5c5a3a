#include "devices/modbus/client.hpp"

#include <fcntl.h>
#include <modbus/modbus-rtu.h>
#include <modbus/modbus-tcp.h>
#include <modbus/modbus.h>
#include <netdb.h>
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

#include "devices/hardware/device_descriptors.hpp"
#include "devices/modbus/frame.hpp"
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

/// Whatever libmodbus does or a test hands over: a write to this file takes what there is room for, and returns.
void never_block(int file) {
  const int flags = fcntl(file, F_GETFL);
  if (flags >= 0) fcntl(file, F_SETFL, flags | O_NONBLOCK);
}

/// The numbers of a host's addresses, so that connecting does not wait for a look-up while nobody may fork. The name
/// itself where it cannot be found: connecting to it says why.
std::vector<std::string> addresses_of(const Endpoint& endpoint) {
  std::vector<std::string> numbers;
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* list = nullptr;
  if (getaddrinfo(endpoint.host.c_str(), nullptr, &hints, &list) == 0) {
    for (const addrinfo* entry = list; entry != nullptr; entry = entry->ai_next) {
      std::array<char, NI_MAXHOST> number{};
      if (getnameinfo(entry->ai_addr, entry->ai_addrlen, number.data(), number.size(), nullptr, 0, NI_NUMERICHOST) != 0)
        continue;
      numbers.emplace_back(number.data());
    }
    freeaddrinfo(list);
  }
  if (numbers.empty()) numbers.push_back(endpoint.host);
  return numbers;
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
  auto* line = static_cast<modbus_t*>(context);
  const int file = modbus_get_socket(line);
  const NoFork until_closed;
  if (forget_descriptor(file)) {
    // Closing a serial port waits, by default for 30 s, until what was written has gone out. What is not out by now was
    // never answered.
    tcflush(file, TCOFLUSH);
  } else {
    modbus_set_socket(line, -1);  // never opened, or of the parent of this process
  }
  modbus_close(line);
  modbus_free(line);
}

Client::Client(Endpoint endpoint, LineSettings line, Fence fence, int longest_answer)
    : endpoint_(std::move(endpoint)),
      line_(line),
      fence_(fence),
      longest_answer_{longest_answer * line.character().ns} {}

Client::~Client() = default;

bool Client::make_context(const std::string& where) {
  modbus_t* context = endpoint_.serial ? modbus_new_rtu(where.c_str(), line_.baud, line_.parity, 8, line_.stop_bits)
                                       : modbus_new_tcp_pi(where.c_str(), std::to_string(endpoint_.port).c_str());
  if (context == nullptr) return false;
  context_.reset(context);
  modbus_set_error_recovery(context, MODBUS_ERROR_RECOVERY_NONE);
  // The time that connecting may take.
  modbus_set_response_timeout(context, whole_seconds(line_.response_timeout), microseconds(line_.response_timeout));
  return true;
}

void Client::attach(int file) {
  disconnect();
  TACTOR_DEMAND(make_context(endpoint_.serial ? endpoint_.path : endpoint_.host));
  keep_from_children(file);
  modbus_set_socket(static_cast<modbus_t*>(context_.get()), file);
  never_block(file);
  transaction_ = 0;
  unclear_ = false;
}

bool Client::open_line(const std::string& where, LinkFailure& failure) {
  if (!make_context(where)) {
    failure = {LinkError::disconnected, std::string("cannot be opened: ") + modbus_strerror(errno), true};
    return false;
  }
  const NoFork until_kept;
  if (modbus_connect(static_cast<modbus_t*>(context_.get())) == 0) {
    keep_from_children(file_of_line());
    return true;
  }
  failure = {LinkError::disconnected, std::string("no connection: ") + modbus_strerror(errno), true};
  context_.reset();
  return false;
}

bool Client::connect(LinkFailure& failure) {
  disconnect();
  if (std::string why; endpoint_.serial && !lock_.take(endpoint_.path, why)) {
    failure = {LinkError::disconnected, why, true};
    return false;
  }
  for (const std::string& where : endpoint_.serial ? std::vector{endpoint_.path} : addresses_of(endpoint_)) {
    if (open_line(where, failure)) break;
  }
  if (context_ == nullptr) {
    disconnect();
    return false;
  }
  lock_.exclude();
  never_block(file_of_line());
  transaction_ = 0;
  unclear_ = endpoint_.serial;
  return true;
}

void Client::disconnect() {
  context_.reset();
  lock_.release();
}

int Client::file_of_line() const {
  return modbus_get_socket(static_cast<modbus_t*>(context_.get()));
}

void Client::keep_silence() {
  if (!endpoint_.serial) return;
  const Instant until{silent_from_ns_ + line_.silent().ns};
  MonotonicClock::sleep_until(until);
}

// At most so much at once, because a peer that never stops sending may be quicker.
bool Client::throw_away() {
  constexpr int most_reads = 16;
  const int file = file_of_line();
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
  const int file = file_of_line();
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
      failure.text = "the device refuses the fence, so late answers cannot be told from new ones: " + failure.text +
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

// Nobody has asked for anything, and yet something has come.
bool Client::refuse_unasked(LinkFailure& failure) {
  const int file = file_of_line();
  int waiting = 0;
  if (unclear_ || ioctl(file, FIONREAD, &waiting) != 0 || waiting == 0) return true;
  unclear_ = true;
  failure = {LinkError::protocol,
             std::to_string(waiting) +
                 " bytes came without a request: another master may be using this line, or it is disturbed",
             false};
  return false;
}

bool Client::fail_with(int error, LinkFailure& failure) {
  unclear_ = true;
  failure = {LinkError::reset, std::strerror(error), true};
  return false;
}

/// Waits for `events` of the line; an error number, 0 where they have come. What is wrong with the file, the next call
/// finds out.
int Client::wait_for(short events, Instant give_up) const {
  pollfd file{file_of_line(), events, 0};
  for (;;) {
    const std::int64_t left = std::max<std::int64_t>(0, (give_up - MonotonicClock::now()).ns);
    const timespec time{left / 1'000'000'000, left % 1'000'000'000};
    const int ready = ppoll(&file, 1, &time, nullptr);
    if (ready > 0) return 0;
    if (ready == 0) return ETIMEDOUT;
    if (errno != EINTR) return errno;
  }
}

bool Client::send_request(std::span<const std::uint8_t> frame, LinkFailure& failure) {
  const int file = file_of_line();
  const Instant give_up = MonotonicClock::now() + line_.response_timeout;
  for (std::size_t sent = 0; sent < frame.size();) {
    if (const int error = wait_for(POLLOUT, give_up); error == ETIMEDOUT) {
      unclear_ = true;
      failure = {LinkError::timeout,
                 "the line takes no request within " + milliseconds(line_.response_timeout) +
                     ": what was sent before is still waiting to go out",
                 true};
      return false;
    } else if (error != 0) {
      return fail_with(error, failure);
    }
    const std::span<const std::uint8_t> rest = frame.subspan(sent);
    const ssize_t n = endpoint_.serial ? ::write(file, rest.data(), rest.size())
                                       : ::send(file, rest.data(), rest.size(), MSG_NOSIGNAL);
    if (n > 0) sent += static_cast<std::size_t>(n);
    if (n < 0 && errno != EAGAIN && errno != EINTR) return fail_with(errno, failure);
    // A line may say that it takes more, and then take nothing.
    if (n <= 0 && MonotonicClock::now() > give_up) return fail_with(ETIMEDOUT, failure);
  }
  return true;
}

bool Client::request(const Transaction& t, const std::uint16_t* written, std::uint16_t* read, LinkFailure& failure) {
  keep_silence();
  const bool done = refuse_unasked(failure) && exchange(t, written, read, failure);
  silent_from_ns_ = MonotonicClock::now().ns;
  if (!done) failure.text += " (" + what_of(t) + ")";
  return done;
}

bool Client::exchange(const Transaction& t, const std::uint16_t* written, std::uint16_t* read, LinkFailure& failure) {
  transaction_ = (transaction_ + 1) & 0xffff;
  const Framing framing{endpoint_.serial, line_.unit, transaction_};
  put_request(t, written, framing, sent_);
  if (!send_request(sent_, failure)) return false;
  const Instant give_up = MonotonicClock::now() + line_.response_timeout;
  std::array<std::uint8_t, longest_frame> bytes{};
  std::size_t come = 0;
  for (;;) {
    const std::span<const std::uint8_t> answer(bytes.data(), come);
    const AnswerState state = judge_answer(answer, t, sent_, framing);
    if (state.kind == AnswerState::Kind::good) {
      take_words(answer, t, framing, read);
      return true;
    }
    if (state.kind == AnswerState::Kind::wrong) {
      unclear_ = unclear_ || state.error != LinkError::exception;
      failure = {state.error, state.text, false};
      return false;
    }
    // The whole answer must be there by then, so that dripping bytes do not prolong it.
    if (const int error = wait_for(POLLIN, give_up); error == ETIMEDOUT) {
      unclear_ = true;
      failure = {LinkError::timeout, "no whole answer within " + milliseconds(line_.response_timeout), false};
      return false;
    } else if (error != 0) {
      return fail_with(error, failure);
    }
    // No more than the answer has: what comes behind it is found before the next request.
    const ssize_t n = ::read(file_of_line(), bytes.data() + come, std::min(state.missing, bytes.size() - come));
    if (n > 0) come += static_cast<std::size_t>(n);
    if (n == 0) return fail_with(ECONNRESET, failure);
    if (n < 0 && errno != EAGAIN && errno != EINTR) return fail_with(errno, failure);
  }
}

}  // namespace tactor::modbus
