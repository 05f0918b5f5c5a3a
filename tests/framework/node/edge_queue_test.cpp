// An edge's queue against a model of each policy, in one thread and in two.
#include "framework/node/edge_queue.hpp"
#include "framework/core/describe.hpp"
#include "tests/scan_nodes/scan.hpp"

#include <algorithm>
#include <array>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <boost/test/unit_test.hpp>
#include <deque>
#include <optional>
#include <thread>

BOOST_AUTO_TEST_SUITE(edge_queue_test)

using namespace tactor;

namespace {

/// Large enough that a torn copy shows.
using Payload = std::array<std::uint64_t, 31>;

struct Block {
  Payload numbers;
};

const MessageType& payload_type() {
  static const MessageType type = Describe<Block>("test.Block").field("numbers", "1", &Block::numbers).type();
  return type;
}

Payload payload_of(std::uint64_t sequence) {
  Payload payload;
  payload.fill(sequence * 0x9e3779b97f4a7c15ULL);
  return payload;
}

Stamp stamp_of(std::uint64_t sequence) {
  const auto t = static_cast<std::int64_t>(10 * sequence);
  return {Time{t - 1}, Time{t}, sequence};
}

/// The sequence of a message that is whole; -1 for none, -2 for a torn one.
std::int64_t sequence_of(const MessageView& view) {
  if (!view) return -1;
  const Payload expected = payload_of(view.stamp->sequence);
  const bool whole = std::memcmp(view.value, &expected, sizeof expected) == 0 &&
                     view.stamp->produced.ns == static_cast<std::int64_t>(10 * view.stamp->sequence) &&
                     view.stamp->valid.ns == view.stamp->produced.ns - 1;
  return whole ? static_cast<std::int64_t>(view.stamp->sequence) : -2;
}

bool push(EdgeQueue& queue, std::uint64_t sequence) {
  const Payload payload = payload_of(sequence);
  return queue.push(stamp_of(sequence), payload.data());
}

/// What a queue does, written down as lists.
class Model {
 public:
  explicit Model(Queue queue) : queue_(queue) {}

  bool push(std::uint64_t sequence) {
    if (arrived_.size() >= queue_.capacity) {
      if (queue_.policy == QueuePolicy::block) return false;
      if (queue_.policy == QueuePolicy::drop_newest) {
        ++dropped;
        return false;
      }
      arrived_.pop_front();
      ++(queue_.policy == QueuePolicy::latest ? superseded : dropped);
    }
    arrived_.push_back(sequence);
    return true;
  }

  void admit(std::int64_t by) {
    while (queue_.policy != QueuePolicy::block || unread_.size() < queue_.capacity) {
      // The reader keeps one that is too new, which makes room among those that have arrived.
      if (!ahead_ && !arrived_.empty()) {
        ahead_ = arrived_.front();
        arrived_.pop_front();
      }
      if (!ahead_ || static_cast<std::int64_t>(10 * *ahead_) > by) return;
      show(*ahead_);
      ahead_.reset();
    }
  }

  std::int64_t take() {
    if (unread_.empty()) return -1;
    const std::uint64_t sequence = unread_.front();
    unread_.pop_front();
    return static_cast<std::int64_t>(sequence);
  }
  void mark_seen() {
    if (queue_.policy == QueuePolicy::latest) unread_.clear();
  }
  [[nodiscard]] std::size_t unread() const { return unread_.size(); }
  [[nodiscard]] std::size_t arrived() const { return arrived_.size(); }

  std::int64_t newest = -1;
  std::uint64_t dropped = 0, superseded = 0;

 private:
  void show(std::uint64_t sequence) {
    if (unread_.size() >= queue_.capacity) {
      if (queue_.policy == QueuePolicy::latest) {
        ++superseded;
        unread_.clear();
      } else {
        ++dropped;
        if (queue_.policy != QueuePolicy::drop_oldest) return;
        unread_.pop_front();
      }
    }
    unread_.push_back(sequence);
    newest = static_cast<std::int64_t>(sequence);
  }

  Queue queue_;
  std::deque<std::uint64_t> arrived_, unread_;
  std::optional<std::uint64_t> ahead_;
};

constexpr std::array policies{QueuePolicy::latest, QueuePolicy::drop_oldest, QueuePolicy::drop_newest,
                              QueuePolicy::block};

}  // namespace

