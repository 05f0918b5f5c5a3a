// Descriptors of devices do not reach children: neither by fork, however it comes, nor by the start of a program.
#include "devices/hardware/device_descriptors.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <pty.h>
#include <spawn.h>
#include <sys/eventfd.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <boost/test/unit_test.hpp>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "devices/hardware/claim.hpp"

BOOST_AUTO_TEST_SUITE(device_descriptors_test)

using namespace tactor;

namespace {

/// What `ask` says in a child that is forked now, 0 to 255.
int in_child(const std::function<int()>& ask) {
  const pid_t child = fork();
  if (child == 0) _exit(ask());
  int status = 0;
  BOOST_REQUIRE(waitpid(child, &status, 0) == child);
  BOOST_REQUIRE(WIFEXITED(status));
  return WEXITSTATUS(status);
}

bool is_open(int descriptor) {
  return fcntl(descriptor, F_GETFD) >= 0;
}

/// Descriptors of this process that are sockets. Async-signal-safe enough for a child of a test: it lists by number.
int open_sockets() {
  int count = 0;
  for (int number = 3; number < 256; ++number) {
    int type = 0;
    socklen_t size = sizeof type;
    if (getsockopt(number, SOL_SOCKET, SO_TYPE, &type, &size) == 0) ++count;
  }
  return count;
}

/// A child that does nothing, and lives as long as this.
class Child {
 public:
  Child() {
    BOOST_REQUIRE(pipe(begun_.data()) == 0);
    BOOST_REQUIRE(pipe(ends_.data()) == 0);
    pid_ = fork();
    if (pid_ == 0) {
      close(ends_[1]);
      char byte = 0;
      if (write(begun_[1], &byte, 1) != 1) _exit(1);
      _exit(static_cast<int>(read(ends_[0], &byte, 1)));
    }
    char byte = 0;
    BOOST_REQUIRE(read(begun_[0], &byte, 1) == 1);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    for (const int file : {begun_[0], begun_[1], ends_[0], ends_[1]}) close(file);
    waitpid(pid_, nullptr, 0);
  }

