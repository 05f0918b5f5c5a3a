#include "devices/hardware/guarded_line.hpp"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <new>
#include <string_view>
#include <utility>

#include "framework/core/installation.hpp"

namespace tactor {

namespace {

constexpr Duration guard_goodbye{10'000'000'000};  // then it is left to end by itself
constexpr Duration look_for_its_end{1'000'000};
constexpr int above_the_guards = 10;  // descriptors that are handed on are not where they go

[[noreturn]] void refuse(const char* what) {
  throw RunError(std::string("tactor-guard: ") + what + ": " + std::strerror(errno));
}

FileDescriptor sealable(const char* name) {
  FileDescriptor file(memfd_create(name, MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!file) refuse("no shared memory");
  return file;
}

void seal(const FileDescriptor& file, int seals) {
  if (fcntl(file.number(), F_ADD_SEALS, seals | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0) {
    refuse("shared memory cannot be sealed");
  }
}

FileDescriptor shared_file() {
  FileDescriptor file = sealable("tactor-guard");
  if (ftruncate(file.number(), sizeof(GuardShare)) != 0) refuse("no room for shared memory");
  seal(file, 0);
  return file;
}

GuardShare* map_and_make(const FileDescriptor& file) {
  void* memory = mmap(nullptr, sizeof(GuardShare), PROT_READ | PROT_WRITE, MAP_SHARED, file.number(), 0);
  if (memory == MAP_FAILED) refuse("shared memory cannot be mapped");
  return new (memory) GuardShare;
}

/// The descriptors and the surroundings of a guard's process.
class Surroundings {
 public:
  /// `flight` may be none.
  Surroundings(const FileDescriptor& config, const FileDescriptor& share, const FileDescriptor& engine,
               const FileDescriptor& flight) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions_, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions_, config.number(), guard_config_file);
    posix_spawn_file_actions_adddup2(&actions_, share.number(), guard_share_file);
    posix_spawn_file_actions_adddup2(&actions_, engine.number(), guard_engine_file);
    if (flight) posix_spawn_file_actions_adddup2(&actions_, flight.number(), guard_flight_file);
    posix_spawn_file_actions_addclosefrom_np(&actions_, (flight ? guard_flight_file : guard_engine_file) + 1);
    posix_spawnattr_init(&attributes_);
    sigset_t all{}, none{};
    sigfillset(&all);
    sigemptyset(&none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK);
  }
  ~Surroundings() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }
  Surroundings(const Surroundings&) = delete;
  Surroundings& operator=(const Surroundings&) = delete;
  [[nodiscard]] const posix_spawn_file_actions_t* actions() const { return &actions_; }
  [[nodiscard]] const posix_spawnattr_t* attributes() const { return &attributes_; }

 private:
  posix_spawn_file_actions_t actions_{};
  posix_spawnattr_t attributes_{};
};

FileDescriptor moved_up(const FileDescriptor& file) {
  FileDescriptor moved(fcntl(file.number(), F_DUPFD_CLOEXEC, above_the_guards));
  if (!moved) refuse("no descriptor");
  return moved;
}

/// The file of a ring anew, without the lock by which others see that this process lives; none for -1, or where that is
/// not granted, which the guard tells.
FileDescriptor opened_again(int file) {
  if (file < 0) return {};
  const std::string name = "/proc/self/fd/" + std::to_string(file);
  const FileDescriptor opened(open(name.c_str(), O_RDWR | O_CLOEXEC));
  return opened ? moved_up(opened) : FileDescriptor();
}

GuardConfig with_flight(GuardConfig config, const FlightWriter& flight) {
  if (!flight || flight.ring->file() < 0) return config;
  config.flight = flight.ring->place();
  config.flight_node = flight.node;
  return config;
}

}  // namespace

void GuardedLine::Unmap::operator()(GuardShare* share) const {
  munmap(share, sizeof *share);
}

GuardedLine::GuardedLine(std::unique_ptr<Link> link, GuardConfig config, const FlightWriter& flight)
    : link_(std::move(link)),
      config_(with_flight(std::move(config), flight)),
      name_(link_->name()),
      flight_file_(flight ? flight.ring->file() : -1),
      file_(shared_file()),
      share_(map_and_make(file_)),
      orders_(share_->orders),
      reports_(share_->reports) {}

GuardedLine::~GuardedLine() {
  stop();
}

void GuardedLine::start() {
  TACTOR_DEMAND(process_ == 0);
  const std::string program = (installation_prefix() / "bin" / "tactor-guard").string();
  if (access(program.c_str(), X_OK) != 0) {
    throw InputError("guard: expected the program " + program + ", which takes the force to zero if this one dies, " +
                     "found none that can be started (" + std::strerror(errno) +
                     "); install or build tactor-guard, or say guard: off if the device's own watchdog is enough");
  }
  const std::string bytes = to_bytes(config_);
  const FileDescriptor config = sealable("tactor-guard-config");
  if (!config.write_all(bytes.data(), bytes.size())) refuse("its configuration cannot be written");
  seal(config, F_SEAL_WRITE);
  // The guard sees by it when this process ends, however that comes.
  const FileDescriptor engine(static_cast<int>(syscall(SYS_pidfd_open, getpid(), 0)));
  if (!engine) refuse("this process cannot be watched");
  const FileDescriptor handed[] = {moved_up(config), moved_up(file_), moved_up(engine), opened_again(flight_file_)};
  const Surroundings surroundings(handed[0], handed[1], handed[2], handed[3]);
  std::string path = program, owner = std::to_string(getpid());
  char* const words[] = {path.data(), owner.data(), nullptr};
  const int error =
      posix_spawn(&process_, path.c_str(), surroundings.actions(), surroundings.attributes(), words, environ);
  if (error == 0) return;
  process_ = 0;
  throw RunError("tactor-guard: " + program + " does not start: " + std::strerror(error));
}

void GuardedLine::stop() {
  if (process_ == 0) return;
  kill(process_, SIGTERM);
  const Instant give_up = MonotonicClock::now() + guard_goodbye;
  int status = 0;
  for (;;) {
    const pid_t ended = waitpid(process_, &status, WNOHANG);
    if (ended == process_ || (ended < 0 && errno != EINTR)) break;
    if (MonotonicClock::now() > give_up) {
      // It may be in the middle of a homing or a shutdown, or stopped: it ends by itself, with the force at zero.
      kill(process_, SIGCONT);
      break;
    }
    MonotonicClock::sleep_until(MonotonicClock::now() + look_for_its_end);
  }
  process_ = 0;
}

bool GuardedLine::newest(LinkReport& report) noexcept {
  if (reports_.take(report) != SlotFound::value) return false;
  report.text.back() = '\0';
  epoch_ = report.cuts;
  text_ = report.text;
  return true;
}

void GuardedLine::command(Instant now, const LinkCommand& command) noexcept {
  if (command.is_zero()) zeroed_ = now;
  orders_.put({command, now, now + config_.expires_after, zeroed_, epoch_});
}

std::vector<std::string> GuardedLine::refused() const {
  std::vector<std::string> lines;
  const std::size_t size =
      std::min<std::size_t>(share_->words.size.load(std::memory_order_acquire), share_->words.text.size());
  std::string_view text(share_->words.text.data(), size);
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

}  // namespace tactor
