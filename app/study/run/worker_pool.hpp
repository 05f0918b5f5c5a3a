// Processes that do jobs, each one at a time: whatever ends a process costs the job that it held and no other.
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <optional>
#include <string>
#include <vector>

namespace tactor {

/// How a worker ended in the middle of a job.
struct Ending {
  std::string text;         ///< `ended by SIGSEGV`
  bool may_differ = false;  ///< next time: the machine or the time limit did it, and not the job alone
};

/// What became of a run that exceeded the time limit.
std::string took_longer(double seconds);

/// What a worker has of its pool while it does a job.
class PoolLink {
 public:
  explicit PoolLink(int socket) : socket_(socket) {}
  /// False once the job is to end because the command is to end.
  [[nodiscard]] bool go_on() const;
  /// Something for the user, at once.
  void note(const std::string& text) const;
  /// The time limit of the job counts from now on; before the first call there is none.
  void begin_clock() const;

 private:
  int socket_;
};

/// Jobs of one kind. The functions are called in the process that has the pool, on its thread.
struct JobBatch {
  std::size_t jobs = 0;  ///< handed out in their order
  unsigned at_once = 1;
  std::optional<double>
      time_limit_s;  ///< of real time, from PoolLink::begin_clock on; a worker that exceeds it is killed
  std::function<std::string(std::size_t job)> job;                       ///< what is handed over
  std::function<bool(std::size_t job, const std::string& answer)> done;  ///< false: no further job is handed out
  /// Its worker ended. Where that had done other jobs before, which may have broken something, and ended by itself, the
  /// job is first tried once more by a new one.
  std::function<void(std::size_t job, const Ending& ending)> lost;
  std::function<void(const std::string& note)> note;
};

/// Forks its workers when there is a job for them, so the program must have no other thread while it runs batches. If
/// the process that has the pool is killed, its workers end.
class WorkerPool {
 public:
  /// Returns the answer to a job. Called in a worker.
  using Work = std::function<std::string(const std::string& job, const PoolLink& pool)>;

  /// `interruptions`: how often somebody has asked the command to end.
  WorkerPool(Work work, std::function<int()> interruptions);
  /// Kills workers that are left.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Returns when all jobs have ended. Returns false where somebody asked the command to end: jobs under way are told
  /// so and ended by themselves, and others were not begun. Throws RunError where somebody asks again more than a
  /// second later, and where the system gives no process; what a function of the batch throws is passed on.
  bool run(const JobBatch& batch);

  /// Jobs whose workers ended.
  [[nodiscard]] std::size_t lost() const { return lost_; }
  /// CPU time of all workers so far, in s.
  [[nodiscard]] double cpu_s() const;

 private:
  struct Worker;
  using Position = std::list<Worker>::iterator;

  void listen();
  void tell_to_stop();
  void hand_out(const JobBatch& batch);
  [[nodiscard]] Position idle_worker();
  void begin(Position worker, std::size_t job, const std::string& message);
  Position fork_worker();
  [[noreturn]] void serve(int socket) noexcept;
  [[nodiscard]] std::size_t busy() const;
  void wait();
  void kill_overdue(const JobBatch& batch);
  void read_all(const JobBatch& batch);
  bool read_from(Worker& worker, const JobBatch& batch);
  void bury(Position dead, const JobBatch& batch);

  Work work_;
  std::function<int()> interruptions_;
  std::list<Worker> workers_;
  std::size_t next_ = 0;            // job of the batch
  std::vector<std::size_t> again_;  // jobs that are tried once more
  bool closed_ = false;             // no further job of the batch is handed out
  bool stopping_ = false;           // somebody has asked
  int heard_ = 0;                   // interruptions
  double first_heard_ = 0;          // s of the monotonic clock
  double looked_ = 0;               // likewise, when it last waited
  double not_before_ = 0;           // likewise: no time limit counts from earlier on
  std::size_t lost_ = 0;
};

}  // namespace tactor