BOOST_AUTO_TEST_CASE(an_empty_queue_gives_nothing) {
  for (const QueuePolicy policy : policies) {
    EdgeQueue queue(payload_type(), {policy, 1});
    queue.admit();
    BOOST_TEST(!queue.newest());
    BOOST_TEST(!queue.take());
    BOOST_TEST(queue.unread() == 0U);
    BOOST_TEST(queue.arrived() == 0U);
  }
}

BOOST_AUTO_TEST_CASE(what_has_arrived_is_seen_once_it_is_admitted) {
  EdgeQueue queue(payload_type(), {QueuePolicy::drop_oldest, 4});
  push(queue, 1);
  BOOST_TEST(queue.unread() == 0U);
  BOOST_TEST(!queue.newest());
  queue.admit();
  push(queue, 2);
  BOOST_TEST(sequence_of(queue.newest()) == 1);
  BOOST_TEST(sequence_of(queue.take()) == 1);
  BOOST_TEST(!queue.take());
  // It stays the newest, taken or not.
  BOOST_TEST(sequence_of(queue.newest()) == 1);
}

BOOST_AUTO_TEST_CASE(a_message_that_is_too_new_waits_and_nothing_replaces_it) {
  EdgeQueue queue(payload_type(), {QueuePolicy::latest, 1});
  push(queue, 3);
  queue.admit(Time{29});
  BOOST_TEST(!queue.newest());
  // A writer in step with the reader, always a moment too late.
  for (std::uint64_t sequence = 4; sequence < 20; ++sequence) {
    push(queue, sequence);
    queue.admit(Time{static_cast<std::int64_t>(10 * sequence) - 1});
    BOOST_TEST(sequence_of(queue.newest()) == static_cast<std::int64_t>(sequence) - 1);
  }
}

BOOST_AUTO_TEST_CASE(every_policy_does_what_its_model_does) {
  for (const QueuePolicy policy : policies) {
    for (const std::uint32_t capacity : {1U, 2U, 3U, 7U}) {
      if (policy == QueuePolicy::latest && capacity > 1) continue;
      for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        boost::random::mt19937_64 random(seed);
        const auto draw = [&random](int most) { return boost::random::uniform_int_distribution<int>(0, most)(random); };
        EdgeQueue queue(payload_type(), {policy, capacity});
        Model model({policy, capacity});
        std::uint64_t sequence = 0;
        // Seeds differ in how much of each is done.
        const int pushes = 1 + draw(6), admits = 1 + draw(3), takes = draw(6);
        for (int i = 0; i < 2000; ++i) {
          const int what = draw(pushes + admits + takes);
          if (what < pushes) {
            ++sequence;
            BOOST_REQUIRE(push(queue, sequence) == model.push(sequence));
          } else if (what < pushes + admits) {
            const std::int64_t by = draw(3) == 0 ? INT64_MAX : static_cast<std::int64_t>(10 * sequence) - 10 * draw(4);
            queue.admit(Time{by});
            model.admit(by);
          } else if (what < pushes + admits + takes) {
            BOOST_REQUIRE(sequence_of(queue.take()) == model.take());
          } else {
            queue.mark_seen();
            model.mark_seen();
          }
          BOOST_REQUIRE(sequence_of(queue.newest()) == model.newest);
          BOOST_REQUIRE(queue.unread() == model.unread());
          BOOST_REQUIRE(queue.arrived() == model.arrived());
          BOOST_REQUIRE(queue.dropped() == model.dropped);
          BOOST_REQUIRE(queue.superseded() == model.superseded);
        }
      }
    }
  }
}

