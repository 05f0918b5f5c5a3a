// The times that a live run keeps of its steps are of a bounded number, and spread over the whole run.
#include "framework/engine/live/step_sampling.hpp"

#include <boost/test/unit_test.hpp>

using namespace tactor;

BOOST_AUTO_TEST_CASE(times_of_a_run_of_any_length_are_bounded_and_spread_over_all_of_it) {
  for (const std::uint64_t stride : {1, 7}) {
    StepSampling sampling(stride);
    std::vector<std::uint32_t> times;
    constexpr std::uint32_t steps = 3'000'000;  // what a physics thread makes in an hour
    for (std::uint32_t step = 1; step <= steps; ++step) {
      if (sampling.picks(step)) sampling.keep(times, step);
    }
    BOOST_TEST(times.capacity() <= 2 * StepSampling::most);
    BOOST_TEST(times.size() <= StepSampling::most);
    BOOST_TEST(times.size() > StepSampling::most / 3);
    BOOST_TEST(times.front() == 1U);
    const std::uint32_t apart = times[1] - times[0];
    BOOST_TEST(times.back() > steps - apart);
    for (std::size_t i = 1; i < times.size(); ++i) BOOST_REQUIRE(times[i] - times[i - 1] == apart);
    BOOST_TEST(apart % stride == 0U);
  }
}

BOOST_AUTO_TEST_CASE(a_short_run_keeps_the_times_of_every_step) {
  StepSampling sampling(1);
  std::vector<std::uint32_t> times;
  for (std::uint32_t step = 1; step <= StepSampling::most; ++step) {
    BOOST_REQUIRE(sampling.picks(step));
    sampling.keep(times, step);
  }
  BOOST_TEST(times.size() == StepSampling::most);
}
