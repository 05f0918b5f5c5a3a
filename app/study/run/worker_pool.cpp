#include "app/study/run/worker_pool.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string_view>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/core/clock.hpp"
#include "framework/realtime/make_thread.hpp"

namespace tactor {

namespace {

constexpr double never = std::numeric_limits<double>::infinity();

/// What a message between the pool and a worker is.
enum class MessageKind : char { job, stop, answer, note, clock };

struct MessageHead {
  MessageKind kind = MessageKind::job;
  std::uint64_t size = 0;  // of what follows
};

/// False where nobody reads any more.
bool send_all(int socket, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

bool send_message(int socket, MessageKind kind, const std::string& text = {}) {
  const MessageHead head{kind, text.size()};
  return send_all(socket, {reinterpret_cast<const char*>(&head), sizeof head}) && send_all(socket, text);
}

bool receive_all(int socket, char* to, std::size_t size) {
  while (size > 0) {
    const ssize_t got = recv(socket, to, size, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    to += got;
    size -= static_cast<std::size_t>(got);
  }
  return true;
}

/// `SIGSEGV` and the like.
std::string signal_word(int signal) {
  const char* name = sigabbrev_np(signal);
  return name != nullptr ? fmt::format("SIG{}", name) : fmt::format("signal {}", signal);
}

Ending ending_of(int status) {
  if (!WIFSIGNALED(status)) return {fmt::format("ended with exit code {}", WEXITSTATUS(status))};
  if (WTERMSIG(status) == SIGKILL) return {"killed (SIGKILL), perhaps for lack of memory", true};
  return {"ended by " + signal_word(WTERMSIG(status))};
}

/// Whether a user or the system asked the worker to end, which is meant for the command.
bool is_request(int status) {
  return WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM;
}

/// The CPU time of a process that lives, in s.
double cpu_of(pid_t process) {
  clockid_t clock{};
  return clock_getcpuclockid(process, &clock) == 0 ? clock_seconds(clock) : 0;
}

}  // namespace

std::string took_longer(double seconds) {
  return fmt::format("took longer than {} s, the run_timeout", seconds);
}

bool PoolLink::go_on() const {
  char next = 0;
  const ssize_t got = recv(socket_, &next, 1, MSG_PEEK | MSG_DONTWAIT);
  return got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR);
}

void PoolLink::note(const std::string& text) const {
  send_message(socket_, MessageKind::note, text);
}

void PoolLink::begin_clock() const {
  send_message(socket_, MessageKind::clock);
}

struct WorkerPool::Worker {
  pid_t process = 0;
  int socket = -1;
  std::optional<std::size_t> job;
  std::size_t finished = 0;  // jobs
  double since = never;      // when the clock of its job began, s
  bool overdue = false;      // and killed for it
  std::string received;      // of messages that are not whole yet
};

WorkerPool::WorkerPool(Work work, std::function<int()> interruptions)
    : work_(std::move(work)), interruptions_(std::move(interruptions)) {
  std::signal(SIGCHLD, SIG_DFL);  // who started us may have it ignored, and then nobody could wait
}

WorkerPool::~WorkerPool() {
  for (const Worker& worker : workers_) {
    kill(worker.process, SIGKILL);
    while (waitpid(worker.process, nullptr, 0) < 0 && errno == EINTR) {
    }
    close(worker.socket);
  }
}

double WorkerPool::cpu_s() const {
  rusage ended{};
  getrusage(RUSAGE_CHILDREN, &ended);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  double sum = seconds(ended.ru_utime) + seconds(ended.ru_stime);
  for (const Worker& worker : workers_) sum += cpu_of(worker.process);
  return sum;
}

bool WorkerPool::run(const JobBatch& batch) {
  next_ = 0;
  again_.clear();
  closed_ = false;
  looked_ = clock_seconds(CLOCK_MONOTONIC);
  read_all(batch);  // a worker may have been killed between two batches
  for (;;) {
    listen();
    hand_out(batch);
    if (busy() == 0) return !stopping_;
    wait();
    read_all(batch);
    kill_overdue(batch);
  }
}

/// Takes note of who asks the command to end.
void WorkerPool::listen() {
  const int count = interruptions_();
  if (count == heard_) return;
  const double now = clock_seconds(CLOCK_MONOTONIC);
  // A terminal and a program that passes signals on may both have sent one, so twice at once says no more than once.
  if (heard_ > 0 && now - first_heard_ > 1) {
    throw RunError("interrupted again, and killed; the runs that had finished are kept");
  }
  if (heard_ == 0) first_heard_ = now;
  heard_ = count;
  tell_to_stop();
}

void WorkerPool::tell_to_stop() {
  if (stopping_) return;
  stopping_ = true;
  for (const Worker& worker : workers_) {
    if (worker.job) send_message(worker.socket, MessageKind::stop);
  }
}

void WorkerPool::hand_out(const JobBatch& batch) {
  while (!stopping_ && !closed_ && !again_.empty() && busy() < batch.at_once) {
    const std::size_t job = again_.back();
    again_.pop_back();
    begin(fork_worker(), job, batch.job(job));
  }
  while (!stopping_ && !closed_ && next_ < batch.jobs && busy() < batch.at_once) {
    const std::size_t job = next_++;
    const std::string message = batch.job(job);
    begin(idle_worker(), job, message);
  }
}

void WorkerPool::begin(Position worker, std::size_t job, const std::string& message) {
  worker->job = job;
  send_message(worker->socket, MessageKind::job, message);  // if the worker is gone, reading from it tells
}

std::size_t WorkerPool::busy() const {
  return static_cast<std::size_t>(
      std::count_if(workers_.begin(), workers_.end(), [](const Worker& worker) { return worker.job.has_value(); }));
}

WorkerPool::Position WorkerPool::idle_worker() {
  const auto found =
      std::find_if(workers_.begin(), workers_.end(), [](const Worker& worker) { return !worker.job.has_value(); });
  return found != workers_.end() ? found : fork_worker();
}

WorkerPool::Position WorkerPool::fork_worker() {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw RunError(fmt::format("no socket for a worker of the study: {}", std::strerror(errno)));
  }
  std::fflush(stdout);  // else the worker would write it too
  const pid_t parent = getpid();
  const pid_t process = fork();
  if (process < 0) {
    const int error = errno;
    for (const int end : ends) close(end);
    throw RunError(refused_start("process of the study", error));
  }
  if (process == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(1);  // it had gone before that could be said
    // A terminal sends these to the workers too; the pool says what follows from them.
    for (const int number : {SIGINT, SIGHUP}) std::signal(number, SIG_IGN);
    std::signal(SIGTERM, SIG_DFL);
    // A worker sees the end of its pool only where no other worker holds the pool's end.
    for (const Worker& other : workers_) close(other.socket);
    close(ends[0]);
    serve(ends[1]);
  }
  close(ends[1]);
  workers_.push_back({.process = process, .socket = ends[0]});
  return std::prev(workers_.end());
}

/// What a worker does until its pool is gone.
void WorkerPool::serve(int socket) noexcept {
  for (;;) {
    MessageHead head;
    if (!receive_all(socket, reinterpret_cast<char*>(&head), sizeof head)) _exit(0);
    std::string job(head.size, '\0');
    if (!receive_all(socket, job.data(), job.size())) _exit(0);
    if (head.kind != MessageKind::job) continue;  // a stop that came when its job was done
    if (!send_message(socket, MessageKind::answer, work_(job, PoolLink(socket)))) _exit(0);
  }
}

/// Until a worker has sent something or ended, or a fifth of a second has passed.
void WorkerPool::wait() {
  std::vector<pollfd> sockets;
  for (const Worker& worker : workers_) sockets.push_back({worker.socket, POLLIN, 0});
  poll(sockets.data(), sockets.size(), 200);
  // Ctrl-Z has stopped the workers too: their time begins anew.
  const double now = clock_seconds(CLOCK_MONOTONIC);
  if (now - looked_ > 5) not_before_ = now;
  looked_ = now;
}

void WorkerPool::read_all(const JobBatch& batch) {
  for (auto worker = workers_.begin(); worker != workers_.end();) {
    const Position here = worker++;
    if (!read_from(*here, batch)) bury(here, batch);
  }
}

/// False where the worker has ended.
bool WorkerPool::read_from(Worker& worker, const JobBatch& batch) {
  std::array<char, 65536> part{};
  ssize_t got = 0;
  for (;;) {
    got = recv(worker.socket, part.data(), part.size(), MSG_DONTWAIT);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    worker.received.append(part.data(), static_cast<std::size_t>(got));
  }
  const bool lives = got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK);
  std::size_t at = 0;
  for (MessageHead head; worker.received.size() - at >= sizeof head;) {
    std::memcpy(&head, worker.received.data() + at, sizeof head);
    if (worker.received.size() - at - sizeof head < head.size) break;
    const std::string text = worker.received.substr(at + sizeof head, head.size);
    at += sizeof head + head.size;
    if (head.kind == MessageKind::note && batch.note) batch.note(text);
    if (head.kind == MessageKind::clock) worker.since = clock_seconds(CLOCK_MONOTONIC);
    if (head.kind == MessageKind::answer && worker.job) {
      const std::size_t job = *worker.job;
      worker.job.reset();
      ++worker.finished;
      worker.since = never;
      if (!batch.done(job, text)) closed_ = true;
    }
  }
  worker.received.erase(0, at);
  return lives;
}

