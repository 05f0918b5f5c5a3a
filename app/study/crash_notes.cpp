#include "app/study/crash_notes.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string_view>

#include "framework/core/check.hpp"

namespace tactor {

namespace {

constexpr std::array<int, 5> signals{SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};

struct Place {
  bool known = false;
  bool in_reference = false;
  std::size_t run = 0;
};

// Read by the handler, of which the process has one.
constinit thread_local Place place;
int note_file = -1;
std::string message;
std::array<struct sigaction, signals.size()> before;

void write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t wrote = write(file, text.data(), text.size());
    if (wrote <= 0) return;
    text.remove_prefix(static_cast<std::size_t>(wrote));
  }
}

/// `11 run 12`, without the heap, which may be what is broken.
void write_note(int signal) {
  std::array<char, 64> line{};
  char* end = std::to_chars(line.data(), line.data() + line.size(), signal).ptr;
  for (const char c : std::string_view(place.in_reference ? " reference " : " run ")) *end++ = c;
  end = std::to_chars(end, line.data() + line.size() - 1, place.run).ptr;
  *end++ = '\n';
  write_all(note_file, {line.data(), static_cast<std::size_t>(end - line.data())});
}

void on_crash(int signal, siginfo_t* info, void*) {
  const bool sent_by_another = info->si_code <= 0 && info->si_pid != getpid();
  if (place.known && !sent_by_another) {
    write_note(signal);
    write_all(STDERR_FILENO, message);
  }
  for (std::size_t i = 0; i < signals.size(); ++i) {
    if (signals[i] == signal) sigaction(signal, &before[i], nullptr);
  }
  raise(signal);  // it comes when this function has returned
}

std::vector<CrashNote> read_notes(const std::filesystem::path& file) {
  std::vector<CrashNote> notes;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line) && !stream.eof();) {
    std::istringstream words(line);
    CrashNote note;
    std::string what;
    if (!(words >> note.signal >> what >> note.run) || (what != "run" && what != "reference")) continue;
    note.in_reference = what == "reference";
    notes.push_back(note);
  }
  return notes;
}

}  // namespace

std::string signal_word(int signal) {
  const char* name = sigabbrev_np(signal);
  return name != nullptr ? fmt::format("SIG{}", name) : fmt::format("signal {}", signal);
}

CrashNotes::CrashNotes(std::filesystem::path file, const std::string& advice)
    : file_(std::move(file)), found_(read_notes(file_)) {
  TACTOR_DEMAND(note_file < 0);
  note_file = open(file_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (note_file < 0) throw RunError(fmt::format("cannot write {}: {}", file_.string(), std::strerror(errno)));
  message = "\ntactor: the process crashed in a run" + (advice.empty() ? "" : "; " + advice) + "\n";
  struct sigaction action {};
  action.sa_sigaction = on_crash;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < signals.size(); ++i) sigaction(signals[i], &action, &before[i]);
}

CrashNotes::~CrashNotes() {
  for (std::size_t i = 0; i < signals.size(); ++i) sigaction(signals[i], &before[i], nullptr);
  struct stat state {};
  if (fstat(note_file, &state) == 0 && state.st_size == 0) unlink(file_.c_str());
  close(note_file);
  note_file = -1;
}

CrashPlace::CrashPlace(std::size_t run, bool in_reference) {
  place.run = run;
  place.in_reference = in_reference;
  place.known = true;
}

CrashPlace::~CrashPlace() {
  place.known = false;
}

CrashStack::CrashStack() : memory_(std::size_t{64} << 10U) {
  const stack_t mine{.ss_sp = memory_.data(), .ss_flags = 0, .ss_size = memory_.size()};
  sigaltstack(&mine, &before_);
}

CrashStack::~CrashStack() {
  sigaltstack(&before_, nullptr);
}

}  // namespace tactor
