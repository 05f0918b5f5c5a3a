// One writer at a time, whatever the file system says about locks. flock and fcntl are those of this file, which may
// answer as a file system without locks would.
#include <boost/test/unit_test.hpp>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <fstream>
#include <string>

#include "framework/core/check.hpp"
#include "framework/core/file_descriptor.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/core/write_lock.hpp"

BOOST_AUTO_TEST_SUITE(write_lock_test)

namespace {
int imposed = 0;        // errno of every lock; 0: the system answers
int interruptions = 0;  // how often EINTR comes first
int lock_answer() {
  if (interruptions > 0) {
    --interruptions;
    return EINTR;
  }
  return imposed;
}
}  // namespace

extern "C" int flock(int file, int operation) noexcept {
  errno = lock_answer();
  return errno != 0 ? -1 : static_cast<int>(syscall(SYS_flock, file, operation));
}

extern "C" int fcntl(int file, int command, ...) {
  va_list more;
  va_start(more, command);
  void* argument = va_arg(more, void*);
  va_end(more);
  const bool locks = command == F_OFD_SETLK || command == F_SETLK;
  errno = locks ? lock_answer() : 0;
  return errno != 0 ? -1 : static_cast<int>(syscall(SYS_fcntl, file, command, argument));
}

using namespace tactor;
namespace fs = std::filesystem;

