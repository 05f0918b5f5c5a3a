// Who has a device: claims of other processes, which end with them, and locks of serial ports.
#include <fcntl.h>
#include <grp.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <boost/test/unit_test.hpp>
#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>

#include "devices/hardware/claim.hpp"
#include "devices/hardware/serial_ports.hpp"

BOOST_AUTO_TEST_SUITE(claim_test)

using namespace tactor;

namespace {

std::string name_of_this_test() {
  return "of a test of process " + std::to_string(getpid());
}

/// Another process, which does something and then lives until it is killed.
class Other {
 public:
  explicit Other(const std::function<bool()>& work) {
    int ends[2];
    BOOST_REQUIRE(pipe(ends) == 0);
    pid_ = fork();
    if (pid_ == 0) {
      const char good = work() ? 'y' : 'n';
      static_cast<void>(!write(ends[1], &good, 1));
      for (;;) pause();
    }
    char good = 'n';
    BOOST_REQUIRE(read(ends[0], &good, 1) == 1);
    BOOST_TEST(good == 'y');
    close(ends[0]);
    close(ends[1]);
  }
  ~Other() { end(); }
  Other(const Other&) = delete;
  Other& operator=(const Other&) = delete;
  [[nodiscard]] int pid() const { return pid_; }
  void end() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = 0;
  }

 private:
  pid_t pid_ = 0;
};

/// A pseudo-terminal, whose other end is kept open.
struct Terminal {
  int master = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  std::string name;
  Terminal() {
    char text[128];
    BOOST_REQUIRE(master >= 0);
    BOOST_REQUIRE(grantpt(master) == 0);
    BOOST_REQUIRE(unlockpt(master) == 0);
    BOOST_REQUIRE(ptsname_r(master, text, sizeof text) == 0);
    name = text;
  }
  ~Terminal() { close(master); }
};

}  // namespace

BOOST_AUTO_TEST_CASE(what_one_process_has_another_does_not_get_until_the_first_is_killed) {
  const std::string name = name_of_this_test();
  Other other([&] {
    static Claim theirs;
    std::string why;
    return theirs.take(name, why);
  });
  Claim ours;
  std::string why;
  for (int i = 0; i < 20; ++i) {
    BOOST_TEST(!ours.take(name, why));
    BOOST_TEST(why.find("in use by process " + std::to_string(other.pid()) + " (") == 0U, why);
  }
  // The command, as it was started.
  BOOST_TEST(why.find("test_devices_hardware") != std::string::npos, why);
  BOOST_TEST(ours.take(name + " beside it", why), why);
  other.end();
  BOOST_TEST(ours.take(name, why), why);
  BOOST_TEST(ours.held());
}

BOOST_AUTO_TEST_CASE(a_claim_may_be_shared_within_a_process_alone) {
  const std::string name = name_of_this_test();
  std::string why;
  Claim one, two;
  BOOST_TEST(one.take(name, why, Claim::Sharing::process), why);
  BOOST_TEST(two.take(name, why, Claim::Sharing::process), why);
  Other other([&] {
    // A copy of this process: what it has inherited is not its own to give away.
    Claim third;
    std::string who;
    return !third.take(name, who);
  });
  other.end();
  one.release();
  Claim third;
  BOOST_TEST(!third.take(name, why));
  BOOST_TEST(why.find("in use by this process, ") == 0U, why);
  two.release();
  BOOST_TEST(third.take(name, why), why);
}

BOOST_AUTO_TEST_CASE(names_longer_than_the_kernels_are_told_apart_to_their_end) {
  const std::string name = name_of_this_test() + std::string(200, 'x');
  std::string why;
  Claim one, two, three;
  BOOST_TEST(one.take(name + "1", why), why);
  BOOST_TEST(two.take(name + "2", why), why);
  BOOST_TEST(!three.take(name + "1", why));
}

BOOST_AUTO_TEST_CASE(a_serial_port_that_another_program_has_locked_is_refused_with_its_name) {
  const Terminal terminal;
  // As other programs for serial ports lock them.
  Other other([&] {
    const int file = open(terminal.name.c_str(), O_RDWR | O_NOCTTY);
    return file >= 0 && flock(file, LOCK_EX | LOCK_NB) == 0;
  });
  PortLock ours;
  std::string why;
  BOOST_TEST(!ours.take(terminal.name, why));
  BOOST_TEST(why.find("in use by process " + std::to_string(other.pid()) + " (") == 0U, why);
  BOOST_TEST(users_of(terminal.name).find("process " + std::to_string(other.pid())) != std::string::npos);
  other.end();
  BOOST_TEST(ours.take(terminal.name, why), why);
  PortLock second;
  BOOST_TEST(!second.take(terminal.name, why));
  ours.release();
  BOOST_TEST(second.take(terminal.name, why), why);
}

BOOST_AUTO_TEST_CASE(a_port_that_may_not_be_opened_names_the_group_that_may) {
  if (geteuid() != 0 || getgrnam("dialout") == nullptr) return;
  const Terminal terminal;
  BOOST_REQUIRE(chown(terminal.name.c_str(), 0, getgrnam("dialout")->gr_gid) == 0);
  BOOST_REQUIRE(chmod(terminal.name.c_str(), 0660) == 0);
  BOOST_TEST(group_of(terminal.name) == "dialout");
  int ends[2];
  BOOST_REQUIRE(pipe(ends) == 0);
  constexpr unsigned nobody = 65534;
  Other other([&] {
    if (setgroups(0, nullptr) != 0 || setgid(nobody) != 0 || setuid(nobody) != 0) return false;
    PortLock lock;
    std::string why;
    const bool taken = lock.take(terminal.name, why);
    return write(ends[1], why.data(), why.size()) == static_cast<ssize_t>(why.size()) && !taken;
  });
  char text[500] = {};
  BOOST_REQUIRE(read(ends[0], text, sizeof text - 1) > 0);
  BOOST_TEST(std::string(text) == "Permission denied: this user may not open " + terminal.name +
                                      ", which belongs to the group dialout: sudo usermod -aG dialout $USER, then log "
                                      "in anew");
  close(ends[0]);
  close(ends[1]);
}

BOOST_AUTO_TEST_SUITE_END()
