#define BOOST_TEST_MODULE shared_object
#include <boost/test/unit_test.hpp>

#include "framework/core/shared_object.hpp"

BOOST_AUTO_TEST_SUITE(shared_object_test)

using namespace tactor;

BOOST_AUTO_TEST_CASE(an_object_is_made_once_while_somebody_holds_it_and_anew_afterwards) {
  int made = 0;
  const auto make = [&made] { return std::make_shared<const int>(++made); };
  auto first = shared_object("a", make);
  BOOST_TEST(shared_object("a", make) == first);
  BOOST_TEST(made == 1);
  BOOST_TEST(shared_object("b", make) != first);
  BOOST_TEST(made == 2);
  first.reset();
  const auto again = shared_object("a", make);
  BOOST_TEST(*static_cast<const int*>(again.get()) == 3);
}

BOOST_AUTO_TEST_CASE(what_cannot_be_made_leaves_nothing_behind) {
  BOOST_CHECK_THROW(shared_object("c", []() -> std::shared_ptr<const void> { throw 1; }), int);
  const auto made = shared_object("c", [] { return std::make_shared<const int>(7); });
  BOOST_TEST(*static_cast<const int*>(made.get()) == 7);
}

BOOST_AUTO_TEST_SUITE_END()
