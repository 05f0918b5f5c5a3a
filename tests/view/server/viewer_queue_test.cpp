// What waits for viewers of Foxglove stays within one bound, whatever they ask for and however little they read.
#include <boost/test/unit_test.hpp>
#include <chrono>
#include <list>

#include "app/view/server/request_meter.hpp"
#include "app/view/server/viewer_queue.hpp"

BOOST_AUTO_TEST_SUITE(viewer_queue_test)

using namespace tactor;

namespace {

ViewerMessage message(std::size_t bytes, bool kept = false) {
  return {"head", std::make_shared<const std::string>(bytes, 'x'), true, kept};
}

}  // namespace

BOOST_AUTO_TEST_CASE(samples_are_left_out_beyond_the_bound_of_one_viewer) {
  std::size_t of_all = 0;
  ViewerQueue queue(of_all);
  std::size_t taken = 0;
  for (int i = 0; i < 100'000; ++i) taken += queue.add_if_room(message(1000)) ? 1 : 0;
  BOOST_TEST(taken > 500U);
  BOOST_TEST(taken < 100'000U);
  BOOST_TEST(queue.bytes() <= ViewerQueue::most + message(1000).bytes());
  BOOST_TEST(of_all == queue.bytes());
}

BOOST_AUTO_TEST_CASE(viewers_that_read_nothing_share_one_bound) {
  std::size_t of_all = 0;
  std::list<ViewerQueue> queues;
  for (int viewer = 0; viewer < 100; ++viewer) {
    queues.emplace_back(of_all);
    for (int i = 0; i < 2000; ++i) queues.back().add_if_room(message(1000));
  }
  std::size_t sum = 0;
  for (const ViewerQueue& queue : queues) sum += queue.bytes();
  BOOST_TEST(of_all == sum);
  BOOST_TEST(of_all <= ViewerQueue::most_of_all + message(1000).bytes());
  // Whoever goes makes room for the others.
  BOOST_TEST(!queues.back().has_room());
  queues.pop_front();
  BOOST_TEST(queues.back().has_room());
  queues.clear();
  BOOST_TEST(of_all == 0U);
}

BOOST_AUTO_TEST_CASE(a_body_that_the_server_keeps_takes_no_more_than_its_head) {
  std::size_t of_all = 0;
  ViewerQueue queue(of_all);
  const auto body = std::make_shared<const std::string>(std::size_t{100} << 20U, 'x');
  for (int i = 0; i < 100; ++i) queue.add({"head", body, true, true});
  BOOST_TEST(queue.has_room());
  BOOST_TEST(of_all == 100 * (ViewerMessage::overhead + 4));
  BOOST_TEST(body.use_count() == 101);
}

BOOST_AUTO_TEST_CASE(bytes_count_until_they_are_sent) {
  std::size_t of_all = 0;
  ViewerQueue queue(of_all);
  queue.add(message(10));
  queue.add(message(20));
  const ViewerMessage first = queue.next();
  BOOST_TEST(first.body->size() == 10U);
  BOOST_TEST(of_all == message(10).bytes() + message(20).bytes());
  queue.sent(first);
  BOOST_TEST(of_all == message(20).bytes());
  queue.sent(queue.next());
  BOOST_TEST(of_all == 0U);
  BOOST_TEST(queue.empty());
}

BOOST_AUTO_TEST_CASE(a_client_gets_no_more_work_done_than_its_stock_and_what_time_adds) {
  using Clock = RequestMeter::Clock;
  for (const std::uint64_t bytes : {0U, 30U, 4'000U, 65'536U, 20'000'000U}) {
    Clock::time_point now{};
    RequestMeter meter(now);
    double work = 0;
    int requests = 0;
    // As a reader that waits as it is told, for a minute.
    while (now < Clock::time_point{} + std::chrono::seconds(60) && requests < 1'000'000) {
      now += meter.spend(bytes, now);
      work += static_cast<double>(bytes + RequestMeter::of_a_request);
      ++requests;
    }
    const double seconds = std::chrono::duration<double>(now.time_since_epoch()).count();
    const double allowed =
        static_cast<double>(RequestMeter::stock) + static_cast<double>(RequestMeter::a_second) * seconds;
    BOOST_TEST_CONTEXT(bytes << " bytes, " << requests << " requests") {
      BOOST_TEST(requests < 1'000'000);
      BOOST_TEST(work <= allowed * (1 + 1e-9));
    }
  }
}

BOOST_AUTO_TEST_CASE(a_viewer_that_asks_a_little_does_not_wait) {
  RequestMeter meter{RequestMeter::Clock::time_point{}};
  RequestMeter::Clock::time_point now{};
  for (int i = 0; i < 1000; ++i) {
    BOOST_TEST((meter.spend(500, now) == RequestMeter::Clock::duration::zero()));
    now += std::chrono::milliseconds(20);
  }
}

BOOST_AUTO_TEST_SUITE_END()
