// Bytes that no device means: answers and register maps from a seeded generator. Nothing may crash, hang or be believed
// that is no answer. TACTOR_FUZZ_INPUTS=1000000 takes a million answers instead of 20,000.
#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

#include "devices/modbus/client.hpp"
#include "tests/devices/modbus/loopback.hpp"

BOOST_AUTO_TEST_SUITE(fuzz_test)

using namespace tactor;
using namespace tactor::modbus;

namespace {

using Dice = boost::random::mt19937;

int roll(Dice& dice, int least, int most) {
  return boost::random::uniform_int_distribution<int>(least, most)(dice);
}

std::uint16_t check_sum(const std::uint8_t* bytes, std::size_t count) {
  std::uint16_t sum = 0xffff;
  for (std::size_t i = 0; i < count; ++i) {
    sum = static_cast<std::uint16_t>(sum ^ bytes[i]);
    for (int bit = 0; bit < 8; ++bit) {
      sum = static_cast<std::uint16_t>((sum & 1U) != 0 ? (sum >> 1) ^ 0xa001U : sum >> 1);
    }
  }
  return sum;
}

void put_word(std::vector<std::uint8_t>& bytes, int word) {
  bytes.push_back(static_cast<std::uint8_t>(word >> 8));
  bytes.push_back(static_cast<std::uint8_t>(word & 0xff));
}

void put_check_sum(std::vector<std::uint8_t>& frame) {
  const std::uint16_t sum = check_sum(frame.data(), frame.size() - 2);
  frame[frame.size() - 2] = static_cast<std::uint8_t>(sum & 0xffU);
  frame[frame.size() - 1] = static_cast<std::uint8_t>(sum >> 8);
}

/// The body of an answer between the bytes of the line, for a serial line or for TCP with this number of transaction.
std::vector<std::uint8_t> framed(const std::vector<std::uint8_t>& body, bool serial, int transaction = 1) {
  std::vector<std::uint8_t> frame;
  if (!serial) {
    for (const int word : {transaction, 0, static_cast<int>(body.size()) + 1}) put_word(frame, word);
  }
  frame.push_back(1);  // the slave
  frame.insert(frame.end(), body.begin(), body.end());
  if (serial) {
    frame.resize(frame.size() + 2);
    put_check_sum(frame);
  }
  return frame;
}

/// What a device answers to a request; each word that is read has the value `value`.
std::vector<std::uint8_t> answer_to(const Transaction& t, int value, int written) {
  std::vector<std::uint8_t> body{static_cast<std::uint8_t>(t.function)};
  if (t.function == 6 || t.function == 16) {
    put_word(body, t.write_address);
    put_word(body, t.function == 6 ? written : t.write_count);
    return body;
  }
  body.push_back(static_cast<std::uint8_t>(2 * t.read_count));
  for (int i = 0; i < t.read_count; ++i) put_word(body, value);
  return body;
}

Transaction any_request(Dice& dice, const std::vector<int>& counts) {
  const auto count = [&] {
    return counts[static_cast<std::size_t>(roll(dice, 0, static_cast<int>(counts.size()) - 1))];
  };
  Transaction t;
  t.function = std::array{3, 4, 6, 16, 23}[static_cast<std::size_t>(roll(dice, 0, 4))];
  t.read_address = 10;
  t.write_address = 40;
  if (t.function != 6 && t.function != 16) t.read_count = count();
  if (t.function == 6) t.write_count = 1;
  if (t.function == 16 || t.function == 23) t.write_count = count();
  return t;
}

/// A good answer, changed or not: bytes flipped, cut, added, an exception, the answer to another request, noise.
std::vector<std::uint8_t> mutated(Dice& dice, bool serial, const Transaction& t) {
  const int kind = roll(dice, 0, 9);
  std::vector<std::uint8_t> body = answer_to(t, 0x1234, 7);
  if (kind == 7) body = {static_cast<std::uint8_t>(t.function | 0x80), static_cast<std::uint8_t>(roll(dice, 0, 255))};
  if (kind == 8) body = answer_to(any_request(dice, {1, 2, 3, 60, 120}), 0x1234, 7);
  std::vector<std::uint8_t> frame = framed(body, serial);
  if (kind >= 7) return frame;
  if (kind == 0) {
    frame.resize(static_cast<std::size_t>(roll(dice, 0, 300)));
    for (std::uint8_t& byte : frame) byte = static_cast<std::uint8_t>(roll(dice, 0, 255));
    return frame;
  }
  for (int i = 0, n = roll(dice, 1, 4); i < n; ++i) {
    frame[static_cast<std::size_t>(roll(dice, 0, static_cast<int>(frame.size()) - 1))] =
        static_cast<std::uint8_t>(roll(dice, 0, 255));
  }
  if (kind == 1) frame.resize(static_cast<std::size_t>(roll(dice, 0, static_cast<int>(frame.size()))));
  if (kind == 2) frame.insert(frame.end(), static_cast<std::size_t>(roll(dice, 1, 300)), 0x5a);
  // A frame with a right check sum around a wrong answer goes further in.
  if (serial && kind >= 4 && frame.size() >= 3) put_check_sum(frame);
  return frame;
}

/// Whether a frame begins with an answer to the request: everything that an answer repeats is right, and so is the
/// check sum of a serial line.
bool is_answer(const std::vector<std::uint8_t>& frame, const Transaction& t, bool serial) {
  std::vector<std::uint8_t> good = framed(answer_to(t, 0, 7), serial);
  if (frame.size() < good.size()) return false;
  // The words that were read may have any value.
  const std::size_t data = (serial ? 1 : 7) + 2;
  for (std::size_t i = data; t.read_count > 0 && i < data + 2 * static_cast<std::size_t>(t.read_count); ++i) {
    good[i] = frame[i];
  }
  if (serial) put_check_sum(good);
  return std::equal(good.begin(), good.end(), frame.begin());
}

/// How many inputs each of these tests takes: 20,000, or what the environment says, such as 1000000.
int inputs() {
  const char* text = std::getenv("TACTOR_FUZZ_INPUTS");
  return text == nullptr ? 20'000 : std::max(1'000, std::atoi(text));
}