namespace {

constexpr std::array no_locks{ENOSYS, ENOLCK, EOPNOTSUPP, EINVAL, EIO, EPERM, 524};  // 524: ENOTSUPP, of NFS servers
constexpr std::array kinds{LockKind::whole, LockKind::beside};

FileDescriptor open_file(const fs::path& path) {
  return FileDescriptor(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
}

/// The exit code of a child that does this; -1 where a signal ended it.
template <class Action>
int in_child(const Action& action) {
  const pid_t child = fork();
  if (child == 0) {
    int code = 3;
    try {
      code = action();
    } catch (const RunError&) {
    }
    _exit(code);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// Whether another process is given the lock.
bool others_can_take(const fs::path& path, LockKind kind) {
  return in_child([&] {
           const FileDescriptor file = open_file(path);
           WriteLock lock;
           return lock.take(file.number(), path, kind) ? 0 : 1;
         }) == 0;
}

std::size_t files_in(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

void write(const fs::path& path, const std::string& text) {
  std::ofstream(path) << text;
}

/// Imposes an answer for as long as it lives.
struct Imposed {
  explicit Imposed(int error) { imposed = error; }
  ~Imposed() { imposed = interruptions = 0; }
  Imposed(const Imposed&) = delete;
  Imposed& operator=(const Imposed&) = delete;
};

}  // namespace

BOOST_AUTO_TEST_CASE(one_of_two_has_the_lock_with_locks_of_the_system_and_without) {
  int members = 0;
  for (const LockKind kind : kinds) {
    for (int error : {0, ENOSYS, ENOLCK, EOPNOTSUPP, EINVAL, EIO, EPERM, 524}) {
      const Imposed answer(error);
      const TemporaryFolder temporary;
      const fs::path path = temporary.path() / "file";
      const FileDescriptor file = open_file(path), again = open_file(path);
      {
        WriteLock lock, other;
        BOOST_TEST(lock.take(file.number(), path, kind));
        BOOST_TEST(!other.take(again.number(), path, kind));
        BOOST_TEST(!others_can_take(path, kind));
        WriteLock moved = std::move(lock);
        BOOST_TEST(!others_can_take(path, kind));
        // A process that is forked leaves the lock with us, however it ends.
        BOOST_TEST(in_child([] { return 0; }) == 0);
        BOOST_TEST(!others_can_take(path, kind));
        if (error != 0) continue;  // else the system lets go when the file is closed
      }
      ++members;
    }
  }
  BOOST_TEST(members == 2);
}

BOOST_AUTO_TEST_CASE(nothing_is_left_when_the_lock_goes_and_it_can_be_taken_again) {
  for (const LockKind kind : kinds) {
    for (const int error : no_locks) {
      const Imposed answer(error);
      const TemporaryFolder temporary;
      const fs::path path = temporary.path() / "file";
      for (int time = 0; time < 3; ++time) {
        const FileDescriptor file = open_file(path);
        WriteLock lock;
        BOOST_TEST(lock.take(file.number(), path, kind));
        BOOST_TEST(files_in(temporary.path()) == 2U);
        lock.release();
        BOOST_TEST(files_in(temporary.path()) == 1U);
        BOOST_TEST(others_can_take(path, kind));
        BOOST_TEST(files_in(temporary.path()) == 1U);
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(the_lock_of_a_process_that_was_killed_is_taken_over) {
  for (const int error : no_locks) {
    const Imposed answer(error);
    const TemporaryFolder temporary;
    const fs::path path = temporary.path() / "file";
    const int ended = in_child([&]() -> int {
      const FileDescriptor file = open_file(path);
      WriteLock lock;
      if (!lock.take(file.number(), path)) return 1;
      raise(SIGKILL);
      return 2;
    });
    BOOST_TEST(ended == -1);
    BOOST_TEST(fs::exists(temporary.path() / "file.held"));
    BOOST_TEST(others_can_take(path, LockKind::whole));
    BOOST_TEST(files_in(temporary.path()) == 1U);
  }
}

BOOST_AUTO_TEST_CASE(of_many_that_come_for_the_lock_of_a_killed_process_one_has_it) {
  const Imposed answer(ENOSYS);
  for (int time = 0; time < 20; ++time) {
    const TemporaryFolder temporary;
    const fs::path path = temporary.path() / "file";
    in_child([&]() -> int {
      const FileDescriptor file = open_file(path);
      WriteLock lock;
      if (lock.take(file.number(), path)) raise(SIGKILL);
      return 0;
    });
    std::array<int, 2> go{}, told{};
    BOOST_REQUIRE(pipe(go.data()) == 0);
    BOOST_REQUIRE(pipe(told.data()) == 0);
    constexpr int many = 8;
    std::array<pid_t, many> children{};
    for (pid_t& child : children) {
      child = fork();
      if (child != 0) continue;
      char byte = 0;
      ::close(go[1]);
      while (::read(go[0], &byte, 1) > 0) {
      }
      const FileDescriptor file = open_file(path);
      WriteLock lock;
      const char has = lock.take(file.number(), path) ? 'y' : 'n';
      static_cast<void>(!::write(told[1], &has, 1));
      pause();  // with the lock, until it is killed
      _exit(0);
    }
    ::close(go[0]);
    ::close(go[1]);
    int holders = 0;
    for (int i = 0; i < many; ++i) {
      char has = 0;
      BOOST_REQUIRE(::read(told[0], &has, 1) == 1);
      holders += has == 'y' ? 1 : 0;
    }
    for (const pid_t child : children) {
      kill(child, SIGKILL);
      waitpid(child, nullptr, 0);
    }
    ::close(told[0]);
    ::close(told[1]);
    BOOST_TEST(holders == 1);
  }
}

BOOST_AUTO_TEST_CASE(the_lock_of_another_machine_stays_and_its_file_is_named) {
  const Imposed answer(ENOLCK);
  const TemporaryFolder temporary;
  const fs::path path = temporary.path() / "file", sign = temporary.path() / "file.held";
  const FileDescriptor file = open_file(path);
  for (const std::string text : {"4711 12 a-boot pid:[1] node7\n", "", "damaged", "1 2 3\n"}) {
    write(sign, text);
    WriteLock lock;
    BOOST_TEST(!lock.take(file.number(), path));
    BOOST_TEST(lock.holder().find("remove " + sign.string()) != std::string::npos, lock.holder());
    BOOST_TEST(fs::exists(sign));
  }
  write(sign, "4711 12 a-boot pid:[1] node7\n");
  WriteLock lock;
  BOOST_TEST(!lock.take(file.number(), path));
  BOOST_TEST(lock.holder().find("process 4711 on node7") != std::string::npos);
  fs::remove(sign);
  BOOST_TEST(lock.take(file.number(), path));
}

BOOST_AUTO_TEST_CASE(a_number_that_another_process_has_got_since_holds_nothing) {
  const Imposed answer(ENOSYS);
  const TemporaryFolder temporary;
  const fs::path path = temporary.path() / "file", sign = temporary.path() / "file.held";
  const FileDescriptor file = open_file(path);
  WriteLock lock;
  BOOST_REQUIRE(lock.take(file.number(), path));
  std::ifstream stream(sign);
  std::string number, begin, rest;
  stream >> number >> begin;
  std::getline(stream, rest);
  lock.release();
  write(sign, number + " " + std::to_string(std::stoull(begin) + 1) + rest + "\n");
  BOOST_TEST(lock.take(file.number(), path));
}

BOOST_AUTO_TEST_CASE(a_folder_that_cannot_be_written_is_told_and_a_signal_asks_again) {
  const TemporaryFolder temporary;
  const fs::path path = temporary.path() / "file";
  const FileDescriptor file = open_file(path);
  {
    const Imposed answer(ENOSYS);
    WriteLock lock;
    BOOST_CHECK_THROW(lock.take(file.number(), "/proc/nothing/file"), RunError);
  }
  {
    const Imposed answer(0);
    interruptions = 5;
    WriteLock lock;
    BOOST_TEST(lock.take(file.number(), path));
    BOOST_TEST(interruptions == 0);
    BOOST_TEST(files_in(temporary.path()) == 1U);
  }
}

BOOST_AUTO_TEST_CASE(every_answer_of_the_system_means_one_thing) {
  const TemporaryFolder temporary;
  for (const LockKind kind : {LockKind::whole, LockKind::shared, LockKind::beside, LockKind::of_region}) {
    const FileDescriptor file = open_file(temporary.path() / std::to_string(static_cast<int>(kind)));
    BOOST_TEST((ask_for_lock(file.number(), kind) == LockAnswer::taken));
    for (const int error : {EWOULDBLOCK, EACCES}) {
      const Imposed answer(error);
      BOOST_TEST((ask_for_lock(file.number(), kind) == LockAnswer::busy));
    }
    for (const int error : no_locks) {
      const Imposed answer(error);
      BOOST_TEST((ask_for_lock(file.number(), kind) == LockAnswer::none));
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
