// Lines that take no bytes, lines that never fall silent, and answers that come in a later session: every call ends,
// and no old answer is believed.
#include <fcntl.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <atomic>
#include <boost/test/data/test_case.hpp>
#include <boost/test/unit_test.hpp>
#include <thread>

#include "devices/modbus/client.hpp"
#include "devices/modbus/emulator/server.hpp"
#include "tests/devices/modbus/loopback.hpp"

BOOST_AUTO_TEST_SUITE(dead_line_test)

using namespace tactor;
using namespace tactor::modbus;

// Named, because the cases over data are templates and capture it.
namespace dead_line_tests {

constexpr Transaction one_word{.function = 3, .read_address = 10, .read_count = 1};
const std::vector<bool> both{false, true};

LineSettings quick_line() {
  LineSettings line;
  line.baud = 115200;
  line.response_timeout = Duration{50'000'000};
  return line;
}

/// A pseudo-terminal in raw mode; the test is what its other end is connected to.
struct Terminal {
  int master = -1, kept_open = -1;
  std::string name;
  Terminal() {
    master = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    BOOST_REQUIRE(master >= 0);
    BOOST_REQUIRE(grantpt(master) == 0);
    BOOST_REQUIRE(unlockpt(master) == 0);
    char text[128];
    BOOST_REQUIRE(ptsname_r(master, text, sizeof text) == 0);
    name = text;
    kept_open = open(text, O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
    termios settings{};
    BOOST_REQUIRE(tcgetattr(kept_open, &settings) == 0);
    cfmakeraw(&settings);
    BOOST_REQUIRE(tcsetattr(kept_open, TCSANOW, &settings) == 0);
  }
  ~Terminal() {
    close(kept_open);
    close(master);
  }
};

/// Two ends of a TCP connection with small buffers.
struct Connection {
  int ours = -1, theirs = -1;
  Connection() {
    const int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const int small = 4096;
    BOOST_REQUIRE(setsockopt(listener, SOL_SOCKET, SO_RCVBUF, &small, sizeof small) == 0);
    const sockaddr_in address = tactor::test::listen_on_loopback(listener, 1);
    ours = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    BOOST_REQUIRE(setsockopt(ours, SOL_SOCKET, SO_SNDBUF, &small, sizeof small) == 0);
    BOOST_REQUIRE(connect(ours, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
    theirs = accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
    BOOST_REQUIRE(theirs >= 0);
    close(listener);
  }
  ~Connection() { close(theirs); }  // the client closes ours
};

/// Writes until nothing more is taken.
void fill(int file) {
  const int flags = fcntl(file, F_GETFL);
  BOOST_REQUIRE(fcntl(file, F_SETFL, flags | O_NONBLOCK) == 0);
  const std::string bytes(4096, 'x');
  // Twice, because what is on its way makes room once more.
  for (int round = 0; round < 2; ++round) {
    for (std::size_t piece = bytes.size(); piece > 0;) {
      if (write(file, bytes.data(), piece) < 0) piece /= 2;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  BOOST_REQUIRE(fcntl(file, F_SETFL, flags) == 0);
}

/// Sends without a pause, from a thread of its own, until it is told to stop.
class Flood {
 public:
  explicit Flood(int file) : thread_([this, file] { run(file); }) {}
  ~Flood() {
    stop_ = true;
    thread_.join();
  }

 private:
  void run(int file) {
    fcntl(file, F_SETFL, fcntl(file, F_GETFL) | O_NONBLOCK);
    const std::string bytes(16384, '\xff');
    while (!stop_) {
      if (write(file, bytes.data(), bytes.size()) < 0) std::this_thread::yield();
    }
  }
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

void refuses_the_request(Client& client) {
  LinkFailure failure;
  std::uint16_t word = 0;
  BOOST_TEST(!client.transfer(one_word, nullptr, &word, failure));
  BOOST_CHECK(failure.error == LinkError::timeout);
  BOOST_TEST(failure.reopen);
  BOOST_TEST(failure.text.find("the line takes no request within 50 ms") != std::string::npos, failure.text);
}

}  // namespace dead_line_tests

using namespace dead_line_tests;

BOOST_AUTO_TEST_CASE(a_serial_line_that_takes_no_bytes_holds_nothing_up) {
  const Terminal terminal;
  fill(terminal.kept_open);
  Client client(parse_endpoint("rtu:" + terminal.name), quick_line(), {3, 10, 2}, 9);
  LinkFailure failure;
  BOOST_TEST_REQUIRE(client.connect(failure), failure.text);
  for (int i = 0; i < 3; ++i) refuses_the_request(client);
  // What nobody took is given up with the session, so that the next one has room again, and then no answer.
  BOOST_TEST_REQUIRE(client.connect(failure), failure.text);
  std::uint16_t word = 0;
  BOOST_TEST(!client.transfer(one_word, nullptr, &word, failure));
  BOOST_TEST(failure.text.find("no whole answer within 50 ms") != std::string::npos, failure.text);
}

BOOST_AUTO_TEST_CASE(a_peer_over_tcp_that_never_reads_holds_nothing_up) {
  const Connection connection;
  fill(connection.ours);
  Client client(parse_endpoint("tcp:127.0.0.1:1"), quick_line(), {3, 10, 2}, 9);
  client.attach(connection.ours);
  for (int i = 0; i < 3; ++i) refuses_the_request(client);
}

BOOST_DATA_TEST_CASE(a_peer_that_never_stops_sending_holds_nothing_up, both, serial) {
  const Terminal terminal;
  const Connection connection;
  Client client(parse_endpoint(serial ? "rtu:" + terminal.name : "tcp:127.0.0.1:1"), quick_line(), {3, 10, 2}, 9);
  LinkFailure failure;
  if (serial) {
    BOOST_TEST_REQUIRE(client.connect(failure), failure.text);
  } else {
    client.attach(connection.ours);
  }
  const Flood flood(serial ? terminal.master : connection.theirs);
  std::uint16_t word = 0;
  bool told = false;
  for (int i = 0; i < 100 && !told; ++i) {
    failure = {};
    BOOST_TEST(!client.transfer(one_word, nullptr, &word, failure));
    told = failure.text == "the line does not fall silent";
  }
  BOOST_TEST(told);
  BOOST_TEST(failure.reopen);
}

BOOST_AUTO_TEST_CASE(a_connection_that_nobody_takes_up_ends_in_its_time) {
  const int listener = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = tactor::test::listen_on_loopback(listener, 0);
  // One finds room; whoever comes after it gets no answer at all.
  const int first = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  BOOST_REQUIRE(connect(first, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  LineSettings line;
  line.response_timeout = Duration{1'100'000'000};
  Client client(parse_endpoint("tcp:127.0.0.1:" + std::to_string(ntohs(address.sin_port))), line, {}, 0);
  LinkFailure failure;
  BOOST_TEST(!client.connect(failure));
  BOOST_CHECK(failure.error == LinkError::disconnected);
  close(first);
  close(listener);
}

BOOST_AUTO_TEST_CASE(an_answer_of_an_earlier_session_is_never_taken_for_one_of_this) {
  Profile profile = read_profile(TACTOR_SOURCE_DIR "/devices/modbus/profiles/iris_orca.yaml");
  profile.line.response_timeout = Duration{300'000'000};
  profile.fence.reset();
  const CyclePlan plan = plan_cycle(profile);
  Emulator emulator(profile, {.serial = true, .line_delay = false});
  emulator.start();
  // The serial number tells the motor from others; it has as many words as the position.
  const Transaction serial_number{.function = 3, .read_address = 406, .read_count = 2};
  const auto read = [&](Client& client, bool& done) {
    std::uint16_t words[2] = {0, 0};
    LinkFailure failure;
    done = client.transfer(serial_number, nullptr, words, failure);
    return words[1] * 65536 + words[0];
  };
  const auto session = [&] {
    auto client =
        std::make_unique<Client>(parse_endpoint(emulator.address()), profile.line, plan.fence, plan.longest_answer);
    LinkFailure failure;
    BOOST_REQUIRE(client->connect(failure));
    return client;
  };
  // The delays let the answer come before the fence of the next session, between two of its tries, and with one under
  // way.
  for (const char* late : {"late:0.5", "late:0.8", "late:1.1", "late:1.4", "late:1.7"}) {
    bool done = false;
    {
      const auto earlier = session();
      for (int i = 0; i < 100 && !done; ++i) read(*earlier, done);
      BOOST_TEST_REQUIRE(done);
      emulator.inject(parse_fault(late));
      for (int i = 0; i < 1000 && done; ++i) read(*earlier, done);
      BOOST_TEST(!done);
    }
    const auto later = session();
    int good = 0;
    for (int i = 0; i < 300 && good < 10; ++i) {
      const int value = read(*later, done);
      if (!done) continue;
      ++good;
      BOOST_TEST(value == 4711, late);
    }
    BOOST_TEST(good == 10);
  }
}

BOOST_AUTO_TEST_SUITE_END()
