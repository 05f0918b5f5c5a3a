// The contacts of a query as those around the bodies: at one anchor, and of too many the nearest.
#include <boost/test/unit_test.hpp>

#include <algorithm>
#include <vector>

#include "nodes/physics/contact/told_contacts.hpp"
#include "tests/support/dice.hpp"

BOOST_AUTO_TEST_SUITE(told_contacts_test)

using namespace tactor;
using namespace tactor::test;

BOOST_AUTO_TEST_CASE(the_nearest_are_kept_in_their_order_with_their_law_and_pairs) {
  Dice dice(4);
  for (const int count : {0, 1, 48, 49, 128}) {
    ContactSet set;
    set.bodies.count = 2;
    for (std::size_t i = 0; i < 2; ++i) set.bodies.X_WB[i] = dice.pose(1, 3);
    set.count = count;
    std::vector<double> distances;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      set.contact[i].distance = dice(-1e-3, 1e-3);
      set.contact[i].inertia = static_cast<double>(i);
      set.pair[i] = {static_cast<std::int32_t>(i % 2), ContactPair::fixed};
      distances.push_back(set.contact[i].distance);
    }
    std::sort(distances.begin(), distances.end());
    LocalContacts around;
    take_told(set, around);
    BOOST_TEST(around.anchors == 1);
    BOOST_TEST(around.bodies == 2);
    BOOST_TEST((around.X_WB[0] == set.bodies.X_WB));
    BOOST_REQUIRE(around.count == std::min(count, LocalContacts::capacity));
    double last = -1;
    for (std::size_t i = 0; i < static_cast<std::size_t>(around.count); ++i) {
      const Contact& c = around.contact[i][0];
      BOOST_TEST(c.distance <= distances[static_cast<std::size_t>(around.count) - 1]);
      BOOST_TEST(c.inertia > last);
      last = c.inertia;
      BOOST_TEST(c.distance == set.contact[static_cast<std::size_t>(last)].distance);
      BOOST_TEST(around.pair[i].body == static_cast<std::int32_t>(last) % 2);
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
