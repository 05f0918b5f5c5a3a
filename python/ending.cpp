#include "python/ending.hpp"

#include <atomic>
#include <chrono>
#include <thread>

#include "python/interpreter_lock.hpp"

namespace tactor::python {

namespace {

std::atomic<bool> program_ends = false;
std::atomic<std::thread::id> last_thread;
std::atomic<int> live_work = 0, other_work = 0;

}  // namespace

bool is_ending() {
  return program_ends && std::this_thread::get_id() != last_thread.load();
}

Work::Work(bool live) : live_(live) {
  std::atomic<int>& count = live_ ? live_work : other_work;
  ++count;
  if (!is_ending()) return;
  --count;
  park();
}

Work::~Work() {
  --(live_ ? live_work : other_work);
  if (is_ending()) park();
}

void end_work() {
  using std::chrono::steady_clock;
  constexpr std::chrono::milliseconds period{5};
  constexpr std::chrono::seconds longest{10};
  last_thread = std::this_thread::get_id();
  program_ends = true;
  const LockReleased released;
  while (live_work > 0) std::this_thread::sleep_for(period);
  const auto until = steady_clock::now() + longest;
  while (other_work > 0 && steady_clock::now() < until) std::this_thread::sleep_for(period);
}

void forget_work() {
  live_work = other_work = 0;
}

}  // namespace tactor::python
