#include "devices/modbus/emulator/server.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <modbus/modbus-rtu.h>
#include <modbus/modbus-tcp.h>
#include <modbus/modbus.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "devices/modbus/cycle_plan.hpp"
#include "framework/core/check.hpp"
#include "framework/realtime/thread_policy.hpp"

namespace tactor::modbus {

namespace {

constexpr int poll_ms = 5;
constexpr Duration move_period{500'000};
constexpr int moves_a_log_line = 4;
// A device keeps its time whatever else the computer does; below the loops that are tried on it. Refused, it does
// without.
const ThreadSettings punctual{SchedulingPolicy::fifo, 40, std::nullopt};

[[noreturn]] void fail(const std::string& what) {
  throw RunError("the emulator: " + what + ": " + std::strerror(errno));
}

double value_or(const Fault& fault, double otherwise) {
  return fault.value == 0 ? otherwise : fault.value;
}

int word_at(const std::uint8_t* bytes) {
  return bytes[0] << 8 | bytes[1];
}

}  // namespace

Emulator::Emulator(Profile profile, EmulatorOptions options)
    : options_(std::move(options)), device_(std::move(profile)) {
  for (const Fault& fault : options_.faults) faults_.push_back({fault, false, false, {}});
  if (!options_.log.empty()) {
    log_.open(options_.log);
    if (!log_) fail("cannot write " + options_.log);
  }
  int pair[2];
  if (socketpair(AF_UNIX, SOCK_STREAM, 0, pair) != 0) fail("no socket");
  reply_in_ = pair[0];
  reply_out_ = pair[1];
  mapping_ = modbus_mapping_new(0, 0, 65536, 65536);
  if (mapping_ == nullptr) fail("no memory");
  options_.serial ? open_pty() : open_tcp();
  const LineSettings& line = device_.profile().line;
  modbus_set_slave(context_, line.unit);
  modbus_set_response_timeout(context_, 0, 1);  // which libmodbus sleeps for before some exceptions
  modbus_set_byte_timeout(context_, 0, 100'000);
}

Emulator::~Emulator() {
  stop();
  if (options_.serial) close_pty();
  if (kept_open_ >= 0) close(kept_open_);
  for (const int file : clients_) close(file);
  for (const int file : {listen_, reply_in_, reply_out_}) {
    if (file >= 0) close(file);
  }
  if (context_ != nullptr) {
    modbus_set_socket(context_, -1);
    modbus_free(context_);
  }
  modbus_mapping_free(static_cast<modbus_mapping_t*>(mapping_));
}

void Emulator::open_tcp() {
  listen_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (listen_ < 0) fail("no socket");
  const int on = 1;
  setsockopt(listen_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(options_.port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (bind(listen_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 || listen(listen_, 8) != 0) {
    fail("cannot listen on port " + std::to_string(options_.port));
  }
  socklen_t size = sizeof address;
  getsockname(listen_, reinterpret_cast<sockaddr*>(&address), &size);
  address_ = "tcp:127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  context_ = modbus_new_tcp("127.0.0.1", ntohs(address.sin_port));
  if (context_ == nullptr) fail("no context");
}

void Emulator::open_pty() {
  terminal_ = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (terminal_ < 0 || grantpt(terminal_) != 0 || unlockpt(terminal_) != 0) fail("no pseudo-terminal");
  char name[128];
  if (ptsname_r(terminal_, name, sizeof name) != 0) fail("no pseudo-terminal");
  if (kept_open_ >= 0) close(kept_open_);
  // Kept open, so that the terminal stays when a client closes it, and raw, so that no byte is changed.
  kept_open_ = open(name, O_RDWR | O_NOCTTY | O_CLOEXEC);
  termios settings{};
  if (kept_open_ < 0 || tcgetattr(kept_open_, &settings) != 0) fail(std::string("cannot open ") + name);
  cfmakeraw(&settings);
  tcsetattr(kept_open_, TCSANOW, &settings);
  const LineSettings& line = device_.profile().line;
  if (address_.empty()) address_ = std::string("rtu:") + (options_.link.empty() ? name : options_.link);
  // What it is called is of no matter: the files are set for each request.
  if (context_ == nullptr) context_ = modbus_new_rtu(name, line.baud, line.parity, 8, line.stop_bits);
  if (context_ == nullptr) fail("no context");
  clients_.push_back(terminal_);
  if (options_.link.empty()) return;
  unlink(options_.link.c_str());
  if (symlink(name, options_.link.c_str()) != 0) fail("--link " + options_.link + ": cannot make it");
}

void Emulator::close_pty() {
  if (terminal_ < 0) return;
  if (!options_.link.empty()) unlink(options_.link.c_str());
  std::erase(clients_, terminal_);
  close(terminal_);
  terminal_ = -1;
  // Its other end stays open, so that no other program gets a terminal of that name, which a client may ask for again.
}

void Emulator::pull_or_plug() {
  if (!options_.serial) return;
  const bool plugged = terminal_ >= 0;
  bool pulled = false;
  {
    const std::scoped_lock lock(mutex_);
    pulled = active(FaultKind::unplug) != nullptr;
  }
  if (plugged && pulled) close_pty();
  if (!plugged && !pulled) open_pty();
}

void Emulator::start() {
  origin_ = MonotonicClock::now();
  mover_ = std::thread([this] { move(); });
  server_ = std::thread([this] { serve(); });
}

void Emulator::stop() {
  stop_ = true;
  if (server_.joinable()) server_.join();
  if (mover_.joinable()) mover_.join();
}

void Emulator::inject(const Fault& fault) {
  const std::scoped_lock lock(mutex_);
  faults_.push_back({fault, false, false, {}});
  begin_faults();
}

EmulatedState Emulator::state() const {
  const std::scoped_lock lock(mutex_);
  return device_.state();
}

void Emulator::pause(double seconds) const {
  const Instant end = MonotonicClock::now() + Duration::from_seconds(seconds);
  while (!stop_ && MonotonicClock::now() < end) {
    MonotonicClock::sleep_until(std::min(end, MonotonicClock::now() + Duration{20'000'000}));
  }
}

void Emulator::move() {
  apply_thread_settings(punctual, "emulated-device");
  for (std::int64_t k = 0; !stop_; ++k) {
    MonotonicClock::sleep_until(MonotonicClock::now() + move_period);
    const Time now = Time{} + (MonotonicClock::now() - origin_);
    const std::scoped_lock lock(mutex_);
    device_.advance(now);
    begin_faults();
    end_faults();
    if (!log_.is_open() || k % moves_a_log_line != 0) continue;
    const EmulatedState s = device_.state();
    // Flushed, because who ends this program does not always let it end.
    log_ << (origin_ + (s.time - Time{})).ns << ' ' << s.position << ' ' << s.force << ' ' << s.commanded << ' '
         << s.expired << ' ' << s.commands << '\n'
         << std::flush;
  }
}

void Emulator::begin_faults() {
  const Instant now = MonotonicClock::now();
  for (Waiting& w : faults_) {
    if (w.begun) continue;
    const bool due = w.fault.when_driven ? device_.driven_for() > w.fault.time
                                         : any_request_ && (now - first_request_).seconds() >= w.fault.time;
    if (due) begin(w);
  }
}

void Emulator::begin(Waiting& w) {
  w.begun = true;
  w.began = MonotonicClock::now();
  switch (w.fault.kind) {
    case FaultKind::jump:
      device_.jump(value_or(w.fault, 0.06));
      w.over = true;
      break;
    case FaultKind::stuck:
      device_.stick(true);
      break;
    case FaultKind::status:
      device_.set_error(static_cast<int>(value_or(w.fault, 5)));
      w.over = true;
      break;
    case FaultKind::another:
      device_.become_another();
      drop_clients_ = true;
      w.over = true;
      break;
    case FaultKind::reset:
      drop_clients_ = !options_.serial;
      w.over = drop_clients_;
      break;
    default:
      break;
  }
}

void Emulator::end_faults() {
  const auto lasts = [](FaultKind kind) {
    return kind == FaultKind::silent || kind == FaultKind::crc || kind == FaultKind::slave ||
           kind == FaultKind::exception || kind == FaultKind::stuck || kind == FaultKind::unplug;
  };
  for (Waiting& w : faults_) {
    if (!w.begun || w.over || w.fault.value <= 0 || !lasts(w.fault.kind)) continue;
    if ((MonotonicClock::now() - w.began).seconds() < w.fault.value) continue;
    w.over = true;
    if (w.fault.kind == FaultKind::stuck) device_.stick(false);
  }
}

void Emulator::end_all_faults() {
  const std::scoped_lock lock(mutex_);
  for (Waiting& w : faults_) {
    if (!w.begun || w.over) continue;
    w.over = true;
    if (w.fault.kind == FaultKind::stuck) device_.stick(false);
  }
}

Emulator::Waiting* Emulator::active(FaultKind kind) {
  for (Waiting& w : faults_) {
    if (w.begun && !w.over && w.fault.kind == kind) return &w;
  }
  return nullptr;
}

void Emulator::serve() {
  apply_thread_settings(punctual, "emulated-line");
  while (!stop_) {
    bool drops = false;
    {
      const std::scoped_lock lock(mutex_);
      drops = drop_clients_;
      drop_clients_ = false;
    }
    if (drops && !options_.serial) {
      while (!clients_.empty()) drop(clients_.back());
    }
    pull_or_plug();
    std::vector<pollfd> files;
    if (listen_ >= 0) files.push_back({listen_, POLLIN, 0});
    for (const int file : clients_) files.push_back({file, POLLIN, 0});
    if (poll(files.data(), files.size(), poll_ms) <= 0) continue;
    for (const pollfd& file : files) {
      if (file.revents == 0) continue;
      file.fd == listen_ ? accept_client() : answer(file.fd);
    }
  }
}

void Emulator::accept_client() {
  const int file = accept4(listen_, nullptr, nullptr, SOCK_CLOEXEC);
  if (file < 0) return;
  const int on = 1;
  setsockopt(file, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  clients_.push_back(file);
  ++connections_;
}

void Emulator::drop(int file) {
  // Reset rather than ended, as by a device that lost its power.
  const linger now{1, 0};
  setsockopt(file, SOL_SOCKET, SO_LINGER, &now, sizeof now);
  close(file);
  std::erase(clients_, file);
}

void Emulator::answer(int file) {
  std::uint8_t request[MODBUS_TCP_MAX_ADU_LENGTH];
  modbus_set_socket(context_, file);
  const int length = modbus_receive(context_, request);
  if (length < 0) {
    if (options_.serial) {
      tcflush(file, TCIFLUSH);
      if (errno == EIO) pause(0.01);
    } else {
      drop(file);
    }
    return;
  }
  if (length == 0) return;  // for another slave
  std::vector<std::uint8_t> frame;
  {
    const std::scoped_lock lock(mutex_);
    if (!any_request_) first_request_ = MonotonicClock::now();
    any_request_ = true;
    device_.asked();
  }
  if (options_.serial && options_.line_delay) pause(line_seconds(request, length));
  {
    const std::scoped_lock lock(mutex_);
    device_.advance(Time{} + (MonotonicClock::now() - origin_));
    frame = reply_to(request, length);
  }
  send(file, std::move(frame));
}

double Emulator::line_seconds(const std::uint8_t* request, int length) const {
  if (length < 6) return 0;
  Transaction t{.function = request[1]};
  const int a = word_at(request + 2), n = word_at(request + 4);
  if (t.function == 16) {
    t.write_address = a;
    t.write_count = n;
  } else {
    t.read_address = a;
    t.read_count = n;
  }
  if (t.function == 23 && length >= 10) t.write_count = word_at(request + 8);
  const LineSettings& line = device_.profile().line;
  // The silence after the answer is the client's to keep.
  return seconds_of(t, line, true) - line.silent().seconds();
}

std::vector<std::uint8_t> Emulator::reply_to(const std::uint8_t* request, int length) {
  auto* map = static_cast<modbus_mapping_t*>(mapping_);
  const std::uint8_t* pdu = request + modbus_get_header_length(context_);
  const int function = pdu[0];
  const int at = word_at(pdu + 1), n = function == 6 ? 1 : word_at(pdu + 3);
  const bool writes = function == 6 || function == 16;
  bool good = function == 3 || function == 4 || function == 6 || function == 16 || function == 23;
  std::vector<std::uint16_t> words(65536);
  if (good && !writes) good = device_.read(at, std::min(n, 125), words.data());
  int write_at = at, write_n = n;
  const std::uint8_t* data = function == 6 ? pdu + 3 : pdu + 6;
  if (function == 23) {
    write_at = word_at(pdu + 5);
    write_n = word_at(pdu + 7);
    data = pdu + 10;
  }
  const bool known = function == 3 || function == 4 || function == 6 || function == 16 || function == 23;
  if (active(FaultKind::exception) != nullptr) {
    ++fault_answers_;
    modbus_set_socket(context_, reply_in_);
    modbus_reply_exception(context_, request, MODBUS_EXCEPTION_SLAVE_OR_SERVER_FAILURE);
  } else {
    if (good && (writes || function == 23)) {
      ++writes_;
      write_n = std::clamp(write_n, 0, 123);
      std::vector<std::uint16_t> written(static_cast<std::size_t>(write_n));
      for (int i = 0; i < write_n; ++i)
        written[static_cast<std::size_t>(i)] =
            static_cast<std::uint16_t>(word_at(data + 2 * static_cast<std::ptrdiff_t>(i)));
      good = write_at + write_n <= 65536 && device_.write(write_at, write_n, written.data());
      if (good && function == 23) good = device_.read(at, std::min(n, 125), words.data());
    }
    modbus_set_socket(context_, reply_in_);
    if (known && !good) {
      modbus_reply_exception(context_, request, MODBUS_EXCEPTION_ILLEGAL_DATA_ADDRESS);
    } else {
      if (good && !writes) {
        std::uint16_t* into = function == 4 ? map->tab_input_registers : map->tab_registers;
        std::copy_n(words.begin(), std::min(n, 125), into + at);
      }
      modbus_reply(context_, request, length, map);
    }
  }
  std::vector<std::uint8_t> frame(512);
  const ssize_t size = recv(reply_out_, frame.data(), frame.size(), MSG_DONTWAIT);
  frame.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  return frame;
}

void Emulator::disturb(std::vector<std::uint8_t>& frame) {
  if (frame.size() < 4) return;
  if (active(FaultKind::crc) != nullptr) {
    // Over TCP the transaction number stands where a check sum would tell.
    frame[options_.serial ? frame.size() - 1 : 1] ^= 0x55U;
    ++fault_answers_;
  }
  if (active(FaultKind::slave) != nullptr) {
    ++fault_answers_;
    if (!options_.serial) {
      frame[0] ^= 0x55U;
    } else {
      // A whole answer of the slave beside it: its check sum is right.
      frame[0] = static_cast<std::uint8_t>(frame[0] + 1);
      std::uint16_t sum = 0xffff;
      for (std::size_t i = 0; i + 2 < frame.size(); ++i) {
        sum = static_cast<std::uint16_t>(sum ^ frame[i]);
        for (int bit = 0; bit < 8; ++bit)
          sum = static_cast<std::uint16_t>((sum & 1U) != 0 ? (sum >> 1) ^ 0xa001U : sum >> 1);
      }
      frame[frame.size() - 2] = static_cast<std::uint8_t>(sum & 0xffU);
      frame[frame.size() - 1] = static_cast<std::uint8_t>(sum >> 8);
    }
  }
  if (Waiting* reset = active(FaultKind::reset)) {
    for (std::uint8_t& byte : frame) byte ^= 0xa5U;
    reset->over = true;
    ++fault_answers_;
  }
}

void Emulator::send(int file, std::vector<std::uint8_t> frame) {
  double wait = 0, drip = 0;
  {
    const std::scoped_lock lock(mutex_);
    ++answers_;
    disturb(frame);
    if (active(FaultKind::silent) != nullptr) {
      ++fault_answers_;
      return;
    }
    if (const Waiting* slow = active(FaultKind::slow)) wait += value_or(slow->fault, 0.2);
    if (Waiting* late = active(FaultKind::late)) {
      wait += value_or(late->fault, 0.2);
      late->over = true;
    }
    if (const Waiting* dribble = active(FaultKind::dribble)) drip = value_or(dribble->fault, 0.04);
    if (wait > 0 || drip > 0) ++fault_answers_;
  }
  if (wait > 0) pause(wait);
  const std::size_t piece = drip > 0 ? 1 : frame.size();
  for (std::size_t i = 0; i < frame.size() && !stop_; i += piece) {
    if (i > 0) pause(drip);
    const ssize_t sent =
        options_.serial ? ::write(file, frame.data() + i, piece) : ::send(file, frame.data() + i, piece, MSG_NOSIGNAL);
    if (sent < 0) return;
  }
}

}  // namespace tactor::modbus
