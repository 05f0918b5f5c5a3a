// A real loop: nothing is allocated and no page faults in, what does is seen, and it starts, fails and stops as told.
#include "framework/realtime/periodic_loop.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <boost/test/unit_test.hpp>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "framework/core/segment.hpp"
#include "framework/node/edge_queue.hpp"
#include "framework/realtime/memory_lock.hpp"
#include "framework/realtime/ring.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(periodic_loop_test)

using namespace tactor;
namespace utf = boost::unit_test;

namespace {

constexpr Duration patience{10'000'000'000};

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
// A sanitizer maps its shadow memory at the first use of each page, in any thread, and takes most of a small stack.
constexpr bool page_faults_are_ours = false;
constexpr double fast_rate = 2'000;
#else
constexpr bool page_faults_are_ours = true;
constexpr double fast_rate = 20'000;
#endif

boost::test_tools::assertion_result memory_is_ours(utf::test_unit_id) {
  return boost::test_tools::assertion_result(page_faults_are_ours);
}

Instant soon() {
  return MonotonicClock::now() + Duration{20'000'000};
}

void wait_for(const LoopCounter& counter, std::int64_t value) {
  for (int i = 0; i < 60'000 && counter.value() < value; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  BOOST_REQUIRE(counter.value() >= value);
}

/// Writes segments and drains the ring, as the rest of a pipeline would, until it is destroyed.
class Pipeline {
 public:
  Pipeline(EdgeQueue& slot, Ring& ring, Instant origin) : slot_(slot), ring_(ring), origin_(origin) {
    thread_ = std::thread([this] { run(); });
  }
  ~Pipeline() { end(); }
  Pipeline(const Pipeline&) = delete;
  Pipeline& operator=(const Pipeline&) = delete;

  void end() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

  std::int64_t received = 0;
  std::int64_t disordered = 0;
  std::int64_t not_of_a_segment = 0;

 private:
  void run() {
    std::uint64_t sequence = 0;
    while (!stop_) {
      const Time now = Time{} + (MonotonicClock::now() - origin_);
      ++sequence;
      const auto level = static_cast<double>(sequence % 5);
      ForceSegment segment{now, now + Duration{10'000'000}};
      segment.c[0].force = Vec3{level, 2 * level, 3 * level};
      slot_.push({now, now, sequence}, &segment);
      drain();
      // Allocates on purpose, on this thread, which is not the one that is watched.
      allocated_ = std::make_unique<std::vector<double>>(static_cast<std::size_t>(100 + sequence % 100));
      std::this_thread::sleep_for(std::chrono::microseconds(300));
    }
    drain();
  }
  void drain() {
    RecordHeader header;
    Wrench force;
    while (ring_.pop(header, &force)) {
      ++received;
      disordered += header.tick > last_ ? 0 : 1;
      last_ = header.tick;
      not_of_a_segment += force.force.y == 2 * force.force.x && force.force.z == 3 * force.force.x ? 0 : 1;
    }
  }

  EdgeQueue& slot_;
  Ring& ring_;
  Instant origin_;
  std::unique_ptr<std::vector<double>> allocated_;
  std::int64_t last_ = -1;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace

BOOST_AUTO_TEST_CASE(sixty_thousand_ticks_allocate_nothing_and_fault_in_no_page) {
  const MemoryLock lock;
  EdgeQueue slot(sizeof(ForceSegment), alignof(ForceSegment), Queue{});
  Ring ring(65'536, sizeof(Wrench));
  ForceSegment segment;
  std::int64_t taken = 0;
  std::int64_t from_the_future = 0;
  PeriodicLoop loop({.name = "device", .rate = fast_rate}, [&](const Tick& tick) {
    slot.admit(tick.deadline);
    if (const MessageView view = slot.take()) {
      ++taken;
      from_the_future += view.stamp->produced > tick.deadline ? 1 : 0;
      std::memcpy(&segment, view.value, sizeof segment);
    }
    const Wrench force = evaluate(segment, tick.deadline);
    const RecordHeader header{1, sizeof force, tick.number, {tick.deadline, tick.deadline, 0}};
    ring.push(header, &force);
  });
  const Instant origin = soon();
  Pipeline pipeline(slot, ring, origin);
  loop.start(origin);
  const auto target = static_cast<std::int64_t>(3 * fast_rate);
  for (int i = 0; i < 60'000 && loop.metrics().begun.value() + loop.metrics().missed.value() < target; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  BOOST_REQUIRE(loop.stop(patience));
  pipeline.end();

  const LoopStatistics& metrics = loop.metrics();
  BOOST_TEST(metrics.begun.value() + metrics.missed.value() >= target);
  // A busy machine takes some ticks; it does not take most of them.
  BOOST_TEST(metrics.ended.value() > target / 2);
  BOOST_TEST(metrics.heap_calls.value() == 0);
  if (page_faults_are_ours) BOOST_TEST(metrics.page_faults.value() == 0);
  BOOST_TEST(metrics.clock_steps.value() == 0);
  BOOST_TEST(static_cast<std::int64_t>(metrics.wake_latency.count()) == metrics.begun.value());
  BOOST_TEST(static_cast<std::int64_t>(metrics.body_time.count()) == metrics.ended.value());
  BOOST_TEST(taken > 100);
  BOOST_TEST(from_the_future == 0);
  BOOST_TEST(pipeline.received + static_cast<std::int64_t>(ring.drops()) == metrics.ended.value());
  BOOST_TEST(pipeline.disordered == 0);
  BOOST_TEST(pipeline.not_of_a_segment == 0);
  BOOST_TEST_MESSAGE("p50 " << metrics.wake_latency.quantile(0.5).microseconds() << " us, p99 "
                            << metrics.wake_latency.quantile(0.99).microseconds() << " us, body p50 "
                            << metrics.body_time.quantile(0.5).ns << " ns, missed " << metrics.missed.value());
}

BOOST_AUTO_TEST_CASE(a_body_that_allocates_is_seen, *utf::precondition(test::heap_is_counted)) {
  std::unique_ptr<std::vector<double>> kept;
  PeriodicLoop loop({.name = "allocates"}, [&kept](const Tick& tick) {
    if (tick.number % 2 == 0) kept = std::make_unique<std::vector<double>>(100);
  });
  loop.start(soon());
  wait_for(loop.metrics().ended, 100);
  BOOST_TEST(loop.metrics().heap_calls.value() > 50);
  BOOST_REQUIRE(loop.stop(patience));
}

BOOST_AUTO_TEST_CASE(a_body_that_touches_fresh_pages_is_seen) {
  constexpr std::size_t page = 4096;
  constexpr std::size_t pages = 1000;
  void* mapped = mmap(nullptr, pages * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  BOOST_REQUIRE(mapped != MAP_FAILED);
  // Huge pages would fault once for many.
  madvise(mapped, pages * page, MADV_NOHUGEPAGE);
  auto* bytes = static_cast<volatile char*>(mapped);
  std::size_t touched = 0;
  PeriodicLoop loop({.name = "faults"}, [&](const Tick&) {
    if (touched < pages) bytes[touched++ * page] = 1;
  });
  loop.start(soon());
  wait_for(loop.metrics().ended, 300);
  BOOST_REQUIRE(loop.stop(patience));
  // One for each page after the warm-up.
  BOOST_TEST(loop.metrics().page_faults.value() >= static_cast<std::int64_t>(touched) - 10);
  munmap(mapped, pages * page);
}

BOOST_AUTO_TEST_CASE(the_first_tick_waits_for_its_time) {
  std::atomic<std::int64_t> first{0};
  PeriodicLoop loop({.name = "origin"}, [&](const Tick& tick) {
    if (first == 0) first = MonotonicClock::now().ns - tick.deadline.ns;
  });
  const Instant origin = MonotonicClock::now() + Duration{200'000'000};
  loop.start(origin);
  BOOST_TEST(loop.running());
  wait_for(loop.metrics().ended, 5);
  BOOST_REQUIRE(loop.stop(patience));
  BOOST_TEST(first >= origin.ns);
}

BOOST_AUTO_TEST_CASE(what_the_body_throws_ends_the_loop_and_is_kept) {
  PeriodicLoop loop({.name = "throws"}, [](const Tick& tick) {
    if (tick.number >= 5) throw std::runtime_error("the device is gone");
  });
  BOOST_TEST((loop.failure() == nullptr));
  loop.start(soon());
  for (int i = 0; i < 10'000 && loop.running(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  BOOST_TEST(!loop.running());
  BOOST_REQUIRE((loop.failure() != nullptr));
  BOOST_CHECK_EXCEPTION(
      std::rethrow_exception(loop.failure()), std::runtime_error,
      [](const std::runtime_error& error) { return std::string(error.what()) == "the device is gone"; });
  BOOST_TEST(loop.stop(patience));
}

BOOST_AUTO_TEST_CASE(a_body_that_hangs_shows_in_the_heartbeat_and_stop_gives_up) {
  std::atomic<bool> released{false};
  PeriodicLoop loop({.name = "hangs"}, [&](const Tick& tick) {
    while (tick.number >= 3 && !released) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  });
  loop.start(soon());
  for (int i = 0; i < 10'000 && loop.metrics().begun.value() == loop.metrics().ended.value(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const std::int64_t begun = loop.metrics().begun.value();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  BOOST_TEST(loop.metrics().begun.value() == begun);
  BOOST_TEST(loop.metrics().ended.value() == begun - 1);
  BOOST_TEST(!loop.stop(Duration{20'000'000}));
  BOOST_TEST(loop.running());
  released = true;
  BOOST_TEST(loop.stop(patience));
  BOOST_TEST(!loop.running());
}

BOOST_AUTO_TEST_CASE(a_loop_whose_body_hangs_can_be_left_behind) {
  // The body's data outlives the loop, as it must.
  static std::atomic<bool> released{false};
  static std::atomic<bool> left{false};
  {
    PeriodicLoop loop({.name = "left"}, [](const Tick&) {
      while (!released) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      left = true;
    });
    loop.start(soon());
    wait_for(loop.metrics().begun, 1);
  }
  BOOST_TEST(!left);
  released = true;
  for (int i = 0; i < 10'000 && !left; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  BOOST_TEST(left);
  // Long enough for the thread to end by itself.
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
}

BOOST_AUTO_TEST_CASE(a_loop_that_was_never_started_stops_at_once) {
  PeriodicLoop loop({.name = "idle"}, [](const Tick&) {});
  BOOST_TEST(!loop.running());
  BOOST_TEST(loop.stop(Duration{0}));
}

BOOST_AUTO_TEST_CASE(the_stack_is_as_large_as_asked_for, *utf::precondition(memory_is_ours)) {
  std::atomic<bool> done{false};
  PeriodicLoop loop({.name = "stack", .stack_size = std::size_t{512} * 1024, .warm_up_ticks = 0}, [&](const Tick&) {
    std::array<volatile char, 400 * 1024> deep;
    for (std::size_t i = 0; i < deep.size(); i += 1024) deep[i] = 1;
    done = deep[0] == 1;
  });
  loop.start(soon());
  wait_for(loop.metrics().ended, 20);
  BOOST_REQUIRE(loop.stop(patience));
  BOOST_TEST(done);
  // The pages were there before the body went deep.
  BOOST_TEST(loop.metrics().page_faults.value() < 50);
}

BOOST_AUTO_TEST_SUITE_END()
