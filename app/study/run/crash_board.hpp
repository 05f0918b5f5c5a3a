// Where a process is in the runs of a table, in memory that outlives it: what a crash ended is read there.
#pragma once

#include <array>
#include <atomic>
#include <compare>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tactor {

/// What a thread is at.
enum class RunStage : std::uint8_t {
  planning,   ///< of a case: its files are read and its nodes checked
  reference,  ///< the reference run that a run, and perhaps others, asked for
  run,
};

struct RunPlace {
  RunStage stage = RunStage::run;
  std::size_t number = 0;  ///< of the case while planning, else of the run in the table
  auto operator<=>(const RunPlace&) const = default;
};

/// `SIGSEGV` and the like.
std::string signal_word(int signal);

/// Memory that a process shares with the children that it forks. One process at a time writes to it, from any thread;
/// its parent reads.
class CrashBoard {
 public:
  /// For so many threads in runs at once. Throws RunError where there is no memory.
  explicit CrashBoard(unsigned threads);
  ~CrashBoard();
  CrashBoard(const CrashBoard&) = delete;
  CrashBoard& operator=(const CrashBoard&) = delete;

  /// Forgets where the last process was.
  void begin();

  /// The places that the process is in or was in when it ended: one alone where its own signal told which.
  [[nodiscard]] std::vector<RunPlace> places() const;
  /// A place where a thread has been for longer than the time limit, counted from `not_before` on where that is later
  /// than its begin, in s of the monotonic clock; nothing where there is none, or while planning.
  [[nodiscard]] std::optional<RunPlace> overdue(double not_before) const;
  /// The signal that the process brought upon itself in one of them; 0 where there was none.
  [[nodiscard]] int signal() const;

  /// The process is alone with the first run that it makes. Nothing: it no longer is.
  void set_trial(std::optional<std::size_t> run);
  [[nodiscard]] std::optional<std::size_t> trial() const;
  /// For a run, in s of real time. It holds for all processes from now on.
  void set_timeout(double seconds);
  [[nodiscard]] double timeout() const;
  /// Of all processes since the board was made.
  void count_row();
  [[nodiscard]] std::size_t rows() const;
  /// Whether one of them has made or opened the table.
  void set_has_table();
  [[nodiscard]] bool has_table() const;

 private:
  friend class CrashPlace;
  friend class CrashSignals;
  struct Shared;
  struct Slot;
  Shared* shared_ = nullptr;
  std::span<Slot> slots_;
  std::size_t size_ = 0;  // in bytes
};

/// While it lives, the thread that made it is at that place. No board: it does nothing.
class CrashPlace {
 public:
  CrashPlace(CrashBoard* board, RunPlace place);
  ~CrashPlace();
  /// The time limit counts anew, or no longer.
  void begin();
  void end();
  CrashPlace(const CrashPlace&) = delete;
  CrashPlace& operator=(const CrashPlace&) = delete;

 private:
  CrashBoard::Slot* slot_ = nullptr;
};

/// While it lives, SIGSEGV, SIGBUS, SIGFPE, SIGILL and SIGABRT tell the board at which place the thread is that brought
/// them upon itself, and then do what they did before. One object at a time. No board: it does nothing.
class CrashSignals {
 public:
  explicit CrashSignals(CrashBoard* board);
  ~CrashSignals();
  CrashSignals(const CrashSignals&) = delete;
  CrashSignals& operator=(const CrashSignals&) = delete;
};

/// While it lives, signals of the thread that made it have a stack of their own: a stack that has run over is told too.
class CrashStack {
 public:
  CrashStack();
  ~CrashStack();
  CrashStack(const CrashStack&) = delete;
  CrashStack& operator=(const CrashStack&) = delete;

 private:
  std::vector<char> memory_;
  stack_t before_{};
};

}  // namespace tactor
