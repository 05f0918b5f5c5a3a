// Bytes that no device means: answers and register maps from a seeded generator. Nothing may crash, hang or be believed
// that is no answer.
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <fstream>
#include <sstream>

#include "devices/modbus/client.hpp"

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

/// A good answer to a read of two words, then changed: bytes flipped, cut, added, or all of them noise.
std::vector<std::uint8_t> mutated(Dice& dice, bool serial, bool& changed) {
  std::vector<std::uint8_t> frame;
  const std::array<std::uint8_t, 6> body{3, 4, 0x12, 0x34, 0x56, 0x78};
  if (serial) {
    frame = {1};
    frame.insert(frame.end(), body.begin(), body.end());
    const std::uint16_t sum = check_sum(frame.data(), frame.size());
    frame.push_back(static_cast<std::uint8_t>(sum & 0xffU));
    frame.push_back(static_cast<std::uint8_t>(sum >> 8));
  } else {
    frame = {0, 1, 0, 0, 0, 7, 1};
    frame.insert(frame.end(), body.begin(), body.end());
  }
  const std::vector<std::uint8_t> good = frame;
  const int kind = roll(dice, 0, 6);
  if (kind == 0) {
    frame.resize(static_cast<std::size_t>(roll(dice, 0, 300)));
    for (std::uint8_t& byte : frame) byte = static_cast<std::uint8_t>(roll(dice, 0, 255));
  } else {
    for (int i = 0, n = roll(dice, 1, 4); i < n; ++i) {
      frame[static_cast<std::size_t>(roll(dice, 0, static_cast<int>(frame.size()) - 1))] =
          static_cast<std::uint8_t>(roll(dice, 0, 255));
    }
    if (kind == 1) frame.resize(static_cast<std::size_t>(roll(dice, 0, static_cast<int>(frame.size()))));
    if (kind == 2) frame.insert(frame.end(), static_cast<std::size_t>(roll(dice, 1, 300)), 0x5a);
    // A frame with a right check sum around a wrong answer goes further in.
    if (serial && kind >= 4 && frame.size() >= 3) {
      const std::uint16_t sum = check_sum(frame.data(), frame.size() - 2);
      frame[frame.size() - 2] = static_cast<std::uint8_t>(sum & 0xffU);
      frame[frame.size() - 1] = static_cast<std::uint8_t>(sum >> 8);
    }
  }
  changed = frame != good;
  return frame;
}

struct Outcome {
  long good = 0, failed = 0, values_from_nowhere = 0;
};

Outcome fuzz(bool serial, int inputs, std::uint32_t seed) {
  Dice dice(seed);
  Outcome outcome;
  LineSettings line;
  line.baud = 115200;
  line.silence = Duration{};
  Client client(parse_endpoint(serial ? "rtu:/dev/null" : "tcp:127.0.0.1:1"), line, {}, 9);
  for (int i = 0; i < inputs; ++i) {
    bool changed = false;
    const std::vector<std::uint8_t> frame = mutated(dice, serial, changed);
    int pair[2];
    BOOST_REQUIRE(socketpair(AF_UNIX, SOCK_STREAM, 0, pair) == 0);
    // All that will come is there, and then the end, so that nothing is waited for.
    if (!frame.empty()) BOOST_REQUIRE(send(pair[1], frame.data(), frame.size(), MSG_NOSIGNAL) > 0);
    shutdown(pair[1], SHUT_WR);
    client.attach(pair[0]);
    std::array<std::uint16_t, 4> words{0, 0, 0xdead, 0xbeef};
    LinkFailure failure;
    if (client.transfer({.function = 3, .read_address = 10, .read_count = 2}, nullptr, words.data(), failure)) {
      ++outcome.good;
    } else {
      ++outcome.failed;
      BOOST_REQUIRE(failure.error != LinkError::none);
      BOOST_REQUIRE(!failure.text.empty());
    }
    // Nothing is ever written beyond what was asked for.
    if (words[2] != 0xdead || words[3] != 0xbeef) ++outcome.values_from_nowhere;
    client.disconnect();
    close(pair[1]);
  }
  return outcome;
}

void fuzz_answers(bool serial, int inputs, std::uint32_t seed) {
  const Outcome outcome = fuzz(serial, inputs, seed);
  BOOST_TEST(outcome.values_from_nowhere == 0);
  BOOST_TEST(outcome.good + outcome.failed == inputs);
  // Some changes leave a right answer, most do not.
  BOOST_TEST(outcome.good > 0);
  BOOST_TEST(outcome.failed > outcome.good);
}

}  // namespace

BOOST_AUTO_TEST_CASE(half_a_million_answers_on_a_serial_line) {
  fuzz_answers(true, 500'000, 20260101);
}

BOOST_AUTO_TEST_CASE(half_a_million_answers_over_tcp) {
  fuzz_answers(false, 500'000, 20260102);
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
