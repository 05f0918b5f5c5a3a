// What a tap costs who sends into it: a push at 1 kHz while a reader takes all of it forty times a second, and while
// none does. A device of a view pushes into four taps each tick, so for it the time of four is divided by four.
//
// tap_bench [--seconds S]: prints JSON.
#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <string_view>
#include <thread>
#include <vector>

#include "framework/core/messages.hpp"
#include "framework/engine/tap.hpp"
#include "framework/realtime/latency_histogram.hpp"
#include "framework/realtime/monotonic_clock.hpp"

using namespace tactor;

namespace {

template <class T>
nlohmann::ordered_json row(const char* message, std::int64_t tap_count, bool is_read, double seconds) {
  std::vector<std::unique_ptr<Tap>> taps;
  for (std::int64_t i = 0; i < tap_count; ++i) {
    taps.push_back(std::make_unique<Tap>(message_type<T>(), Queue{QueuePolicy::drop_oldest, 2048}));
  }
  std::atomic<bool> ended{false};
  std::thread reader([&] {
    while (is_read && !ended) {
      for (const auto& tap : taps) {
        while (tap->take()) {
        }
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(25));
    }
  });
  LatencyHistogram push_time;
  T value{};
  Instant next = MonotonicClock::now();
  for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(seconds * 1000); ++i) {
    next = next + Duration{1'000'000};
    MonotonicClock::sleep_until(next);
    const Instant begin = MonotonicClock::now();
    for (const auto& tap : taps) tap->put({Time{}, Time{}, i}, &value);
    push_time.record({(MonotonicClock::now() - begin).ns / tap_count});
  }
  ended = true;
  reader.join();
  return {{"message", message},
          {"taps", tap_count},
          {"read", is_read},
          {"bytes", sizeof(T)},
          {"p50_us", push_time.quantile(0.5).microseconds()},
          {"p99_us", push_time.quantile(0.99).microseconds()},
          {"max_us", push_time.max().microseconds()}};
}

}  // namespace

int main(int argc, char** argv) {
  double seconds = 10;
  if (argc == 3 && std::string_view(argv[1]) == "--seconds") seconds = std::atof(argv[2]);
  if ((argc != 1 && argc != 3) || !(seconds >= 1)) {
    fmt::print(stderr, "usage: tap_bench [--seconds S], at least 1 s a row\n");
    return 2;
  }
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const bool is_read : {true, false}) {
    rows.push_back(row<Wrench>("Wrench", 4, is_read, seconds));
    rows.push_back(row<PhysicsState>("PhysicsState", 1, is_read, seconds));
    rows.push_back(row<ContactSet>("ContactSet", 1, is_read, seconds));
  }
  fmt::print("{}\n", rows.dump(1));
}
