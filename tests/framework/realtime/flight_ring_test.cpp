// The flight recorder keeps the newest records, tells torn ones, and outlives its process.
#include "framework/realtime/flight_ring.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <boost/test/unit_test.hpp>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <new>
#include <set>
#include <thread>
#include <vector>

#include "framework/core/check.hpp"
#include "framework/core/temporary_folder.hpp"
#include "framework/realtime/flight_file.hpp"
#include "framework/realtime/flight_log.hpp"
#include "tests/support/heap_is_counted.hpp"

BOOST_AUTO_TEST_SUITE(flight_ring_test)

using namespace tactor;

namespace {

constexpr const char* version = "0.0.1";

FlightRing::Description description_of(std::uint64_t capacity) {
  const std::vector<FlightNode> nodes{{"device", "device.simulated", 1000, {{"physics", "segment", true}}},
                                      {"physics", "dynamics.translation", 0, {}}};
  return {version, flight_names("duck", nodes), capacity};
}

/// A ring in memory of its own.
struct Rig {
  explicit Rig(std::uint64_t capacity)
      : size(FlightRing::bytes(description_of(capacity))),
        memory(static_cast<std::byte*>(::operator new (size, std::align_val_t{64}))),
        ring({memory, size}, description_of(capacity)) {}
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;
  ~Rig() { ::operator delete (memory, std::align_val_t{64}); }

  [[nodiscard]] std::string bytes() const { return {reinterpret_cast<const char*>(memory), size}; }
  void tick(std::int64_t time_ns) { ring.add(FlightKind::tick, 1, {time_ns}, FlightTick{1e-6F * float(time_ns), 0}); }

  std::size_t size;
  std::byte* memory;
  FlightRing ring;
};

}  // namespace

BOOST_AUTO_TEST_CASE(the_newest_records_are_kept_with_the_names_of_the_run) {
  Rig rig(8);
  rig.ring.set_origin({100});
  for (std::int64_t i = 0; i < 21; ++i) rig.tick(100 + i);
  rig.ring.set_end(FlightEnd::well);
  const FlightLog log = read_flight(rig.bytes());
  BOOST_TEST(log.version == version);
  BOOST_TEST(log.graph == "duck");
  BOOST_TEST(log.process == getpid());
  BOOST_TEST((log.end == FlightEnd::well));
  BOOST_TEST(log.name_of(1) == "physics");
  BOOST_TEST(log.nodes[0].inputs[0].from == "physics");
  BOOST_TEST(log.nodes[0].inputs[0].is_outer);
  BOOST_TEST(log.torn == 0U);
  BOOST_REQUIRE(log.records.size() == 8U);
  for (std::size_t i = 0; i < 8; ++i) {
    BOOST_TEST(log.time_of(log.records[i]).ns == static_cast<std::int64_t>(13 + i));
    BOOST_TEST(body_of<FlightTick>(log.records[i]).lateness_s == 1e-6F * static_cast<float>(113 + i));
  }
}

BOOST_AUTO_TEST_CASE(a_record_that_was_not_written_to_its_end_is_told_and_left_out) {
  Rig rig(8);
  for (std::int64_t i = 1; i <= 3; ++i) rig.tick(i);
  std::string bytes = rig.bytes();
  const std::size_t records_at = bytes.size() - 8 * sizeof(FlightRecord);
  for (std::size_t byte = 1; byte < sizeof(FlightRecord); byte += 9) {
    std::string torn = bytes;
    torn[records_at + 2 * sizeof(FlightRecord) + byte] ^= 1;
    const FlightLog log = read_flight(torn);
    BOOST_TEST(log.torn == 1U);
    BOOST_TEST(log.records.size() == 2U);
  }
}

BOOST_AUTO_TEST_CASE(words_that_need_several_records_come_back_whole) {
  Rig rig(16);
  const std::string words = std::string(200, 'a') + "the end";
  rig.ring.tell(FlightEvent::failed, 1, {5}, words);
  rig.ring.tell(FlightEvent::setting, FlightRecord::no_node, {6}, "");
  rig.ring.tell(FlightEvent::stalled, 1, {4}, std::string(1000, 'b'));
  const std::vector<FlightWords> events = read_flight(rig.bytes()).events();
  BOOST_REQUIRE(events.size() == 3U);
  BOOST_TEST(events[0].words == std::string(FlightRing::most_words, 'b'));  // by its time the first
  BOOST_TEST(events[1].words == words);
  BOOST_TEST(events[2].words.empty());
}

