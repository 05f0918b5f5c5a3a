// The slot hands over whole messages, the newest that fits, and never one twice.
#include "framework/realtime/latest_slot.hpp"

#include <array>
#include <atomic>
#include <boost/test/unit_test.hpp>
#include <cstdint>
#include <limits>
#include <thread>

using namespace tactor;

namespace {

constexpr Time always{std::numeric_limits<std::int64_t>::max()};

Stamp stamp(std::uint64_t sequence, std::int64_t produced_ns) {
  return {Time{produced_ns - 1}, Time{produced_ns}, sequence};
}

void write(LatestSlot& slot, std::uint64_t sequence, std::int64_t produced_ns) {
  slot.write(stamp(sequence, produced_ns), &sequence);
}

/// The sequence taken, or -1 where there was none.
std::int64_t take(LatestSlot& slot, std::int64_t by_ns) {
  Stamp got;
  std::uint64_t payload = 0;
  if (!slot.take(Time{by_ns}, got, &payload)) return -1;
  BOOST_TEST(payload == got.sequence);
  BOOST_TEST(got.valid.ns == got.produced.ns - 1);
  return static_cast<std::int64_t>(got.sequence);
}

}  // namespace

BOOST_AUTO_TEST_CASE(an_empty_slot_gives_nothing_and_touches_nothing) {
  LatestSlot slot(sizeof(std::uint64_t));
  Stamp got = stamp(77, 5);
  std::uint64_t payload = 99;
  BOOST_TEST(!slot.take(always, got, &payload));
  BOOST_TEST(got.sequence == 77U);
  BOOST_TEST(payload == 99U);
}

BOOST_AUTO_TEST_CASE(a_message_is_taken_once) {
  LatestSlot slot(sizeof(std::uint64_t));
  write(slot, 3, 10);
  BOOST_TEST(take(slot, 10) == 3);
  BOOST_TEST(take(slot, 10) == -1);
  BOOST_TEST(take(slot, 1000) == -1);
}

BOOST_AUTO_TEST_CASE(the_newest_of_several_is_taken) {
  LatestSlot slot(sizeof(std::uint64_t));
  for (int i = 0; i < 100; ++i) write(slot, static_cast<std::uint64_t>(i), i);
  BOOST_TEST(take(slot, 1000) == 99);
  BOOST_TEST(take(slot, 1000) == -1);
}

BOOST_AUTO_TEST_CASE(a_message_that_is_too_new_waits_for_its_tick) {
  LatestSlot slot(sizeof(std::uint64_t));
  write(slot, 0, 11);
  BOOST_TEST(take(slot, 10) == -1);
  BOOST_TEST(take(slot, 10) == -1);
  BOOST_TEST(take(slot, 11) == 0);
}

BOOST_AUTO_TEST_CASE(a_message_that_waits_is_replaced_by_a_newer_one_that_fits) {
  LatestSlot slot(sizeof(std::uint64_t));
  write(slot, 0, 11);
  BOOST_TEST(take(slot, 10) == -1);
  write(slot, 1, 12);
  BOOST_TEST(take(slot, 20) == 1);
  BOOST_TEST(take(slot, 20) == -1);
}

BOOST_AUTO_TEST_CASE(a_message_that_waits_is_taken_when_the_newer_one_is_too_new) {
  LatestSlot slot(sizeof(std::uint64_t));
  write(slot, 0, 11);
  BOOST_TEST(take(slot, 10) == -1);
  write(slot, 1, 21);
  BOOST_TEST(take(slot, 20) == 0);
  BOOST_TEST(take(slot, 20) == -1);
  BOOST_TEST(take(slot, 30) == 1);
}

BOOST_AUTO_TEST_CASE(a_writer_in_step_with_the_reader_cannot_starve_it) {
  LatestSlot slot(sizeof(std::uint64_t));
  int taken = 0;
  // Each message comes just after a deadline and just before the reader, which woke late, looks.
  for (int tick = 0; tick < 100; ++tick) {
    write(slot, static_cast<std::uint64_t>(tick), 1000 * tick + 1);
    const std::int64_t got = take(slot, 1000 * tick);
    BOOST_TEST(got == tick - 1);
    taken += got >= 0 ? 1 : 0;
  }
  BOOST_TEST(taken == 99);
}

BOOST_AUTO_TEST_CASE(of_two_that_are_too_new_the_newer_stays) {
  LatestSlot slot(sizeof(std::uint64_t));
  write(slot, 0, 30);
  BOOST_TEST(take(slot, 10) == -1);
  write(slot, 1, 40);
  BOOST_TEST(take(slot, 10) == -1);
  BOOST_TEST(take(slot, 50) == 1);
  BOOST_TEST(take(slot, 50) == -1);
}

BOOST_AUTO_TEST_CASE(two_threads_see_whole_messages_in_order) {
  using Payload = std::array<std::uint64_t, 61>;
  LatestSlot slot(sizeof(Payload));
  constexpr std::uint64_t messages = 300'000;
  std::thread writer([&slot] {
    Payload payload{};
    for (std::uint64_t i = 1; i <= messages; ++i) {
      payload.fill(i * 0x9e3779b97f4a7c15ULL);
      slot.write(stamp(i, static_cast<std::int64_t>(i)), payload.data());
    }
  });
  std::uint64_t torn = 0;
  std::uint64_t disordered = 0;
  std::uint64_t too_new = 0;
  std::uint64_t last = 0;
  std::int64_t by = 0;
  Stamp got;
  Payload payload{};
  while (last < messages) {
    // Now and then the limit lags behind the writer, so that messages wait.
    by = last % 3 == 0 ? by + 50 : static_cast<std::int64_t>(messages);
    if (!slot.take(Time{by}, got, payload.data())) continue;
    disordered += got.sequence > last ? 0 : 1;
    too_new += got.produced > Time{by} ? 1 : 0;
    for (const std::uint64_t value : payload) torn += value == got.sequence * 0x9e3779b97f4a7c15ULL ? 0 : 1;
    last = got.sequence;
  }
  writer.join();
  BOOST_TEST(torn == 0U);
  BOOST_TEST(disordered == 0U);
  BOOST_TEST(too_new == 0U);
}
