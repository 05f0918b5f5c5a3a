// What a page is told of the dead-man button goes by the rule of device.mouse.
#include "app/view/hold.hpp"

#include <boost/test/unit_test.hpp>

BOOST_AUTO_TEST_SUITE(hold_test)

using namespace tactor;

namespace {

constexpr Duration timeout{200'000'000};

constexpr Instant ms(std::int64_t t) {
  return {t * 1'000'000};
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_tool_that_was_let_go_is_told_apart_from_one_that_nobody_has_held) {
  HoldWatch watch(timeout);
  BOOST_TEST(name_of(watch.at(ms(0))) == "never");
  watch.input(false, ms(10));
  BOOST_TEST(name_of(watch.at(ms(20))) == "never");
  watch.input(true, ms(30));
  BOOST_TEST(name_of(watch.at(ms(40))) == "held");
  watch.input(false, ms(50));
  BOOST_TEST(name_of(watch.at(ms(60))) == "let_go");
  BOOST_TEST(name_of(watch.at(ms(5000))) == "let_go");
}

BOOST_AUTO_TEST_CASE(a_page_that_was_silent_has_to_let_go_first) {
  HoldWatch watch(timeout);
  watch.input(true, ms(0));
  BOOST_TEST(name_of(watch.at(ms(200))) == "held");
  BOOST_TEST(name_of(watch.at(ms(201))) == "silent");
  watch.input(true, ms(300));
  BOOST_TEST(name_of(watch.at(ms(301))) == "silent");
  watch.input(false, ms(310));
  BOOST_TEST(name_of(watch.at(ms(311))) == "let_go");
  watch.input(true, ms(320));
  BOOST_TEST(name_of(watch.at(ms(321))) == "held");
}

BOOST_AUTO_TEST_CASE(a_hold_that_begins_after_a_silence_does_not_count) {
  HoldWatch watch(timeout);
  watch.input(false, ms(0));
  watch.input(true, ms(500));
  BOOST_TEST(name_of(watch.at(ms(501))) == "silent");
}

BOOST_AUTO_TEST_CASE(a_page_that_has_gone_is_told_until_the_next_one_lets_go) {
  HoldWatch watch(timeout);
  watch.input(true, ms(0));
  watch.page_gone(ms(10));
  BOOST_TEST(name_of(watch.at(ms(20))) == "page_gone");
  watch.input(true, ms(30));
  BOOST_TEST(name_of(watch.at(ms(40))) == "held");
  watch.input(false, ms(50));
  BOOST_TEST(name_of(watch.at(ms(60))) == "let_go");
}

BOOST_AUTO_TEST_SUITE_END()
