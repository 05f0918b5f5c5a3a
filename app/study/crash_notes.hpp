// Notes in which run the process crashed, so that the runs of a table that take it with them are known when it goes on.
#pragma once

#include <csignal>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace tactor {

/// One crash: a signal that the process brought upon itself while a thread was in a run of a table.
struct CrashNote {
  int signal = 0;
  bool in_reference = false;  ///< in the reference run that this run, and perhaps others, asked for
  std::size_t run = 0;        ///< number in the table
};

/// `SIGSEGV` and the like.
std::string signal_word(int signal);

/// While it lives, SIGSEGV, SIGBUS, SIGFPE, SIGILL and SIGABRT add a line to the file, if a `CrashPlace` says which run
/// the thread is in, and then do what they did before. Those that another process sent are not noted, and SIGKILL
/// cannot be: they are not the run's doing. One object at a time.
class CrashNotes {
 public:
  /// Opens the file, which is made where it is missing. `advice` is added to the message of a crash on standard error.
  /// Throws RunError where the file cannot be made.
  CrashNotes(std::filesystem::path file, const std::string& advice);
  /// Removes a file in which nothing is noted.
  ~CrashNotes();
  CrashNotes(const CrashNotes&) = delete;
  CrashNotes& operator=(const CrashNotes&) = delete;

  /// What was noted before this object was made, in order. Lines that are not whole are left out.
  [[nodiscard]] const std::vector<CrashNote>& found() const { return found_; }

 private:
  std::filesystem::path file_;
  std::vector<CrashNote> found_;
};

/// While it lives, the thread that made it is in that run, or in its reference run.
class CrashPlace {
 public:
  CrashPlace(std::size_t run, bool in_reference);
  ~CrashPlace();
  CrashPlace(const CrashPlace&) = delete;
  CrashPlace& operator=(const CrashPlace&) = delete;
};

/// While it lives, signals of the thread that made it have a stack of their own: a stack that has run over is noted
/// too.
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
