// Answers byte by byte: whatever one of them has beside the words that were read must be that of the request.
#include <boost/test/data/test_case.hpp>
#include <boost/test/unit_test.hpp>

#include "devices/modbus/emulator/request.hpp"
#include "devices/modbus/frame.hpp"

BOOST_AUTO_TEST_SUITE(frame_test)

using namespace tactor;
using namespace tactor::modbus;

namespace frame_tests {

const std::vector<bool> both{false, true};
const std::vector<std::uint16_t> written{0x1234, 0x0102};

const std::vector<Transaction>& requests() {
  static const std::vector<Transaction> all{
      {.function = 3, .read_address = 10, .read_count = 2},
      {.function = 4, .read_address = 300, .read_count = 1},
      {.function = 6, .write_address = 40, .write_count = 1},
      {.function = 16, .write_address = 40, .write_count = 2},
      {.function = 23, .read_address = 10, .read_count = 3, .write_address = 40, .write_count = 2}};
  return all;
}

void put_sum(std::vector<std::uint8_t>& frame) {
  const std::uint16_t sum = check_sum(std::span<const std::uint8_t>(frame).first(frame.size() - 2));
  frame[frame.size() - 2] = static_cast<std::uint8_t>(sum & 0xffU);
  frame[frame.size() - 1] = static_cast<std::uint8_t>(sum >> 8);
}

/// The answer that the Modbus specification has for a request; every word that is read is 0x5a5a.
std::vector<std::uint8_t> good_answer(const Transaction& t, const Framing& framing) {
  std::vector<std::uint8_t> body{static_cast<std::uint8_t>(t.function)};
  if (t.read_count > 0) {
    body.push_back(static_cast<std::uint8_t>(2 * t.read_count));
    body.insert(body.end(), 2 * static_cast<std::size_t>(t.read_count), 0x5a);
  } else {
    const int second = t.function == 6 ? written[0] : t.write_count;
    for (const int word : {t.write_address, second}) {
      body.push_back(static_cast<std::uint8_t>(word >> 8));
      body.push_back(static_cast<std::uint8_t>(word & 0xff));
    }
  }
  std::vector<std::uint8_t> frame;
  if (!framing.serial) {
    frame = {static_cast<std::uint8_t>(framing.transaction >> 8),
             static_cast<std::uint8_t>(framing.transaction & 0xff),
             0,
             0,
             0,
             static_cast<std::uint8_t>(body.size() + 1)};
  }
  frame.push_back(static_cast<std::uint8_t>(framing.unit));
  frame.insert(frame.end(), body.begin(), body.end());
  if (framing.serial) {
    frame.resize(frame.size() + 2);
    put_sum(frame);
  }
  return frame;
}

std::vector<std::uint8_t> request_frame(const Transaction& t, const std::uint16_t* words, const Framing& framing) {
  std::vector<std::uint8_t> frame;
  put_request(t, words, framing, frame);
  return frame;
}

AnswerState judged(const std::vector<std::uint8_t>& frame, const Transaction& t, const Framing& framing) {
  return judge_answer(frame, t, request_frame(t, written.data(), framing), framing);
}

bool is_wrong(const AnswerState& state) {
  return state.kind == AnswerState::Kind::wrong;
}

}  // namespace frame_tests

using namespace frame_tests;

BOOST_AUTO_TEST_CASE(a_request_is_laid_out_as_the_specification_says) {
  // Function 3 of unit 17 for registers 107 to 109, the example of the Modbus specification with its published sum.
  const std::vector<std::uint8_t> serial{0x11, 0x03, 0x00, 0x6b, 0x00, 0x03, 0x76, 0x87};
  const Transaction t{.function = 3, .read_address = 107, .read_count = 3};
  const std::vector<std::uint8_t> line = request_frame(t, nullptr, {true, 17});
  BOOST_TEST(line == serial, boost::test_tools::per_element());
  const std::vector<std::uint8_t> header{0xab, 0xcd, 0, 0, 0, 6, 0x11, 0x03, 0x00, 0x6b, 0x00, 0x03};
  const std::vector<std::uint8_t> tcp = request_frame(t, nullptr, {false, 17, 0xabcd});
  BOOST_TEST(tcp == header, boost::test_tools::per_element());
}

BOOST_DATA_TEST_CASE(every_byte_that_an_answer_repeats_is_compared, both, serial) {
  const Framing framing{serial, 9, 0x0203};
  const std::size_t head = serial ? 1 : 7;
  for (const Transaction& t : requests()) {
    const std::vector<std::uint8_t> good = good_answer(t, framing);
    BOOST_TEST((judged(good, t, framing).kind == AnswerState::Kind::good));
    const std::size_t end = serial ? good.size() - 2 : good.size();
    for (std::size_t at = 0; at < end; ++at) {
      // What was read may be anything.
      if (t.read_count > 0 && at >= head + 2) continue;
      for (int flip = 1; flip < 256; ++flip) {
        std::vector<std::uint8_t> bad = good;
        bad[at] ^= static_cast<std::uint8_t>(flip);
        // A check sum that fits, so that it is the field itself that is compared.
        if (serial) put_sum(bad);
        // Bytes may follow that make a longer answer whole.
        bad.resize(bad.size() + 300);
        const AnswerState state = judged(bad, t, framing);
        BOOST_REQUIRE_MESSAGE(is_wrong(state), "function " << t.function << " byte " << at << " flipped by " << flip);
        BOOST_REQUIRE(!state.text.empty());
      }
    }
  }
}

