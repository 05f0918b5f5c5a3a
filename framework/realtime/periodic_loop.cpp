// The thread behind a periodic loop: its stack, its start and its end.
#include "framework/realtime/periodic_loop.hpp"

#include <dlfcn.h>
#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <climits>
#include <thread>
#include <utility>

#include "framework/core/check.hpp"
#include "framework/realtime/make_thread.hpp"

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

/// Writes to every page of the calling thread's stack that is not in use, so that going deep later faults none in.
__attribute__((noinline)) void touch_stack() noexcept {
  pthread_attr_t attributes;
  if (pthread_getattr_np(pthread_self(), &attributes) != 0) return;
  void* lowest = nullptr;
  std::size_t size = 0;
  pthread_attr_getstack(&attributes, &lowest, &size);
  pthread_attr_destroy(&attributes);
  const auto page = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  auto* bytes = static_cast<volatile char*>(lowest);
  const auto frame = static_cast<std::uintptr_t>(static_cast<volatile char*>(__builtin_frame_address(0)) - bytes);
  // The pages below the one this frame is on are beyond what is in use, the red zone included.
  for (std::uintptr_t in_use = frame / page; in_use > 0; --in_use) bytes[(in_use - 1) * page] = 0;
}

enum class LoopPhase : std::uint8_t { idle, starting, running, ended };

}  // namespace

struct PeriodicLoop::Shared {
  Shared(const LoopSettings& s, Body b) : settings(s), schedule(s.rate), body(std::move(b)) {}

  void run();

  LoopSettings settings;
  TickSchedule schedule;
  Body body;
  Instant origin;
  ThreadGrant grant;
  std::exception_ptr failure;  ///< read by others after `ended` alone
  LoopStatistics metrics;
  pthread_t thread{};
  bool joinable = false;
  std::atomic<bool> stop{false};
  std::atomic<LoopPhase> phase{LoopPhase::idle};
};

void PeriodicLoop::Shared::run() {
  touch_stack();
  grant = apply_thread_settings(settings.thread, settings.name);
  phase.store(LoopPhase::running, std::memory_order_release);
  phase.notify_all();
  MonotonicClock clock;
  try {
    if (settings.pace != nullptr) {
      run_ticks_by(clock, *settings.pace, schedule, origin, settings.warm_up_ticks, stop, metrics, body);
    } else {
      run_ticks(clock, schedule, origin, settings.warm_up_ticks, stop, metrics, body);
    }
  } catch (...) {
    failure = std::current_exception();
  }
  phase.store(LoopPhase::ended, std::memory_order_release);
}

PeriodicLoop::PeriodicLoop(const LoopSettings& settings, Body body)
    : shared_(std::make_shared<Shared>(settings, std::move(body))) {
  TACTOR_DEMAND(shared_->body != nullptr);
}

PeriodicLoop::~PeriodicLoop() {
  if (stop(Duration{1'000'000'000})) return;
  pthread_detach(shared_->thread);
}

ThreadGrant PeriodicLoop::start(Instant origin) {
  TACTOR_DEMAND(shared_->phase.load() == LoopPhase::idle);
  shared_->origin = origin;
  shared_->phase.store(LoopPhase::starting);
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, shared_->settings.stack_size + taken_of_stack());
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
    shared_->phase.store(LoopPhase::idle);
    throw RunError(refused_start("thread " + shared_->settings.name, error));
  }
  static_cast<void>(share.release());
  shared_->joinable = true;
  shared_->phase.wait(LoopPhase::starting, std::memory_order_acquire);
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
  const LoopPhase phase = shared_->phase.load(std::memory_order_acquire);
  return phase == LoopPhase::starting || phase == LoopPhase::running;
}

std::exception_ptr PeriodicLoop::failure() const noexcept {
  return shared_->phase.load(std::memory_order_acquire) == LoopPhase::ended ? shared_->failure : nullptr;
}

const LoopStatistics& PeriodicLoop::metrics() const noexcept {
  return shared_->metrics;
}

}  // namespace tactor