/// Takes a worker that has ended out of the pool, and its job with it.
void WorkerPool::bury(Position dead, const JobBatch& batch) {
  const Worker worker = std::move(*dead);
  workers_.erase(dead);
  close(worker.socket);
  // It ends already, so this changes nothing, unless something in the worker has closed its end of the socket.
  kill(worker.process, SIGKILL);
  int status = 0;
  while (waitpid(worker.process, &status, 0) < 0) {
    if (errno != EINTR) throw RunError(fmt::format("cannot wait for a process: {}", std::strerror(errno)));
  }
  if (!worker.job) return;
  if (is_request(status)) tell_to_stop();
  if (stopping_) return;  // its run is not in the table, like others that were interrupted
  ++lost_;
  const bool late = worker.overdue && batch.time_limit_s;
  const Ending ending = late ? Ending{took_longer(*batch.time_limit_s), true} : ending_of(status);
  if (worker.finished > 0 && !ending.may_differ && !closed_) {
    again_.push_back(*worker.job);
  } else {
    batch.lost(*worker.job, ending);
  }
}

void WorkerPool::kill_overdue(const JobBatch& batch) {
  if (!batch.time_limit_s) return;
  const double now = clock_seconds(CLOCK_MONOTONIC);
  for (Worker& worker : workers_) {
    if (worker.overdue || now - std::max(worker.since, not_before_) <= *batch.time_limit_s) continue;
    worker.overdue = true;
    kill(worker.process, SIGKILL);
  }
}

}  // namespace tactor