 private:
  std::array<int, 2> begun_{}, ends_{};
  pid_t pid_ = 0;
};

struct Kind {
  const char* name;
  std::function<int()> open;
};

/// What devices open, by hand or through libraries.
std::vector<Kind> kinds() {
  return {{"a TCP socket", [] { return socket(AF_INET, SOCK_STREAM, 0); }},
          {"a datagram socket", [] { return socket(AF_INET, SOCK_DGRAM, 0); }},
          {"a local socket", [] { return socket(AF_UNIX, SOCK_STREAM, 0); }},
          {"a terminal", [] { return posix_openpt(O_RDWR | O_NOCTTY); }},
          {"a character device", [] { return open("/dev/null", O_RDWR); }},
          {"an event", [] { return eventfd(0, 0); }},
          {"a timer", [] { return timerfd_create(CLOCK_MONOTONIC, 0); }},
          {"memory", [] { return memfd_create("test", 0); }}};
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_kept_descriptor_is_closed_in_every_child_and_stays_open_here) {
  for (const Kind& kind : kinds()) {
    BOOST_TEST_CONTEXT(kind.name) {
      const int kept = kind.open(), other = kind.open();
      BOOST_REQUIRE(kept >= 0);
      keep_from_children(kept);
      BOOST_TEST((fcntl(kept, F_GETFD) & FD_CLOEXEC) != 0);
      for (int i = 0; i < 3; ++i) {
        BOOST_TEST(in_child([&] { return is_open(kept) ? 1 : is_open(other) ? 0 : 2; }) == 0);
        BOOST_TEST(is_open(kept));
      }
      // A child of the child has none either, and one that opens a descriptor of its own keeps that.
      BOOST_TEST(in_child([&] {
                   const int own = kind.open();
                   return in_child([&] { return own == kept || !is_open(kept) ? is_open(own) ? 0 : 2 : 1; });
                 }) == 0);
      BOOST_TEST(forget_descriptor(kept));
      BOOST_TEST(!forget_descriptor(kept));
      BOOST_TEST(in_child([&] { return is_open(kept) ? 0 : 1; }) == 0);
      close_kept(kept);
      BOOST_TEST(is_open(kept));
      keep_from_children(kept);
      // In a child the number is free, and what is opened there under it is not the device.
      BOOST_TEST(in_child([&] {
                   const int own = dup2(other, kept);
                   close_kept(kept);
                   return own == kept && is_open(own) ? 0 : 1;
                 }) == 0);
      close_kept(kept);
      BOOST_TEST(!is_open(kept));
      close(other);
    }
  }
}

BOOST_AUTO_TEST_CASE(a_number_that_is_used_again_after_its_device_was_closed_reaches_children) {
  const int device = socket(AF_UNIX, SOCK_STREAM, 0);
  keep_from_children(device);
  close_kept(device);
  const int file = open("/dev/null", O_RDONLY);
  BOOST_REQUIRE(file == device);
  BOOST_TEST(in_child([&] { return is_open(file) ? 0 : 1; }) == 0);
  close(file);
  close_kept(-1);
  keep_from_children(-1);
}

BOOST_AUTO_TEST_CASE(a_program_that_is_started_gets_none) {
  const int kept = socket(AF_UNIX, SOCK_STREAM, 0);
  keep_from_children(kept);
  const std::string file = "/proc/self/fd/" + std::to_string(kept);
  std::array<char*, 4> arguments{const_cast<char*>("test"), const_cast<char*>("-e"), const_cast<char*>(file.c_str()),
                                 nullptr};
  pid_t child = 0;
  BOOST_REQUIRE(posix_spawn(&child, "/usr/bin/test", nullptr, nullptr, arguments.data(), environ) == 0);
  int status = 0;
  waitpid(child, &status, 0);
  BOOST_TEST(WEXITSTATUS(status) == 1);
  BOOST_TEST(std::system(("test ! -e " + file).c_str()) == 0);
  close_kept(kept);
}

BOOST_AUTO_TEST_CASE(a_claim_ends_with_its_owner_although_a_child_lives_on) {
  const std::string name = "of a test of children of process " + std::to_string(getpid());
  for (const auto sharing : {Claim::Sharing::alone, Claim::Sharing::process}) {
    std::string why;
    Claim first;
    BOOST_REQUIRE(first.take(name, why, sharing));
    const Child child;
    first.release();
    Claim second;
    BOOST_TEST(second.take(name, why, Claim::Sharing::alone), why);
  }
}

BOOST_AUTO_TEST_CASE(a_lock_of_a_port_ends_with_its_owner_although_a_child_lives_on) {
  int terminal = 0, port = 0;
  std::array<char, 128> path{};
  BOOST_REQUIRE(openpty(&terminal, &port, path.data(), nullptr, nullptr) == 0);
  std::string why;
  PortLock first;
  BOOST_REQUIRE(first.take(path.data(), why));
  {
    const Child child;
    first.release();
    PortLock second;
    BOOST_TEST(second.take(path.data(), why), why);
  }
  close(terminal);
  close(port);
}

// Three threads open and close devices all the time; a fork may come between any two of their steps.
BOOST_AUTO_TEST_CASE(a_fork_while_devices_are_opened_and_closed_gets_none) {
  constexpr int forks = 300, threads = 3;
  std::atomic<bool> over = false;
  std::atomic<int> opened = 0;
  std::vector<std::jthread> devices;
  for (int t = 0; t < threads; ++t) {
    devices.emplace_back([&] {
      while (!over) {
        int device = -1;
        {
          const NoFork until_kept;
          device = socket(AF_UNIX, SOCK_STREAM, 0);
          keep_from_children(device);
        }
        ++opened;
        close_kept(device);
      }
    });
  }
  while (opened < threads) std::this_thread::yield();
  int leaked = 0;
  for (int i = 0; i < forks; ++i) leaked += in_child([] { return open_sockets(); });
  over = true;
  devices.clear();
  BOOST_TEST(leaked == 0);
  BOOST_TEST(opened > forks / 10);
}

BOOST_AUTO_TEST_SUITE_END()