LineSettings quick_line(std::int64_t timeout_ms) {
  LineSettings line;
  line.baud = 115200;
  line.parity = 'N';
  line.silence = Duration{};
  line.response_timeout = Duration{timeout_ms * 1'000'000};
  return line;
}

constexpr int guard = 0xdead;

/// Room for the words of an answer with marks behind it, which nothing may overwrite.
std::vector<std::uint16_t> room_for(const Transaction& t) {
  std::vector<std::uint16_t> words(static_cast<std::size_t>(t.read_count) + 4, guard);
  std::fill_n(words.begin(), t.read_count, std::uint16_t{0});
  return words;
}
bool is_kept(const std::vector<std::uint16_t>& words) {
  return std::all_of(words.end() - 4, words.end(), [](std::uint16_t word) { return word == guard; });
}

void fuzz_answers(bool serial, std::uint32_t seed) {
  Dice dice(seed);
  // Nothing waits for so long: each line ends behind its answer, however busy the machine.
  Client client(parse_endpoint(serial ? "rtu:/dev/null" : "tcp:127.0.0.1:1"), quick_line(60'000), {}, 9);
  const std::vector<std::uint16_t> written(130, 7);
  std::array<long, 24> good{}, failed{};
  const int n = inputs();
  for (int i = 0; i < n; ++i) {
    const Transaction t = any_request(dice, {1, 2, 3, 8, 60, 120});
    const std::vector<std::uint8_t> frame = mutated(dice, serial, t);
    int pair[2];
    BOOST_REQUIRE(socketpair(AF_UNIX, SOCK_STREAM, 0, pair) == 0);
    client.attach(pair[0]);
    // After the request all that will come, and then the end, so that nothing is waited for.
    std::thread peer([&] {
      std::array<char, 300> request{};
      if (read(pair[1], request.data(), request.size()) <= 0) return;
      if (!frame.empty()) send(pair[1], frame.data(), frame.size(), MSG_NOSIGNAL);
      shutdown(pair[1], SHUT_WR);
    });
    std::vector<std::uint16_t> words = room_for(t);
    LinkFailure failure;
    const bool believed = client.transfer(t, written.data(), words.data(), failure);
    peer.join();
    ++(believed ? good : failed)[static_cast<std::size_t>(t.function)];
    if (believed) {
      BOOST_REQUIRE_MESSAGE(is_answer(frame, t, serial), "input " << i << " is no answer to function " << t.function);
    } else {
      BOOST_REQUIRE(failure.error != LinkError::none);
      BOOST_REQUIRE(!failure.text.empty());
    }
    if (frame == framed(answer_to(t, 0x1234, 7), serial)) {
      BOOST_REQUIRE_MESSAGE(believed, "input " << i << ": " << failure.text);
      for (int k = 0; k < t.read_count; ++k) BOOST_REQUIRE(words[static_cast<std::size_t>(k)] == 0x1234);
    }
    // Nothing is ever written beyond what was asked for.
    BOOST_REQUIRE(is_kept(words));
    client.disconnect();
    close(pair[1]);
  }
  for (const std::size_t function : {3U, 4U, 6U, 16U, 23U}) {
    BOOST_TEST(good[function] > 0);
    BOOST_TEST(failed[function] > good[function]);
  }
}

/// A device at the other end of a line, on a thread of its own: answers, answers wrongly, not at all, or too late,
/// which is when the next request has come. What it answers late it answers in order.
class Peer {
 public:
  Peer(bool serial, std::uint32_t seed) : serial_(serial), dice_(seed) {
    serial ? open_terminal() : listen_at_a_port();
    thread_ = std::thread([this] { serve(); });
  }
  ~Peer() {
    stop_ = true;
    thread_.join();
    for (const int file : {file_, listener_, kept_open_}) {
      if (file >= 0) close(file);
    }
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  [[nodiscard]] const std::string& address() const { return address_; }

  std::atomic<int> value{0};  ///< of all registers, from now on
  std::atomic<int> late{0};   ///< answers

 private:
  void open_terminal() {
    file_ = posix_openpt(O_RDWR | O_NOCTTY);
    char name[128];
    BOOST_REQUIRE(file_ >= 0 && grantpt(file_) == 0 && unlockpt(file_) == 0);
    BOOST_REQUIRE(ptsname_r(file_, name, sizeof name) == 0);
    kept_open_ = open(name, O_RDWR | O_NOCTTY);
    termios settings{};
    BOOST_REQUIRE(tcgetattr(kept_open_, &settings) == 0);
    cfmakeraw(&settings);
    BOOST_REQUIRE(tcsetattr(kept_open_, TCSANOW, &settings) == 0);
    address_ = std::string("rtu:") + name;
  }
  void listen_at_a_port() {
    listener_ = socket(AF_INET, SOCK_STREAM, 0);
    const sockaddr_in address = tactor::test::listen_on_loopback(listener_, 4);
    address_ = "tcp:127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  }

  void serve() {
    while (!stop_) {
      pollfd files[2] = {{file_, POLLIN, 0}, {listener_, POLLIN, 0}};
      if (poll(files, 2, 5) <= 0) continue;
      if (files[1].revents != 0) {
        if (file_ >= 0) close(file_);
        file_ = accept(listener_, nullptr, nullptr);
        held_.clear();
        pending_.clear();
        continue;
      }
      std::uint8_t bytes[600];
      const ssize_t count = read(file_, bytes, sizeof bytes);
      if (count > 0) pending_.insert(pending_.end(), bytes, bytes + count);
      if (count <= 0 && !serial_) {
        close(file_);
        file_ = -1;
      }
      take_requests();
    }
  }
  void take_requests() {
    const std::size_t head = serial_ ? 1 : 7, tail = serial_ ? 2 : 0;
    while (pending_.size() >= head + 5) {
      const std::uint8_t* body = pending_.data() + head;
      const auto word = [&](int i) { return body[i] << 8 | body[i + 1]; };
      Transaction t{.function = body[0], .read_address = word(1), .read_count = word(3)};
      std::size_t size = head + tail + 5;
      int written = 0;
      if (t.function == 6 || t.function == 16) {
        t = {.function = t.function, .write_address = word(1), .write_count = t.function == 6 ? 1 : word(3)};
        written = word(3);
        if (t.function == 16) size += 1 + 2 * static_cast<std::size_t>(t.write_count);
      }
      if (t.function == 23) {
        if (pending_.size() < head + 10) return;
        t.write_count = word(7);
        size += 5 + 2 * static_cast<std::size_t>(t.write_count);
      }
      if (pending_.size() < size) return;
      const int transaction = serial_ ? 0 : pending_[0] << 8 | pending_[1];
      pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(size));
      answer(framed(answer_to(t, value, written), serial_, transaction), t, transaction);
    }
  }
  void answer(std::vector<std::uint8_t> frame, const Transaction& t, int transaction) {
    for (const auto& old : held_) put(old);
    held_.clear();
    switch (roll(dice_, 0, 9)) {
      case 0:
        return;
      case 1:
        ++late;
        held_.push_back(std::move(frame));
        return;
      case 2:
        frame = framed({static_cast<std::uint8_t>(t.function | 0x80), static_cast<std::uint8_t>(roll(dice_, 1, 11))},
                       serial_, transaction);
        break;
      case 3:
        garble(frame);
        break;
      case 4:
        frame.resize(static_cast<std::size_t>(roll(dice_, 0, static_cast<int>(frame.size()) - 1)));
        break;
      case 5:
        for (int i = roll(dice_, 1, 300); i > 0; --i) frame.push_back(static_cast<std::uint8_t>(roll(dice_, 0, 255)));
        break;
      default:
        break;
    }
    put(frame);
  }
  /// Two bytes side by side, which every check sum of 16 bits sees; over TCP in the header or the function.
  void garble(std::vector<std::uint8_t>& frame) {
    const auto at = static_cast<std::size_t>(roll(dice_, 0, serial_ ? static_cast<int>(frame.size()) - 2 : 6));
    frame[at] ^= static_cast<std::uint8_t>(roll(dice_, 1, 255));
    frame[at + 1] ^= static_cast<std::uint8_t>(roll(dice_, 0, 255));
  }
  void put(const std::vector<std::uint8_t>& frame) {
    if (frame.empty() || file_ < 0) return;
    // Nobody may be there any more.
    if (serial_) {
      static_cast<void>(!write(file_, frame.data(), frame.size()));
    } else {
      send(file_, frame.data(), frame.size(), MSG_NOSIGNAL);
    }
  }

  bool serial_;
  Dice dice_;
  std::string address_;
  int file_ = -1, listener_ = -1, kept_open_ = -1;
  std::vector<std::uint8_t> pending_;
  std::vector<std::vector<std::uint8_t>> held_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

// Most of these inputs take a time-out and a fence, so there are fewer of them.
void fuzz_the_fence(bool serial, std::uint32_t seed) {
  constexpr int share = 100;
  Dice dice(seed);
  Peer peer(serial, seed + 1);
  Client client(parse_endpoint(peer.address()), quick_line(10), {3, 10, 3}, 300);
  LinkFailure failure;
  BOOST_TEST_REQUIRE(client.connect(failure), failure.text);
  long good = 0, failed = 0;
  for (int i = 0; i < inputs() / share; ++i) {
    // No request of the cycle has the count of the fence.
    const Transaction t = any_request(dice, {1, 2, 4, 8});
    const std::vector<std::uint16_t> written(8, 7);
    std::vector<std::uint16_t> words = room_for(t);
    const int now = i % 60'000 + 1;
    peer.value = now;
    failure = {};
    if (client.transfer(t, written.data(), words.data(), failure)) {
      ++good;
      // What an answer to an older request says is older.
      for (int k = 0; k < t.read_count; ++k) BOOST_REQUIRE(words[static_cast<std::size_t>(k)] == now);
    } else {
      ++failed;
      BOOST_REQUIRE(failure.error != LinkError::none);
      BOOST_REQUIRE(!failure.text.empty());
    }
    BOOST_REQUIRE(is_kept(words));
    while (!client.connected() || failure.reopen) {
      failure = {};
      client.connect(failure);
    }
  }
  BOOST_TEST(good > 0);
  BOOST_TEST(failed > 0);
  BOOST_TEST(peer.late > 0);
  BOOST_TEST(client.fences() > 0U);
}

}  // namespace

BOOST_AUTO_TEST_CASE(answers_on_a_serial_line_to_every_function) {
  fuzz_answers(true, 20260101);
}

BOOST_AUTO_TEST_CASE(answers_over_tcp_to_every_function) {
  fuzz_answers(false, 20260102);
}

BOOST_AUTO_TEST_CASE(no_older_answer_is_believed_on_a_serial_line) {
  fuzz_the_fence(true, 20260103);
}

BOOST_AUTO_TEST_CASE(no_older_answer_is_believed_over_tcp) {
  fuzz_the_fence(false, 20260104);
}

BOOST_AUTO_TEST_CASE(every_word_has_a_value_and_goes_back_to_words) {
  Dice dice(7);
  for (int i = 0; i < 200'000; ++i) {
    RegisterInfo info;
    info.type = static_cast<RegisterType>(roll(dice, 0, 4));
    info.words = roll(dice, 0, 1) == 0 ? Order::high_first : Order::low_first;
    info.bytes = roll(dice, 0, 1) == 0 ? Order::high_first : Order::low_first;
    std::uint16_t words[2] = {static_cast<std::uint16_t>(roll(dice, 0, 65535)),
                              static_cast<std::uint16_t>(roll(dice, 0, 65535))};
    const double value = decode(info, words);
    std::uint16_t back[2] = {};
    encode(info, value, back);
    const double again = decode(info, back);
    // An infinite float comes back as the largest, not-a-number as zero.
    if (std::isfinite(value)) BOOST_REQUIRE(again == value);
    BOOST_REQUIRE(std::isfinite(again));
  }
}

BOOST_AUTO_TEST_CASE(mutated_register_maps_are_read_or_refused_with_a_place) {
  std::ifstream file(TACTOR_SOURCE_DIR "/devices/modbus/profiles/iris_orca.yaml");
  std::stringstream text;
  text << file.rdbuf();
  const std::string good = text.str();
  BOOST_REQUIRE(good.size() > 500);
  Dice dice(11);
  int read = 0, refused = 0;
  for (int i = 0; i < 5'000; ++i) {
    std::string mutated = good;
    for (int n = roll(dice, 1, 3); n > 0; --n) {
      const auto at = static_cast<std::size_t>(roll(dice, 0, static_cast<int>(mutated.size()) - 1));
      switch (roll(dice, 0, 3)) {
        case 0:
          mutated[at] = static_cast<char>(roll(dice, 0, 255));
          break;
        case 1:
          mutated.erase(at, static_cast<std::size_t>(roll(dice, 1, 20)));
          break;
        case 2:
          mutated.insert(at, std::string(1, "{}[]:,-#&*!|>'\"%@`0 9\n"[roll(dice, 0, 21)]));
          break;
        default:
          mutated.insert(at, mutated.substr(at, static_cast<std::size_t>(roll(dice, 1, 60))));
      }
      if (mutated.empty()) mutated = "x";
    }
    try {
      plan_cycle(parse_profile(mutated, "m.yaml"));
      ++read;
    } catch (const YamlError& error) {
      ++refused;
      BOOST_REQUIRE(std::string(error.what()).starts_with("m.yaml"));
    } catch (const InputError&) {
      ++refused;
    }
  }
  BOOST_TEST(read > 0);
  BOOST_TEST(refused > 1000);
}

BOOST_AUTO_TEST_SUITE_END()
