// The ring keeps order, loses only what it counts, and tears nothing.
#include "framework/realtime/ring.hpp"

#include <array>
#include <atomic>
#include <boost/test/unit_test.hpp>
#include <cstdint>
#include <thread>

BOOST_AUTO_TEST_SUITE(ring_test)

using namespace tactor;

namespace {

bool push(Ring& ring, std::uint64_t value) {
  const auto number = static_cast<std::int64_t>(value);
  const RecordHeader header{static_cast<std::int32_t>(value % 7), sizeof value, number, {{}, Time{number}, value}};
  return ring.push(header, &value);
}

/// The value popped, or -1 where the ring is empty.
std::int64_t pop(Ring& ring) {
  RecordHeader header;
  std::array<std::uint64_t, 8> payload{};
  if (!ring.pop(header, payload.data())) return -1;
  const auto number = static_cast<std::int64_t>(payload[0]);
  BOOST_TEST(header.size == sizeof(std::uint64_t));
  BOOST_TEST(header.port == static_cast<std::int32_t>(payload[0] % 7));
  BOOST_TEST(header.tick == number);
  BOOST_TEST(header.stamp.sequence == payload[0]);
  BOOST_TEST(header.stamp.produced.ns == number);
  return number;
}

}  // namespace

BOOST_AUTO_TEST_CASE(records_come_out_as_they_went_in) {
  Ring ring(3, 64);
  BOOST_TEST(pop(ring) == -1);
  std::uint64_t in = 0;
  std::int64_t out = 0;
  // Twelve laps with one to three records inside, whatever the place in the ring.
  for (int lap = 0; lap < 12; ++lap) {
    for (int i = 0; i <= lap % 3; ++i) BOOST_TEST(push(ring, in++));
    for (int i = 0; i <= lap % 3; ++i) BOOST_TEST(pop(ring) == out++);
    BOOST_TEST(pop(ring) == -1);
  }
  BOOST_TEST(ring.drops() == 0U);
}

BOOST_AUTO_TEST_CASE(a_full_ring_drops_the_newest_and_counts_it) {
  Ring ring(4, 64);
  for (std::uint64_t i = 0; i < 4; ++i) BOOST_TEST(push(ring, i));
  BOOST_TEST(!push(ring, 100));
  BOOST_TEST(!push(ring, 101));
  BOOST_TEST(ring.drops() == 2U);
  BOOST_TEST(pop(ring) == 0);
  BOOST_TEST(push(ring, 4));
  for (int i = 1; i < 5; ++i) BOOST_TEST(pop(ring) == i);
  BOOST_TEST(pop(ring) == -1);
  BOOST_TEST(ring.drops() == 2U);
}

BOOST_AUTO_TEST_CASE(a_ring_of_one_works) {
  Ring ring(1, 64);
  for (std::uint64_t i = 0; i < 5; ++i) {
    BOOST_TEST(push(ring, i));
    BOOST_TEST(!push(ring, i));
    BOOST_TEST(pop(ring) == static_cast<std::int64_t>(i));
  }
  BOOST_TEST(ring.drops() == 5U);
}

BOOST_AUTO_TEST_CASE(payloads_may_differ_in_size) {
  Ring ring(4, 64);
  std::array<unsigned char, 64> bytes{};
  for (std::uint32_t size : {64U, 1U, 0U, 17U}) {
    bytes.fill(static_cast<unsigned char>(size));
    BOOST_TEST(ring.push({.port = 1, .size = size}, size == 0 ? nullptr : bytes.data()));
  }
  for (std::uint32_t size : {64U, 1U, 0U, 17U}) {
    RecordHeader header;
    std::array<unsigned char, 64> got{};
    BOOST_TEST(ring.pop(header, got.data()));
    BOOST_TEST(header.size == size);
    for (std::size_t i = 0; i < got.size(); ++i) BOOST_TEST(got[i] == (i < size ? size : 0U));
  }
}

BOOST_AUTO_TEST_CASE(two_threads_lose_only_what_is_counted) {
  using Payload = std::array<std::uint64_t, 29>;
  constexpr std::uint64_t records = 400'000;
  Ring ring(64, sizeof(Payload));
  std::uint64_t refused = 0;
  std::atomic<bool> done{false};
  std::thread producer([&] {
    Payload payload{};
    for (std::uint64_t i = 1; i <= records; ++i) {
      payload.fill(~i);
      if (!ring.push({.port = 2, .size = sizeof payload, .tick = static_cast<std::int64_t>(i)}, payload.data())) {
        ++refused;
        // Lets the consumer run where both share a core, so that not everything is dropped.
        std::this_thread::yield();
      }
    }
    done.store(true, std::memory_order_release);
  });
  std::uint64_t received = 0;
  std::uint64_t torn = 0;
  std::uint64_t disordered = 0;
  std::int64_t last = 0;
  RecordHeader header;
  Payload payload{};
  while (true) {
    const bool ended = done.load(std::memory_order_acquire);
    if (!ring.pop(header, payload.data())) {
      if (ended) break;
      continue;
    }
    ++received;
    disordered += header.tick > last ? 0 : 1;
    last = header.tick;
    for (const std::uint64_t value : payload) torn += value == ~static_cast<std::uint64_t>(header.tick) ? 0 : 1;
  }
  producer.join();
  BOOST_TEST(torn == 0U);
  BOOST_TEST(disordered == 0U);
  BOOST_TEST(refused == ring.drops());
  BOOST_TEST(received + ring.drops() == records);
  BOOST_TEST(received >= ring.capacity());
}

BOOST_AUTO_TEST_SUITE_END()
