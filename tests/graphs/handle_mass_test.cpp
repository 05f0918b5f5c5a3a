// The mass of the handle, by which a run says what of its vibration a hand feels.
#include <boost/test/unit_test.hpp>
#include <string>

#include "tests/support/shipped_graphs.hpp"

BOOST_AUTO_TEST_SUITE(handle_mass_test)

using namespace tactor;
using namespace tactor::test;

namespace {

const std::string wall = "wall/off.yaml";

double vibration(const Over& over) {
  return run(planned(wall, over + Over{"duration=2 s"})).metric("delivered.force.vibration_above_threshold_dB");
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_handle_without_mass_is_refused_with_what_is_expected) {
  for (const std::string mass : {"0 kg", "-1 kg", "1000 kg", "1 N", "heavy"}) {
    says_like(refusal_of_run(wall, {"metrics.mass=" + mass}),
              R"(metrics\.mass: expected a mass \(kg\)( from 0\.001 to 100)?, found)");
  }
}

BOOST_AUTO_TEST_CASE(the_handle_s_mass_is_that_of_the_device_unless_it_is_told_another) {
  const double light = vibration({"metrics.mass=45 g"});
  BOOST_TEST(light != vibration({"metrics.mass=100 g"}));
  BOOST_TEST(vibration({"device.mass=45 g"}) == light);
  BOOST_TEST(vibration({"device.mass=200 g", "metrics.mass=45 g"}) == light);
}

BOOST_AUTO_TEST_CASE(a_former_name_of_it_is_told) {
  says_like(refusal(wall, {"metrics.handle_mass=45 g"}), R"(metrics\.handle_mass is called mass now)");
}

BOOST_AUTO_TEST_SUITE_END()
