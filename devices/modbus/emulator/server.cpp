#include "devices/modbus/emulator/server.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "devices/modbus/cycle_plan.hpp"
#include "framework/core/check.hpp"
#include "framework/realtime/thread_policy.hpp"

namespace tactor::modbus {

namespace {

constexpr int poll_ms = 5;
constexpr std::size_t most_clients = 32;
constexpr Duration move_period{500'000};
constexpr int moves_a_log_line = 4;
constexpr Duration accept_again{100'000'000};  // after an attempt that the system refused
constexpr Duration longest_gap{100'000'000};   // within a request on a serial line
// A device keeps its time whatever else the computer does; below the loops that are tried on it. Refused, it does
// without.
const ThreadSettings punctual{SchedulingPolicy::fifo, 40, std::nullopt};

[[noreturn]] void fail(const std::string& what) {
  throw RunError("the emulator: " + what + ": " + std::strerror(errno));
}

void never_block(int file) {
  if (fcntl(file, F_SETFL, fcntl(file, F_GETFL) | O_NONBLOCK) != 0) fail("cannot set up a file");
}

/// What `link` points to; empty where it is no symbolic link.
std::string target_of(const std::string& link) {
  std::error_code none;
  return std::filesystem::read_symlink(link, none).string();
}

}  // namespace

Emulator::Emulator(Profile profile, EmulatorOptions options)
    : options_(std::move(options)), device_(std::move(profile)), faults_(options_.faults, options_.serial) {
  if (!options_.log.empty()) {
    log_.open(options_.log);
    if (!log_) fail("cannot write " + options_.log);
  }
  options_.serial ? open_pty() : open_tcp();
}

Emulator::~Emulator() {
  stop();
  if (options_.serial) close_pty();
  if (kept_open_ >= 0) close(kept_open_);
  for (const Client& client : clients_) close(client.file);
  if (listen_ >= 0) close(listen_);
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
  never_block(listen_);
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
  never_block(terminal_);
  if (address_.empty()) address_ = std::string("rtu:") + (options_.link.empty() ? name : options_.link);
  clients_.push_back({terminal_, {}, {}});
  if (options_.link.empty()) return;
  // Only what such a program has made is replaced.
  std::error_code none;
  const std::filesystem::file_status there = std::filesystem::symlink_status(options_.link, none);
  if (std::filesystem::exists(there) && !std::filesystem::is_symlink(there)) {
    throw InputError("--link " + options_.link + ": expected a name that is free, or a symbolic link, found " +
                     (std::filesystem::is_directory(there) ? "a folder" : "a file") + "; choose another name");
  }
  if (std::filesystem::is_symlink(there)) unlink(options_.link.c_str());
  if (symlink(name, options_.link.c_str()) != 0) fail("--link " + options_.link + ": cannot make it");
  linked_ = name;
}

void Emulator::close_pty() {
  if (terminal_ < 0) return;
  // Somebody else may have put something there since.
  if (!linked_.empty() && target_of(options_.link) == linked_) unlink(options_.link.c_str());
  linked_.clear();
  std::erase_if(clients_, [this](const Client& client) { return client.file == terminal_; });
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
    pulled = faults_.active(FaultKind::unplug) != nullptr;
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
  faults_.add(fault);
  faults_.begin_due(device_);
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
    faults_.begin_due(device_);
    faults_.end_due(device_);
    if (!log_.is_open() || k % moves_a_log_line != 0) continue;
    const EmulatedState s = device_.state();
    // Flushed, because who ends this program does not always let it end.
    log_ << (origin_ + (s.time - Time{})).ns << ' ' << s.position << ' ' << s.force << ' ' << s.commanded << ' '
         << s.expired << ' ' << s.commands << ' ' << s.given << '\n'
         << std::flush;
  }
}

void Emulator::end_all_faults() {
  const std::scoped_lock lock(mutex_);
  faults_.end_all(device_);
}

void Emulator::serve() {
  apply_thread_settings(punctual, "emulated-line");
  while (!stop_) {
    bool drops = false;
    {
      const std::scoped_lock lock(mutex_);
      drops = faults_.take_drop();
    }
    if (drops && !options_.serial) {
      while (!clients_.empty()) drop(clients_.back().file);
    }
    pull_or_plug();
    std::vector<pollfd> files;
    if (listen_ >= 0 && MonotonicClock::now() >= accept_from_) files.push_back({listen_, POLLIN, 0});
    for (const Client& client : clients_) files.push_back({client.file, POLLIN, 0});
    const int ready = poll(files.data(), files.size(), poll_ms);
    if (ready < 0 && errno != EINTR) pause(poll_ms * 1e-3);
    if (ready <= 0) continue;
    for (const pollfd& file : files) {
      if (file.revents == 0) continue;
      file.fd == listen_ ? accept_client() : hear(file.fd);
    }
  }
}

void Emulator::accept_client() {
  const int file = accept4(listen_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (file < 0) {
    // Out of descriptors, for one: whoever waits goes on waiting, which must not keep this thread busy.
    if (errno == EAGAIN || errno == EINTR || errno == ECONNABORTED) return;
    if (accept_from_.ns == 0) {
      std::fprintf(stderr, "the emulator: cannot take a connection: %s; it tries again until it can\n",
                   std::strerror(errno));
    }
    accept_from_ = MonotonicClock::now() + accept_again;
    return;
  }
  const int on = 1;
  setsockopt(file, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  if (clients_.size() >= most_clients) {
    // Whoever says nothing gives way: those that never said anything first, in the order in which they came.
    drop(std::min_element(clients_.begin(), clients_.end(), [](const Client& a, const Client& b) {
           return a.heard < b.heard;
         })->file);
  }
  clients_.push_back({file, {}, {}});
  ++connections_;
}

void Emulator::drop(int file) {
  // Reset rather than ended, as by a device that lost its power.
  const linger now{1, 0};
  setsockopt(file, SOL_SOCKET, SO_LINGER, &now, sizeof now);
  close(file);
  std::erase_if(clients_, [file](const Client& client) { return client.file == file; });
}

Emulator::Client* Emulator::client_of(int file) {
  const auto found =
      std::find_if(clients_.begin(), clients_.end(), [file](const Client& client) { return client.file == file; });
  return found == clients_.end() ? nullptr : &*found;
}

void Emulator::hear(int file) {
  Client* client = client_of(file);
  if (client == nullptr) return;
  std::array<std::uint8_t, 512> bytes{};
  const ssize_t n = read(file, bytes.data(), bytes.size());
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (n <= 0) {
    // A terminal stays, also when nobody has it open.
    options_.serial ? pause(0.01) : drop(file);
    return;
  }
  const Instant now = MonotonicClock::now();
  // Bytes of a serial line that come after a pause begin another request.
  if (options_.serial && now - client->heard > longest_gap) client->pending.clear();
  client->heard = now;
  client->pending.insert(client->pending.end(), bytes.begin(), bytes.begin() + n);
  while (!stop_ && client != nullptr) {
    TakenRequest taken = take_request(client->pending, options_.serial);
    if (taken.kind == TakenRequest::Kind::incomplete) return;
    if (taken.kind == TakenRequest::Kind::broken) {
      client->pending.clear();
      if (!options_.serial) drop(file);
      return;
    }
    client->pending.erase(client->pending.begin(), client->pending.begin() + static_cast<std::ptrdiff_t>(taken.length));
    const bool meant = !options_.serial || taken.request.unit == device_.profile().line.unit;
    if (taken.kind == TakenRequest::Kind::whole && meant) answer(file, taken.request);
    client = client_of(file);
  }
}

void Emulator::answer(int file, const Request& request) {
  std::vector<std::uint8_t> frame;
  {
    const std::scoped_lock lock(mutex_);
    faults_.asked();
    device_.asked();
  }
  if (options_.serial && options_.line_delay) {
    const LineSettings& line = device_.profile().line;
    // The silence after the answer is the client's to keep.
    pause(seconds_of(request.what, line, true) - line.silent().seconds());
  }
  {
    const std::scoped_lock lock(mutex_);
    device_.advance(Time{} + (MonotonicClock::now() - origin_));
    if (faults_.active(FaultKind::exception) != nullptr) {
      constexpr int device_failure = 4;
      ++fault_answers_;
      frame = exception_frame(request, options_.serial, device_failure);
    } else {
      if (request.exception == 0 && request.what.write_count > 0) ++writes_;
      frame = answer_request(request, options_.serial, device_);
    }
  }
  send(file, std::move(frame));
}

void Emulator::send(int file, std::vector<std::uint8_t> frame) {
  double wait = 0, drip = 0;
  {
    const std::scoped_lock lock(mutex_);
    ++answers_;
    fault_answers_ += faults_.disturb(frame);
    if (faults_.active(FaultKind::silent) != nullptr) {
      ++fault_answers_;
      return;
    }
    if (const Fault* slow = faults_.active(FaultKind::slow)) wait += slow->value_or(0.2);
    if (const Fault* late = faults_.take(FaultKind::late)) wait += late->value_or(0.2);
    if (const Fault* dribble = faults_.active(FaultKind::dribble)) drip = dribble->value_or(0.04);
    if (wait > 0 || drip > 0) ++fault_answers_;
  }
  if (wait > 0) pause(wait);
  const std::size_t piece = drip > 0 ? 1 : frame.size();
  for (std::size_t i = 0; i < frame.size() && !stop_; i += piece) {
    if (i > 0) pause(drip);
    const ssize_t sent =
        options_.serial ? ::write(file, frame.data() + i, piece) : ::send(file, frame.data() + i, piece, MSG_NOSIGNAL);
    if (sent == static_cast<ssize_t>(piece)) continue;
    // Nobody reads. A serial line loses what it has no room for; over TCP the rest of an answer would be taken for the
    // next one.
    if (!options_.serial) drop(file);
    return;
  }
}

}  // namespace tactor::modbus