BOOST_AUTO_TEST_CASE(two_threads_lose_what_the_policy_says_and_count_it_once) {
  constexpr std::uint64_t messages = 50'000;
  for (const QueuePolicy policy : policies) {
    for (const std::uint32_t capacity : {1U, 8U}) {
      if (policy == QueuePolicy::latest && capacity > 1) continue;
      EdgeQueue queue(payload_type(), {policy, capacity});
      std::uint64_t refused = 0;
      std::thread writer([&] {
        for (std::uint64_t i = 1; i <= messages; ++i) {
          // The writer of a `block` edge waits.
          while (!push(queue, i)) {
            if (policy != QueuePolicy::block) {
              ++refused;
              break;
            }
            std::this_thread::yield();
          }
        }
      });
      std::uint64_t taken = 0, torn = 0, disordered = 0, too_new = 0, last = 0;
      std::int64_t by = 0;
      bool done = false;
      for (std::uint64_t round = 0;; ++round) {
        // Time goes on by ten messages a round, so that messages wait.
        by = done ? INT64_MAX : by + 100;
        queue.admit(Time{by});
        if (round % 5 == 4) continue;
        bool any = false;
        for (MessageView view = queue.take(); view; view = queue.take()) {
          any = true;
          const std::int64_t sequence = sequence_of(view);
          torn += sequence < 0 ? 1 : 0;
          too_new += view.stamp->produced.ns > by ? 1 : 0;
          disordered += view.stamp->sequence > last ? 0 : 1;
          last = view.stamp->sequence;
          ++taken;
        }
        if (done && !any) break;
        // On a busy machine the writer would wait for this thread's whole slice of time.
        if (!any) std::this_thread::yield();
        if (!any && writer.joinable() && queue.arrived() == 0) {
          // It may have ended: join it once its last message, or the loss of it, has been seen.
          if (last == messages || taken + queue.dropped() + queue.superseded() >= messages) {
            writer.join();
            done = true;
          }
        }
      }
      if (writer.joinable()) writer.join();
      BOOST_TEST(torn == 0U);
      BOOST_TEST(disordered == 0U);
      BOOST_TEST(too_new == 0U);
      BOOST_TEST(taken + queue.dropped() + queue.superseded() == messages);
      // Only these two policies may lose the last message; who drops the oldest never loses the newest.
      if (policy == QueuePolicy::latest || policy == QueuePolicy::drop_oldest) BOOST_TEST(last == messages);
      if (policy == QueuePolicy::block) BOOST_TEST(taken == messages);
      if (policy == QueuePolicy::drop_newest) BOOST_TEST(queue.dropped() >= refused);
    }
  }
}

BOOST_AUTO_TEST_CASE(arrays_come_through_whole_and_go_back_to_their_pool) {
  for (const QueuePolicy policy :
       {QueuePolicy::latest, QueuePolicy::drop_oldest, QueuePolicy::drop_newest, QueuePolicy::block}) {
    constexpr std::uint32_t capacity = 3;
    // As many arrays as the queue may keep, and one that is being made. make() would throw where there were too few.
    ScanMaker maker(2 * capacity + 4 + 1, 5);
    {
      EdgeQueue queue(message_type<Scan>(), {policy, capacity});
      std::int64_t expected = 0;
      for (std::int64_t n = 0; n < 200; ++n) {
        const Scan scan = maker.make(n);
        queue.push(stamp_of(static_cast<std::uint64_t>(n)), &scan);
        if (n % 5 != 4) continue;
        queue.admit();
        while (const MessageView view = queue.take()) {
          const auto number = static_cast<std::int64_t>(view.stamp->sequence);
          BOOST_REQUIRE(number >= expected);
          expected = number + 1;
          BOOST_REQUIRE(same_scan(*reinterpret_cast<const Scan*>(view.value), ScanMaker(1, 5).make(number)));
        }
      }
      BOOST_TEST(expected > 150);
    }
    std::vector<Scan> all;
    for (std::size_t i = 0; i < 2 * capacity + 5; ++i) all.push_back(maker.make(1));
    BOOST_CHECK_THROW(maker.make(1), std::bad_optional_access);
  }
}

BOOST_AUTO_TEST_CASE(two_threads_pass_arrays_on) {
  ScanMaker maker(2 * 4 + 4 + 1, 5);
  EdgeQueue queue(message_type<Scan>(), {QueuePolicy::drop_oldest, 4});
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (std::int64_t n = 0; n < 20000; ++n) {
      const Scan scan = maker.make(n);
      queue.push(stamp_of(static_cast<std::uint64_t>(n)), &scan);
    }
    done = true;
  });
  ScanMaker again(1, 5);
  int wrong = 0;
  for (bool last = false; !last;) {
    last = done;
    queue.admit();
    while (const MessageView view = queue.take()) {
      const Scan expected = again.make(static_cast<std::int64_t>(view.stamp->sequence));
      if (!same_scan(*reinterpret_cast<const Scan*>(view.value), expected)) ++wrong;
    }
  }
  writer.join();
  BOOST_TEST(wrong == 0);
}

BOOST_AUTO_TEST_SUITE_END()