BOOST_AUTO_TEST_CASE(a_file_of_another_layout_is_refused_with_the_version_that_wrote_it) {
  Rig rig(4);
  const auto refusal = [](const std::string& bytes) {
    try {
      read_flight(bytes);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  std::string other = rig.bytes();
  other[other.find("lateness")] = 'L';
  BOOST_TEST(refusal(other) ==
             "tactor 0.0.1 wrote it, whose records have another layout than those of this version; read it with tactor "
             "0.0.1");
  BOOST_TEST(refusal(rig.bytes().substr(0, rig.size - 1)) == "expected a whole flight file, found a part of one");
  BOOST_TEST(refusal(std::string(4096, 'x')) == "expected a flight file, found something else");
  BOOST_TEST(refusal("") == "expected a flight file, found one that is too short");
  BOOST_TEST(refusal(rig.bytes()).empty());
}

BOOST_AUTO_TEST_CASE(several_threads_lose_no_record) {
  constexpr std::uint64_t each = 5000;
  constexpr std::size_t writers = 4;
  Rig rig(each * writers);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < writers; ++i) {
    threads.emplace_back([&] {
      for (std::uint64_t n = 0; n < each; ++n) rig.tick(1);
    });
  }
  for (std::thread& thread : threads) thread.join();
  const FlightLog log = read_flight(rig.bytes());
  BOOST_TEST(log.records.size() == each * writers);
  BOOST_TEST(log.torn == 0U);
}

BOOST_AUTO_TEST_CASE(another_process_goes_on_with_the_ring_it_is_handed) {
  Rig rig(4);
  rig.tick(1);
  FlightRing again({rig.memory, rig.size});
  again.add(FlightKind::tick, 0, {2}, FlightTick{});
  BOOST_TEST(read_flight(rig.bytes()).records.size() == 2U);
  FlightRing by_place({rig.memory, rig.size}, rig.ring.place());
  by_place.add(FlightKind::tick, 0, {3}, FlightTick{});
  const FlightLog log = read_flight(rig.bytes());
  BOOST_TEST(log.records.size() == 3U);
  BOOST_TEST(log.torn == 0U);
  const FlightPlace place = rig.ring.place();
  BOOST_CHECK_THROW(FlightRing({rig.memory, rig.size - 1}, place), InputError);
  BOOST_CHECK_THROW(FlightRing({rig.memory, rig.size}, FlightPlace{place.records_at, 0}), InputError);
  BOOST_CHECK_THROW(FlightRing({rig.memory + 64, rig.size - 64}, FlightPlace{place.records_at - 64, 4}), InputError);
}

BOOST_AUTO_TEST_CASE(a_record_takes_nothing_of_the_heap,
                     *boost::unit_test::precondition(tactor::test::heap_is_counted)) {
  Rig rig(16);
  const std::int64_t before = thread_heap_calls();
  for (int i = 0; i < 100; ++i) rig.tick(i);
  rig.ring.tell(FlightEvent::line_failed, 0, {1}, "no answer");
  BOOST_TEST(thread_heap_calls() == before);
}

BOOST_AUTO_TEST_CASE(the_file_of_a_killed_process_is_found_with_its_records_and_that_of_a_good_run_goes) {
  const TemporaryFolder folder("/dev/shm", "tactor-");
  ::setenv("XDG_RUNTIME_DIR", folder.path().c_str(), 1);
  { FlightFile(std::string("well"), description_of(16)).ring().set_end(FlightEnd::well); }
  BOOST_TEST(find_flights().empty());

  int ready[2];
  BOOST_REQUIRE(::pipe(ready) == 0);
  const pid_t child = ::fork();
  if (child == 0) {
    FlightFile file("duck", description_of(16));
    for (std::int64_t i = 1; i <= 5; ++i) file.ring().add(FlightKind::tick, 1, {i}, FlightTick{});
    static_cast<void>(!::write(ready[1], "!", 1));
    for (;;) ::pause();
  }
  char told = 0;
  BOOST_REQUIRE(::read(ready[0], &told, 1) == 1);
  BOOST_REQUIRE(find_flights().size() == 1U);
  BOOST_TEST(find_flights()[0].is_running);
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  const std::vector<FoundFlight> found = find_flights();
  BOOST_REQUIRE(found.size() == 1U);
  BOOST_TEST(!found[0].is_running);
  BOOST_TEST(found[0].process == child);
  std::ifstream file(found[0].path, std::ios::binary);
  const FlightLog log = read_flight(std::string(std::istreambuf_iterator<char>(file), {}));
  BOOST_TEST(log.records.size() == 5U);
  BOOST_TEST((log.end == FlightEnd::none));
  ::unsetenv("XDG_RUNTIME_DIR");
}

BOOST_AUTO_TEST_SUITE_END()
