// A budget follows from the size of a file, holds that much and no more, and heeds who wants to end the program.
#include "framework/core/read_budget.hpp"

#include <boost/test/unit_test.hpp>
#include <limits>
#include <string_view>

#include "framework/core/check.hpp"

BOOST_AUTO_TEST_SUITE(read_budget_test)

using namespace tactor;

namespace {

constexpr std::uint64_t mib = std::uint64_t{1} << 20U;
int requests = 0;

std::string refusal_of(ReadBudget& budget, std::uint64_t bytes, const char* place = "") {
  try {
    budget.take(bytes, place);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

}  // namespace

BOOST_AUTO_TEST_CASE(it_is_64_times_the_file_but_at_least_64_MiB_and_at_most_8_GiB) {
  struct Case {
    std::uint64_t file, budget;
  };
  for (const Case one : {Case{0, 64 * mib}, Case{1, 64 * mib}, Case{mib, 64 * mib}, Case{2 * mib, 128 * mib},
                         Case{64 * mib, 4096 * mib}, Case{128 * mib, 8192 * mib}, Case{1024 * mib, 8192 * mib},
                         Case{std::numeric_limits<std::uint64_t>::max(), 8192 * mib}}) {
    BOOST_TEST(ReadBudget("file", one.file).bytes() == one.budget);
  }
  BOOST_TEST(ReadBudget("file", 1, 512 * mib).bytes() == 512 * mib);
}

BOOST_AUTO_TEST_CASE(what_it_does_not_hold_is_refused_with_file_place_and_limit) {
  ReadBudget budget("heart.msh", 700'000);
  budget.take(64 * mib - 8);
  BOOST_TEST(budget.used() == 64 * mib - 8);
  const std::string why = refusal_of(budget, 9, ":12");
  BOOST_TEST(why.find("heart.msh:12: expected a file that takes at most 64 MiB") == 0U);
  BOOST_TEST(why.find("0.7 MB") != std::string::npos);
  // A refusal takes nothing, and no sum wraps.
  BOOST_TEST(!refusal_of(budget, std::numeric_limits<std::uint64_t>::max()).empty());
  BOOST_TEST(refusal_of(budget, 8).empty());
  BOOST_TEST(!refusal_of(budget, 1).empty());
  BOOST_TEST(!budget.holds(1));
}

BOOST_AUTO_TEST_CASE(steps_without_memory_are_counted_too) {
  ReadBudget budget("file", 0);
  std::uint64_t steps = 0;
  try {
    for (;; ++steps) budget.step();
  } catch (const InputError&) {
  }
  BOOST_TEST(steps == budget.bytes() / ReadBudget::step_cost);
}

BOOST_AUTO_TEST_CASE(before_a_run_a_request_ends_all_reading_and_then_what_is_being_read_alone) {
  heed_while_reading([] { return requests; });
  // It came while the bytes were taken in, or between two files.
  requests = 1;
  ReadBudget loading("scene.off", 0);
  BOOST_CHECK_THROW(for (int i = 0; i < 1'000'000; ++i) loading.step(), ReadingEnded);
  heed_new_requests_alone();
  ReadBudget before("before.vtu", 0);
  for (int i = 0; i < 100'000; ++i) before.step();
  ++requests;
  bool ended = false;
  try {
    for (int i = 0; i < 1'000'000; ++i) before.step();
  } catch (const ReadingEnded& end) {
    ended = true;
    BOOST_TEST(std::string_view(end.what()) == "interrupted while before.vtu was read");
  }
  BOOST_TEST(ended);
  // For the results of the run that was ended, say.
  ReadBudget after("after.vtu", 0);
  for (int i = 0; i < 1'000'000; ++i) after.step();
  heed_while_reading(nullptr);
}

BOOST_AUTO_TEST_SUITE_END()
