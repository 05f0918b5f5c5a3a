#include "framework/realtime/crash_note.hpp"

#include <array>
#include <atomic>
#include <csignal>
#include <mutex>

namespace tactor {

namespace {

struct CrashSignal {
  int number;
  const char* name;
};
constexpr std::array<CrashSignal, 5> crash_signals{
    {{SIGSEGV, "SIGSEGV"}, {SIGBUS, "SIGBUS"}, {SIGILL, "SIGILL"}, {SIGFPE, "SIGFPE"}, {SIGABRT, "SIGABRT"}}};

// Read by the handler.
std::array<std::atomic<FlightRing*>, 8> crash_rings{};
std::array<struct sigaction, crash_signals.size()> handlers_before{};
// Initial-exec, because storage that is made at first use would be allocated in the handler.
__attribute__((tls_model("initial-exec"))) thread_local std::size_t stepping_node = FlightRecord::no_node;

std::mutex crash_mutex;  // of what follows; the handler never takes it
int crash_notes = 0;

/// Gives a signal that another process sent to the handler from before; false where there is none. Such a signal is no
/// crash: it may ask a run to end.
bool hand_on(int number, siginfo_t* info, void* context, const struct sigaction& before) {
  if (info->si_code != SI_USER && info->si_code != SI_QUEUE) return false;
  if ((before.sa_flags & SA_SIGINFO) != 0) {
    before.sa_sigaction(number, info, context);
    return true;
  }
  if (before.sa_handler == SIG_DFL) return false;
  if (before.sa_handler != SIG_IGN) before.sa_handler(number);
  return true;
}

void note_crash(int number, siginfo_t* info, void* context) {
  std::size_t which = 0;
  while (which + 1 < crash_signals.size() && crash_signals[which].number != number) ++which;
  if (hand_on(number, info, context, handlers_before[which])) return;
  const Instant now = MonotonicClock::now();
  for (const std::atomic<FlightRing*>& one : crash_rings) {
    FlightRing* const ring = one.load(std::memory_order_acquire);
    if (ring == nullptr) continue;
    ring->tell(FlightEvent::crashed, stepping_node, now, crash_signals[which].name);
    ring->note_fault();
  }
  sigaction(number, &handlers_before[which], nullptr);
  // A fault comes again as the instruction is tried again; a signal of abort or kill does not.
  if (info->si_code <= 0) static_cast<void>(raise(number));
}

void take_crash_signals() {
  struct sigaction action {};
  action.sa_sigaction = note_crash;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK | SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < crash_signals.size(); ++i) {
    sigaction(crash_signals[i].number, &action, &handlers_before[i]);
  }
}

/// Gives the signals back, but for those that somebody else has taken meanwhile.
void give_crash_signals_back() {
  for (std::size_t i = 0; i < crash_signals.size(); ++i) {
    struct sigaction now {};
    sigaction(crash_signals[i].number, nullptr, &now);
    const bool ours = (now.sa_flags & SA_SIGINFO) != 0 && now.sa_sigaction == note_crash;
    if (ours) sigaction(crash_signals[i].number, &handlers_before[i], nullptr);
  }
}

}  // namespace

CrashNote::CrashNote(FlightRing& ring) : ring_(ring) {
  const std::scoped_lock lock(crash_mutex);
  for (std::atomic<FlightRing*>& one : crash_rings) {
    FlightRing* none = nullptr;
    if (one.compare_exchange_strong(none, &ring)) break;
  }
  if (crash_notes++ == 0) take_crash_signals();
}

CrashNote::~CrashNote() {
  const std::scoped_lock lock(crash_mutex);
  if (--crash_notes == 0) give_crash_signals_back();
  for (std::atomic<FlightRing*>& one : crash_rings) {
    FlightRing* ours = &ring_;
    one.compare_exchange_strong(ours, nullptr);
  }
}

SteppingNode::SteppingNode(std::size_t node) noexcept : before_(stepping_node) {
  stepping_node = node;
}

SteppingNode::~SteppingNode() {
  stepping_node = before_;
}

}  // namespace tactor
