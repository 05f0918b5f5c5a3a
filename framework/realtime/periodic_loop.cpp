// The thread behind a periodic loop: its stack, its start and its end.
#include "framework/realtime/periodic_loop.hpp"

#include <dlfcn.h>
#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>
#include <utility>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

/// What the C library takes of a thread's stack for itself: thread-local storage, which a sanitizer makes large.
std::size_t taken_of_stack() {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  // Not in its headers; the runtime of Rust asks in the same way.
  const auto ask =
      reinterpret_cast<std::size_t (*)(const pthread_attr_t*)>(dlsym(RTLD_DEFAULT, "__pthread_get_minstack"));
  const std::size_t taken = ask != nullptr ? ask(&attributes) : PTHREAD_STACK_MIN;
  pthread_attr_destroy(&attributes);
  return taken;
}

/// A stack whose pages are all there before anything runs on it, above a page that nothing may touch.
class Stack {
 public:
  explicit Stack(std::size_t size) {
    const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    const std::size_t rounded = size + taken_of_stack() + page - 1;
    bytes_ = rounded / page * page + page;
    address_ =
        mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_STACK | MAP_POPULATE, -1, 0);
    if (address_ == MAP_FAILED) throw RunError(std::string("cannot make a stack: ") + std::strerror(errno));
    mprotect(address_, page, PROT_NONE);
    base_ = static_cast<std::byte*>(address_) + page;
    size_ = bytes_ - page;
  }
  ~Stack() {
    if (!left_behind_) munmap(address_, bytes_);
  }
  Stack(const Stack&) = delete;
  Stack& operator=(const Stack&) = delete;

  [[nodiscard]] void* base() const { return base_; }
  [[nodiscard]] std::size_t size() const { return size_; }
  /// Never gives the pages back: a thread still runs on them.
  void leave_behind() { left_behind_ = true; }

 private:
  void* address_ = nullptr;
  std::size_t bytes_ = 0;
  void* base_ = nullptr;
  std::size_t size_ = 0;
  bool left_behind_ = false;
};

enum class Phase : std::uint8_t { idle, starting, running, ended };

}  // namespace

struct PeriodicLoop::Shared {
  Shared(const LoopSettings& s, Body b) : settings(s), schedule(s.rate), body(std::move(b)), stack(s.stack_size) {}

  void run();

  LoopSettings settings;
  TickSchedule schedule;
  Body body;
  Stack stack;
  Instant origin;
  ThreadGrant grant;
  std::exception_ptr failure;  ///< read by others after `ended` alone
  LoopFigures figures;
  pthread_t thread{};
  bool joinable = false;
  std::atomic<bool> stop{false};
  std::atomic<Phase> phase{Phase::idle};
};

void PeriodicLoop::Shared::run() {
  grant = apply_thread_settings(settings.thread, settings.name);
  phase.store(Phase::running, std::memory_order_release);
  phase.notify_all();
  MonotonicClock clock;
  try {
    run_ticks(clock, schedule, origin, settings.warm_up_ticks, stop, figures, body);
  } catch (...) {
    failure = std::current_exception();
  }
  phase.store(Phase::ended, std::memory_order_release);
}

PeriodicLoop::PeriodicLoop(const LoopSettings& settings, Body body)
    : shared_(std::make_shared<Shared>(settings, std::move(body))) {
  TACTOR_DEMAND(shared_->body != nullptr);
}

PeriodicLoop::~PeriodicLoop() {
  if (stop(Duration{1'000'000'000})) return;
  shared_->stack.leave_behind();
  pthread_detach(shared_->thread);
}

ThreadGrant PeriodicLoop::start(Instant origin) {
  TACTOR_DEMAND(shared_->phase.load() == Phase::idle);
  shared_->origin = origin;
  shared_->phase.store(Phase::starting);
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstack(&attributes, shared_->stack.base(), shared_->stack.size());
  // The thread holds a share of what it runs with, in case it has to be left behind.
  auto share = std::make_unique<std::shared_ptr<Shared>>(shared_);
  const auto begin = [](void* argument) -> void* {
    const std::unique_ptr<std::shared_ptr<Shared>> own(static_cast<std::shared_ptr<Shared>*>(argument));
    (*own)->run();
    return nullptr;
  };
  const int error = pthread_create(&shared_->thread, &attributes, begin, share.get());
  pthread_attr_destroy(&attributes);
  if (error != 0) {
    shared_->phase.store(Phase::idle);
    throw RunError("cannot start the thread " + shared_->settings.name + ": " + std::strerror(error));
  }
  share.release();
  shared_->joinable = true;
  shared_->phase.wait(Phase::starting, std::memory_order_acquire);
  return shared_->grant;
}

bool PeriodicLoop::stop(Duration patience) {
  if (!shared_->joinable) return true;
  shared_->stop.store(true, std::memory_order_release);
  const Instant limit = MonotonicClock::now() + patience;
  while (running()) {
    if (MonotonicClock::now() >= limit) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  pthread_join(shared_->thread, nullptr);
  shared_->joinable = false;
  return true;
}

bool PeriodicLoop::running() const noexcept {
  const Phase phase = shared_->phase.load(std::memory_order_acquire);
  return phase == Phase::starting || phase == Phase::running;
}

std::exception_ptr PeriodicLoop::failure() const noexcept {
  return shared_->phase.load(std::memory_order_acquire) == Phase::ended ? shared_->failure : nullptr;
}

const LoopFigures& PeriodicLoop::figures() const noexcept {
  return shared_->figures;
}

}  // namespace tactor
