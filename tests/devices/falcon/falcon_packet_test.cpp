// The Falcon's packets: the published form, round trips, and a million spoilt streams.
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <boost/test/unit_test.hpp>
#include <string>

#include "devices/falcon/packet.hpp"

BOOST_AUTO_TEST_SUITE(falcon_packet_test)

using namespace tactor;

namespace {

std::string text(const FalconPacket& packet) {
  return {packet.begin(), packet.end()};
}

}  // namespace

BOOST_AUTO_TEST_CASE(an_order_is_written_as_published) {
  // 0x1234 is nibbles 4, 3, 2, 1 from the lowest on, each added to 'A'; -1 is F four times.
  FalconOrder order{{0x1234, -1, 0}, FalconOrder::green, false};
  BOOST_TEST(text(encode(order)) == "<EDCBPPPPAAAACA>");
  order.home = true;
  BOOST_TEST(text(encode(order)) == "<EDCBPPPPAAAADA>");
}

BOOST_AUTO_TEST_CASE(a_state_is_read_as_published) {
  const std::string packet =
      "<EDCBPPPPAAAA\xb2"
      "A>";  // 0x71 + 0x41: all homed, button 1
  const auto state = decode_state({reinterpret_cast<const std::uint8_t*>(packet.data()), packet.size()});
  BOOST_TEST_REQUIRE(state.has_value());
  BOOST_TEST(state->counts[0] == 0x1234);
  BOOST_TEST(state->counts[1] == -1);
  BOOST_TEST(state->counts[2] == 0);
  BOOST_TEST(state->grip == 1);
  BOOST_TEST(state->all_homed());
}

BOOST_AUTO_TEST_CASE(one_homed_encoder_is_not_all) {
  FalconState state;
  for (std::uint8_t homed = 0; homed < 8; ++homed) {
    state.homed = homed;
    BOOST_TEST(state.all_homed() == (homed == 7));
  }
}

BOOST_AUTO_TEST_CASE(every_number_goes_there_and_back) {
  for (int value = -32768; value <= 32767; value += 7) {
    const auto number = static_cast<std::int16_t>(value);
    const FalconState state{{number, static_cast<std::int16_t>(~number), 5},
                            static_cast<std::uint8_t>(value & 0xf),
                            static_cast<std::uint8_t>((value >> 4) & 7)};
    const auto state_back = decode_state(encode(state));
    BOOST_TEST_REQUIRE((state_back && *state_back == state));
    const FalconOrder order{{number, 0, static_cast<std::int16_t>(-value)}, FalconOrder::blue, (value & 1) != 0};
    const auto order_back = decode_order(encode(order));
    BOOST_TEST_REQUIRE((order_back && *order_back == order));
  }
}

BOOST_AUTO_TEST_CASE(a_million_spoilt_packets_give_a_state_or_none) {
  boost::random::mt19937_64 random(20260101);
  boost::random::uniform_int_distribution<int> byte(0, 255), kind(0, 3), place(0, 15), number(-32768, 32767);
  FalconStream stream;
  std::uint64_t packets = 0, decoded = 0, bytes = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    FalconState state;
    for (auto& count : state.counts) count = static_cast<std::int16_t>(number(random));
    state.homed = 7;
    FalconPacket packet = encode(state);
    std::size_t size = packet.size();
    const int what = kind(random);
    if (what == 1) packet[static_cast<std::size_t>(place(random))] = static_cast<std::uint8_t>(byte(random));
    if (what == 2) size = static_cast<std::size_t>(place(random));
    if (what == 3) {
      for (auto& b : packet) b = static_cast<std::uint8_t>(byte(random));
    }
    for (std::size_t n = 0; n < size; ++n) {
      ++bytes;
      if (!stream.take(packet[n])) continue;
      ++packets;
      const auto got = decode_state(stream.packet());
      if (!got) continue;
      ++decoded;
      // What was taken for a packet is one: it reads the same when written again.
      const auto again = decode_state(encode(*got));
      BOOST_TEST_REQUIRE((again && *again == *got));
    }
  }
  // A quarter is whole; one in two of those after a spoilt one is not lost with it.
  BOOST_TEST(decoded > 200'000U);
  BOOST_TEST(packets >= decoded);
  BOOST_TEST(stream.stray() + packets * falcon_packet_size <= bytes);
}

BOOST_AUTO_TEST_CASE(a_whole_packet_after_a_cut_one_is_found) {
  const FalconPacket packet = encode(FalconState{{1, 2, 3}, 0, 7});
  for (std::size_t cut = 1; cut < packet.size(); ++cut) {
    FalconStream stream;
    int found = 0;
    for (std::size_t n = 0; n < cut; ++n) found += stream.take(packet[n]) ? 1 : 0;
    for (const std::uint8_t b : packet) found += stream.take(b) ? 1 : 0;
    BOOST_TEST(found == 1);
    BOOST_TEST(stream.stray() == cut);
  }
}

BOOST_AUTO_TEST_SUITE_END()