BOOST_DATA_TEST_CASE(an_answer_is_read_to_its_end_and_no_further, both, serial) {
  const Framing framing{serial, 9, 0x0203};
  for (const Transaction& t : requests()) {
    const std::vector<std::uint8_t> good = good_answer(t, framing);
    std::size_t come = 0;
    for (int reads = 0; reads < 10; ++reads) {
      const AnswerState state = judged({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(come)}, t, framing);
      if (state.kind == AnswerState::Kind::good) break;
      BOOST_REQUIRE((state.kind == AnswerState::Kind::incomplete && state.missing > 0));
      come += state.missing;
      BOOST_REQUIRE(come <= good.size());
    }
    BOOST_TEST(come == good.size());
  }
}

BOOST_AUTO_TEST_CASE(every_single_flip_on_a_serial_line_is_seen_by_the_check_sum) {
  const Framing framing{true, 9};
  for (const Transaction& t : requests()) {
    const std::vector<std::uint8_t> good = good_answer(t, framing);
    for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
      std::vector<std::uint8_t> bad = good;
      bad[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
      bad.resize(bad.size() + 300);
      BOOST_TEST(is_wrong(judged(bad, t, framing)));
    }
  }
}

BOOST_DATA_TEST_CASE(an_exception_is_one_of_the_function_that_was_asked_for, both, serial) {
  const Framing framing{serial, 9, 7};
  const Transaction t = requests().front();
  const auto exception = [&](int function) {
    std::vector<std::uint8_t> frame =
        serial ? std::vector<std::uint8_t>{9} : std::vector<std::uint8_t>{0, 7, 0, 0, 0, 3, 9};
    frame.push_back(static_cast<std::uint8_t>(function));
    frame.push_back(4);
    if (serial) {
      frame.resize(frame.size() + 2);
      put_sum(frame);
    }
    return judged(frame, t, framing);
  };
  BOOST_CHECK(exception(0x83).error == LinkError::exception);
  BOOST_TEST(exception(0x83).exception == 4);
  BOOST_CHECK(exception(0x84).error == LinkError::protocol);
}

BOOST_DATA_TEST_CASE(what_the_client_asks_is_what_the_emulator_is_asked, both, serial) {
  const Framing framing{serial, 9, 0x0203};
  for (const Transaction& t : requests()) {
    const TakenRequest taken = take_request(request_frame(t, written.data(), framing), serial);
    BOOST_REQUIRE((taken.kind == TakenRequest::Kind::whole));
    BOOST_TEST(taken.request.exception == 0);
    BOOST_TEST(taken.request.unit == 9);
    BOOST_TEST(taken.request.what.read_address == t.read_address);
    BOOST_TEST(taken.request.what.read_count == t.read_count);
    BOOST_TEST(taken.request.what.write_address == t.write_address);
    BOOST_TEST(taken.request.written.size() == static_cast<std::size_t>(t.write_count));
  }
}

BOOST_AUTO_TEST_CASE(a_write_of_more_words_than_it_brings_is_refused_and_writes_nothing) {
  const Profile profile = read_profile(TACTOR_SOURCE_DIR "/devices/modbus/profiles/iris_orca.yaml");
  EmulatedDevice device(profile);
  // Two words of force at 28, one of them brought; the same by 23 with a read of the position at 342.
  const std::vector<std::vector<std::uint8_t>> short_ones{
      {0, 1, 0, 0, 0, 9, 1, 16, 0, 28, 0, 2, 2, 0x12, 0x34},
      {0, 1, 0, 0, 0, 13, 1, 23, 1, 0x56, 0, 2, 0, 28, 0, 2, 2, 0x12, 0x34}};
  for (const std::vector<std::uint8_t>& bytes : short_ones) {
    const TakenRequest taken = take_request(bytes, false);
    BOOST_REQUIRE((taken.kind == TakenRequest::Kind::whole));
    const std::vector<std::uint8_t> answer = answer_request(taken.request, false, device);
    BOOST_REQUIRE(answer.size() == 9U);
    BOOST_TEST(answer[7] == (bytes[7] | 0x80));
    BOOST_TEST(answer[8] == 3);  // illegal data value
    BOOST_TEST(device.state().commanded == 0.0);
    BOOST_TEST(device.state().commands == 0U);
  }
}

BOOST_AUTO_TEST_SUITE_END()
