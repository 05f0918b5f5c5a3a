// tactor-guard: drives the line of one device for an engine, and takes the force to zero where the engine dies, stops
// or asks for it. Started by GuardedLine, with descriptors of its configuration,
// the shared memory, the engine and the file of its flight recorder.
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/signalfd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "devices/guard/engine_slots.hpp"
#include "devices/guard/guard_policy.hpp"
#include "devices/guard/lines.hpp"
#include "devices/hardware/guard_share.hpp"
#include "devices/hardware/link_runner.hpp"
#include "framework/core/check.hpp"
#include "framework/core/shown_text.hpp"
#include "framework/realtime/memory_lock.hpp"

namespace tactor {

namespace {

constexpr Duration longest_end{5'000'000'000};  // of a line that does not answer, and is opened anew meanwhile
constexpr Duration look_for_rest{500'000};

/// The size of a file whose size, and with `seals` whose content too, nobody can change. Throws RunError for others.
std::size_t sealed_size(int file, int seals) {
  const int found = fcntl(file, F_GET_SEALS);
  struct stat status {};
  if (found < 0 || (found & seals) != seals || fstat(file, &status) != 0 || status.st_size <= 0) {
    throw RunError("its memory is not there or not sealed; the engine of a run starts it, and nobody else");
  }
  return static_cast<std::size_t>(status.st_size);
}

GuardConfig read_config() {
  std::string bytes(sealed_size(guard_config_file, F_SEAL_WRITE | F_SEAL_SHRINK), '\0');
  // From its begin, wherever the engine has left it.
  if (pread(guard_config_file, bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw RunError("its configuration cannot be read");
  }
  auto config = from_bytes<GuardConfig>(bytes);
  if (config.layout != guard_layout) throw RunError("it is of another build than the engine; install both together");
  return config;
}

GuardShare& map_share() {
  const std::size_t size = sealed_size(guard_share_file, F_SEAL_SHRINK | F_SEAL_GROW);
  if (size != sizeof(GuardShare)) throw RunError("it is of another build than the engine; install both together");
  void* memory = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, guard_share_file, 0);
  if (memory == MAP_FAILED) throw RunError(std::string("its memory cannot be mapped: ") + std::strerror(errno));
  return *static_cast<GuardShare*>(memory);
}

void tell(GuardWords& words, const std::vector<std::string>& lines) {
  std::size_t size = 0;
  for (const std::string& line : lines) {
    const std::size_t part = std::min(line.size(), words.text.size() - size);
    std::memcpy(words.text.data() + size, line.data(), part);
    size += part;
    if (size < words.text.size()) words.text[size++] = '\n';
  }
  words.size.store(static_cast<std::uint32_t>(size), std::memory_order_release);
}

/// Signals that others send mean that the guard is to end, with the force at zero. Left out are those that nobody can
/// catch, those of a crash, and those that mean nothing here.
int signals_to_end() {
  for (const int one : {SIGPIPE, SIGXFSZ, SIGTTIN, SIGTTOU}) signal(one, SIG_IGN);
  sigset_t set{};
  sigfillset(&set);
  for (const int one : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP, SIGSYS, SIGCHLD, SIGCONT, SIGURG, SIGWINCH,
                        SIGPIPE, SIGXFSZ, SIGTTIN, SIGTTOU}) {
    sigdelset(&set, one);
  }
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  const int file = signalfd(-1, &set, SFD_CLOEXEC);
  if (file < 0) throw RunError(std::string("no signals: ") + std::strerror(errno));
  return file;
}

/// Where the flight file lies; the handler of SIGBUS reads it.
std::span<std::byte> flight_memory;

/// The user may shorten the flight file while it is mapped. Then memory of the guard's own takes its place: the line
/// goes on, and what it does is told no more.
void replace_flight(int number, siginfo_t* info, void* /*context*/) {
  auto* const at = static_cast<std::byte*>(info->si_addr);
  const bool is_flight = at >= flight_memory.data() && at < flight_memory.data() + flight_memory.size();
  constexpr int own = MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED;
  if (is_flight && mmap(flight_memory.data(), flight_memory.size(), PROT_READ | PROT_WRITE, own, -1, 0) != MAP_FAILED) {
    return;
  }
  signal(number, SIG_DFL);  // and comes again
}

/// The engine's flight recorder, to which the guard goes on to write where the engine has gone; none where the engine
/// has none. It waits for no page later.
std::optional<FlightRing> map_flight(const GuardConfig& config) {
  if (config.flight.capacity == 0) return std::nullopt;
  struct stat status {};
  if (fstat(guard_flight_file, &status) != 0 || status.st_size <= 0) throw RunError("its file is not there");
  const auto size = static_cast<std::size_t>(status.st_size);
  void* memory = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, guard_flight_file, 0);
  if (memory == MAP_FAILED) throw RunError(std::string("its file cannot be mapped: ") + std::strerror(errno));
  flight_memory = {static_cast<std::byte*>(memory), size};
  struct sigaction action {};
  action.sa_sigaction = replace_flight;
  action.sa_flags = SA_SIGINFO;
  sigaction(SIGBUS, &action, nullptr);
  return FlightRing(flight_memory, config.flight);
}

/// The same. Why the line of an engine that has a recorder cannot be told to it goes to `refused`, in words.
std::optional<FlightRing> find_flight(const GuardConfig& config, std::string& refused) {
  try {
    return map_flight(config);
  } catch (const std::exception& error) {
    refused = std::string("tactor-guard: the flight recorder has no cycles of the line: ") + error.what();
    return std::nullopt;
  }
}

LinkRunnerSettings settings_of(const GuardConfig& config, GuardShare& share, EngineSlots& slots,
                               const MemoryLock& memory, std::optional<FlightRing>& flight,
                               const std::string& flight_refused) {
  LinkRunnerSettings settings;
  settings.rate = config.rate;
  settings.commands = {config.age_max, config.expires_after, config.let_go};
  settings.energy = config.energy;
  settings.thread_name = config.thread_name;
  settings.guarding = {&slots, &share.board, config.gate};
  if (flight) settings.flight = {&*flight, static_cast<std::size_t>(config.flight_node)};
  settings.begin = [&share, &memory, flight_refused, period = Duration::from_rate(config.rate),
                    name = config.thread_name] {
    std::vector<std::string> lines = take_guard_policy(period, name);
    if (memory.refused()) lines.push_back("tactor-guard: " + describe(*memory.refused()));
    if (!flight_refused.empty()) lines.push_back(flight_refused);
    tell(share.words, lines);
    return lines;
  };
  return settings;
}

/// Until a signal comes or the engine has gone.
void wait_for_the_end(int signals) {
  pollfd watched[] = {{signals, POLLIN, 0}, {guard_engine_file, POLLIN, 0}};
  while (poll(watched, std::size(watched), -1) < 0 && errno == EINTR) continue;
}

int guard() {
  GuardShare* share = nullptr;
  try {
    const GuardConfig config = read_config();
    share = &map_share();
    const int signals = signals_to_end();
    const MemoryLock memory;
    std::string flight_refused;
    std::optional<FlightRing> flight = find_flight(config, flight_refused);
    EngineSlots slots(*share, config.expires_after);
    LinkRunner runner(make_link(config.line, config.link), config.limits,
                      settings_of(config, *share, slots, memory, flight, flight_refused));
    runner.start();
    wait_for_the_end(signals);
    slots.refuse_all();
    const Instant give_up = MonotonicClock::now() + longest_end;
    while (!slots.at_rest() && MonotonicClock::now() < give_up) {
      MonotonicClock::sleep_until(MonotonicClock::now() + look_for_rest);
    }
    runner.stop();
    return 0;
  } catch (const std::exception& error) {
    if (share != nullptr) tell(share->words, {std::string("tactor-guard: ") + error.what()});
    std::fprintf(stderr, "tactor-guard: %s\n", error.what());
    return 1;
  }
}

}  // namespace

}  // namespace tactor

int main(int argc, char** argv) {
  tactor::show_only_text();
  if (argc > 1 && std::string_view(argv[1]) == "--help") {
    std::puts("tactor-guard: a run starts it, and nobody else; `guard` of a device says when");
    return 0;
  }
  return tactor::guard();
}
