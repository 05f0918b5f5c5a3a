// A page gets as many frames ahead as it may; what waits is joined, bounded and counted.
#include "app/view/server/frame_queue.hpp"

#include <boost/test/unit_test.hpp>
#include <cstring>

BOOST_AUTO_TEST_SUITE(frame_queue_test)

using namespace tactor;

namespace {

std::shared_ptr<const std::string> chunk(char c, std::size_t size = 8) {
  return std::make_shared<const std::string>(size, c);
}

std::uint64_t number_of(const std::string& frame) {
  std::uint64_t number = 0;
  std::memcpy(&number, frame.data() + 8, sizeof number);
  return number;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_page_that_draws_nothing_gets_eight_frames) {
  FrameQueue queue;
  for (std::uint64_t i = 1; i <= 8; ++i) {
    queue.add(chunk('a'));
    const auto frame = queue.next();
    BOOST_REQUIRE(frame.has_value());
    BOOST_TEST(number_of(*frame) == i);
  }
  queue.add(chunk('b'));
  BOOST_TEST(!queue.next().has_value());
  BOOST_TEST(queue.acknowledge(1));
  BOOST_TEST(queue.next().has_value());
}

BOOST_AUTO_TEST_CASE(what_waits_goes_in_one_frame_in_its_order) {
  FrameQueue queue;
  queue.add(chunk('a'));
  queue.add(chunk('b'));
  const auto frame = queue.next();
  BOOST_REQUIRE(frame.has_value());
  std::uint32_t chunks = 0;
  std::memcpy(&chunks, frame->data() + 4, sizeof chunks);
  BOOST_TEST(chunks == 2U);
  BOOST_TEST(frame->substr(16) == "aaaaaaaabbbbbbbb");
  BOOST_TEST(!queue.next().has_value());
}

BOOST_AUTO_TEST_CASE(a_blocked_page_finds_the_newest_second_and_the_rest_is_counted) {
  FrameQueue queue;
  for (int i = 0; i < 8; ++i) {
    queue.add(chunk('a'));
    BOOST_REQUIRE(queue.next().has_value());
  }
  for (std::size_t i = 0; i < 500; ++i) queue.add(chunk(i + 1 == 500 ? 'z' : 'y'));
  BOOST_TEST(queue.dropped() == 500 - FrameQueue::most_chunks);
  BOOST_TEST(queue.acknowledge(8));
  const auto frame = queue.next();
  BOOST_REQUIRE(frame.has_value());
  BOOST_TEST(frame->size() == 16 + 8 * FrameQueue::most_chunks);
  BOOST_TEST(frame->back() == 'z');
}

BOOST_AUTO_TEST_CASE(large_chunks_are_bounded_by_their_bytes) {
  FrameQueue queue;
  for (int i = 0; i < 5; ++i) queue.add(chunk('a', FrameQueue::most_bytes / 2));
  BOOST_TEST(queue.dropped() == 3U);
  BOOST_TEST(queue.next()->size() == 16 + FrameQueue::most_bytes);
  queue.add(chunk('b', 3 * FrameQueue::most_bytes));
  BOOST_TEST(queue.next()->size() == 16 + 3 * FrameQueue::most_bytes);
}

BOOST_AUTO_TEST_CASE(a_frame_that_was_never_sent_cannot_be_acknowledged) {
  FrameQueue queue;
  BOOST_TEST(!queue.acknowledge(1));
  queue.add(chunk('a'));
  BOOST_REQUIRE(queue.next().has_value());
  BOOST_TEST(queue.acknowledge(1));
  BOOST_TEST(queue.acknowledge(0));
  BOOST_TEST(!queue.acknowledge(2));
}

BOOST_AUTO_TEST_SUITE_END()
