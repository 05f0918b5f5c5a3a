#include "app/study/run/crash_board.hpp"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <new>

#include "app/run/cpu_time.hpp"
#include "framework/core/check.hpp"

namespace tactor {

namespace {

using Word = std::atomic<std::uint64_t>;
constexpr double never = std::numeric_limits<double>::infinity();
static_assert(Word::is_always_lock_free && std::atomic<double>::is_always_lock_free,
              "a lock would not work between processes, nor in a signal");

/// Never 0, which stands for none.
std::uint64_t to_word(RunPlace place) {
  return 1 + 4 * static_cast<std::uint64_t>(place.number) + static_cast<std::uint64_t>(place.stage);
}

RunPlace to_place(std::uint64_t word) {
  return {static_cast<RunStage>((word - 1) % 4), static_cast<std::size_t>((word - 1) / 4)};
}

}  // namespace

/// One thread.
struct CrashBoard::Slot {
  Word place = 0;
  std::atomic<double> since = never;  // s, of the monotonic clock
};

struct CrashBoard::Shared {
  Word rows = 0;
  std::atomic<double> timeout = never;  // s
  Word has_table = 0;
  Word trial = 0;    // run + 1
  Word signal = 0;   // that the process brought upon itself
  Word culprit = 0;  // the place where it did
  // Behind it the slots.
};

namespace {

constexpr std::array<int, 5> signals{SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};

// Read by the handler, of which the process has one.
constinit thread_local Word* my_slot = nullptr;
Word* told_signal = nullptr;
Word* told_culprit = nullptr;
std::array<struct sigaction, signals.size()> before;

void on_crash(int signal, siginfo_t* info, void*) {
  const bool sent_by_another = info->si_code <= 0 && info->si_pid != getpid();
  std::uint64_t none = 0;
  if (my_slot != nullptr && !sent_by_another && told_culprit->compare_exchange_strong(none, my_slot->load())) {
    told_signal->store(static_cast<std::uint64_t>(signal));
  }
  for (std::size_t i = 0; i < signals.size(); ++i) {
    if (signals[i] == signal) sigaction(signal, &before[i], nullptr);
  }
  raise(signal);  // it comes when this function has returned
}

}  // namespace

std::string signal_word(int signal) {
  const char* name = sigabbrev_np(signal);
  return name != nullptr ? fmt::format("SIG{}", name) : fmt::format("signal {}", signal);
}

CrashBoard::CrashBoard(unsigned threads) : size_(sizeof(Shared) + threads * sizeof(Slot)) {
  void* memory = mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw RunError(fmt::format("no memory to share: {}", std::strerror(errno)));
  shared_ = new (memory) Shared;
  auto* const first = reinterpret_cast<Slot*>(shared_ + 1);
  for (unsigned t = 0; t < threads; ++t) new (first + t) Slot;
  slots_ = {first, threads};
}

CrashBoard::~CrashBoard() {
  munmap(shared_, size_);
}

void CrashBoard::begin() {
  for (Word* word : {&shared_->trial, &shared_->signal, &shared_->culprit}) *word = 0;
  for (Slot& slot : slots_) {
    slot.since = never;
    slot.place = 0;
  }
}

std::vector<RunPlace> CrashBoard::places() const {
  if (shared_->culprit != 0) return {to_place(shared_->culprit)};
  std::vector<RunPlace> places;
  for (const Slot& slot : slots_) {
    if (const std::uint64_t word = slot.place; word != 0) places.push_back(to_place(word));
  }
  return places;
}

std::optional<RunPlace> CrashBoard::overdue(double not_before) const {
  const double now = clock_seconds(CLOCK_MONOTONIC);
  for (const Slot& slot : slots_) {
    const std::uint64_t word = slot.place;
    if (word != 0 && now - std::max<double>(slot.since, not_before) > shared_->timeout) return to_place(word);
  }
  return std::nullopt;
}

void CrashBoard::set_timeout(double seconds) {
  shared_->timeout = seconds;
}

double CrashBoard::timeout() const {
  return shared_->timeout;
}

int CrashBoard::signal() const {
  return static_cast<int>(shared_->signal);
}

void CrashBoard::set_trial(std::optional<std::size_t> run) {
  shared_->trial = run ? *run + 1 : 0;
}

std::optional<std::size_t> CrashBoard::trial() const {
  const std::uint64_t word = shared_->trial;
  return word == 0 ? std::nullopt : std::optional<std::size_t>(word - 1);
}

void CrashBoard::count_row() {
  ++shared_->rows;
}

std::size_t CrashBoard::rows() const {
  return shared_->rows;
}

void CrashBoard::set_has_table() {
  shared_->has_table = 1;
}

bool CrashBoard::has_table() const {
  return shared_->has_table != 0;
}

CrashPlace::CrashPlace(CrashBoard* board, RunPlace place) {
  if (board == nullptr) return;
  for (CrashBoard::Slot& slot : board->slots_) {
    std::uint64_t none = 0;
    if (!slot.place.compare_exchange_strong(none, to_word(place))) continue;
    slot_ = &slot;
    break;
  }
  TACTOR_DEMAND(slot_ != nullptr);
  my_slot = &slot_->place;
  if (place.stage != RunStage::planning) begin();
}

void CrashPlace::begin() {
  if (slot_ != nullptr) slot_->since = clock_seconds(CLOCK_MONOTONIC);
}

void CrashPlace::end() {
  if (slot_ != nullptr) slot_->since = never;
}

CrashPlace::~CrashPlace() {
  if (slot_ == nullptr) return;
  my_slot = nullptr;
  // A thread that got over its signal has not ended the process.
  std::uint64_t mine = slot_->place;
  if (told_culprit != nullptr && told_culprit->compare_exchange_strong(mine, 0)) told_signal->store(0);
  slot_->since = never;
  slot_->place = 0;
}

CrashSignals::CrashSignals(CrashBoard* board) {
  TACTOR_DEMAND(told_culprit == nullptr);
  if (board == nullptr) return;
  told_signal = &board->shared_->signal;
  told_culprit = &board->shared_->culprit;
  struct sigaction action {};
  action.sa_sigaction = on_crash;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < signals.size(); ++i) sigaction(signals[i], &action, &before[i]);
}

CrashSignals::~CrashSignals() {
  if (told_culprit == nullptr) return;
  for (std::size_t i = 0; i < signals.size(); ++i) sigaction(signals[i], &before[i], nullptr);
  told_signal = nullptr;
  told_culprit = nullptr;
}

CrashStack::CrashStack() : memory_(std::size_t{64} << 10U) {
  const stack_t mine{.ss_sp = memory_.data(), .ss_flags = 0, .ss_size = memory_.size()};
  sigaltstack(&mine, &before_);
}

CrashStack::~CrashStack() {
  sigaltstack(&before_, nullptr);
}

}  // namespace tactor
