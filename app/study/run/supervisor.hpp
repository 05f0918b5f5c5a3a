// Does the runs of a table in a process of their own, and goes on in a new one where a run has crashed it.
#pragma once

#include <sys/types.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/study/run/crash_board.hpp"

namespace tactor {

struct Ending {
  std::string text;         ///< `ended by SIGSEGV`
  bool may_differ = false;  ///< next time: the machine or the time limit did it, and not the run alone
};

/// What became of a run that exceeded the time limit.
std::string took_longer(double seconds);

/// How a process crashed, and where.
struct Crash {
  Ending ending;
  std::vector<RunPlace> places;  ///< what it was at: any of them may have done it
  bool is_last = false;          ///< there is one, it did the same before, and now with no other run beside it
};

/// One object a command. A run is given up only where it was under way when a process ended, and then ended another one
/// as the first run that this made, with no other beside it: so neither a neighbour is blamed, nor what an earlier run
/// broke.
class Supervisor {
 public:
  /// For so many threads in runs at once.
  explicit Supervisor(unsigned threads);

  /// Forks a process, in which it returns nothing and which goes on with the command. In the process that called, it
  /// waits, passing SIGINT, SIGTERM and SIGHUP on, kills it where a run exceeds the time limit of the board or who
  /// asked it to end asks again a second later, and forks another one where it crashed in a run or was killed; then it
  /// returns the exit code. A crash that is not a run's, or three in a row that brought the table no further, it tells
  /// on standard error, and returns 1. Where another signal ended the process, the same one ends the caller. If the
  /// caller is killed, so is the process. To be called before the program makes threads. Throws RunError where there
  /// can be no process.
  std::optional<int> watch();

  // What the processes that are made need to know.

  [[nodiscard]] CrashBoard& board() { return board_; }
  /// Crashes so far; the last one, where there was any.
  [[nodiscard]] std::size_t crashes() const { return crashes_; }
  [[nodiscard]] const std::optional<Crash>& last() const { return last_; }
  /// What may have crashed a process and is to be tried once more before all others, in this order, alone.
  [[nodiscard]] const std::vector<RunPlace>& suspects() const { return suspects_; }
  /// What is given up, and how it ended.
  [[nodiscard]] const std::map<RunPlace, Ending>& lost() const { return lost_; }

 private:
  int wait_for(pid_t child);
  [[nodiscard]] bool was_trial(RunPlace place) const;
  std::optional<int> judge(int status);
  void learn(Ending ending, std::vector<RunPlace> places);

  CrashBoard board_;
  std::size_t crashes_ = 0;
  std::size_t crashes_in_vain_ = 0;  // in a row
  std::size_t rows_ = 0;             // at the last crash
  std::optional<Crash> last_;
  std::vector<RunPlace> suspects_;
  std::map<RunPlace, Ending> lost_;
  std::optional<double> asked_to_end_;  // when first, s of the monotonic clock
  bool insisted_ = false;
  std::optional<RunPlace> overdue_;  // for which the process is killed
};

}  // namespace tactor
