// What is to go wrong with an emulated device: how its texts are read, and when it happens.
#include "devices/usb/emulator/fault_script.hpp"

#include <boost/test/unit_test.hpp>
#include <string_view>
#include <vector>

#include "framework/core/check.hpp"

BOOST_AUTO_TEST_SUITE(fault_script_test)

using namespace tactor;

namespace {

FaultOrder read(std::string_view text) {
  FaultOrder order;
  const std::string wrong = parse_fault_order(text, order);
  BOOST_TEST(wrong.empty(), text << ": " << wrong);
  return order;
}

std::string refusal(std::string_view text) {
  FaultOrder order;
  return parse_fault_order(text, order);
}

}  // namespace

BOOST_AUTO_TEST_CASE(an_order_names_its_fault_and_its_time) {
  using When = FaultOrder::When;
  struct Case {
    std::string_view text;
    UsbFault fault;
    When when;
    double seconds;
  };
  for (const Case& one : {Case{"silent@1.5", UsbFault::silent, When::time, 1.5},
                          {"unplug@2 s", UsbFault::unplug, When::time, 2},
                          {"unplug@2s", UsbFault::unplug, When::time, 2},
                          {"jump@driven", UsbFault::jump, When::driven, 0},
                          {"jump@driven+0.25", UsbFault::jump, When::driven, 0.25},
                          {"well@+3", UsbFault::well, When::after, 3}}) {
    const FaultOrder order = read(one.text);
    BOOST_TEST((order.fault == one.fault && order.when == one.when), one.text);
    BOOST_TEST(order.seconds == one.seconds, one.text);
    // What a text says is read back as the same.
    const FaultOrder again = read(to_text(order));
    BOOST_TEST((again.fault == order.fault && again.when == order.when && again.seconds == order.seconds), one.text);
  }
  // What stands behind the text is not of it.
  BOOST_TEST(read(std::string_view("silent@15").substr(0, 8)).seconds == 1);
}

BOOST_AUTO_TEST_CASE(a_wrong_order_is_refused_with_what_was_expected) {
  BOOST_TEST(refusal("silent") == "expected KIND@SECONDS, KIND@driven+SECONDS or KIND@+SECONDS");
  BOOST_TEST(refusal("loud@1").starts_with("expected one of unplug, replug, "));
  BOOST_TEST(refusal("silent@driven1") == "expected driven or driven+SECONDS after the @");
  for (const std::string_view text :
       {"silent@", "silent@x", "silent@1x", "silent@-1", "silent@1e7", "silent@nan", "silent@+"})
    BOOST_TEST(refusal(text) == "expected seconds from 0 to 1e6 after the @", text);
  BOOST_CHECK_THROW(read_fault_order("--fault", "silent@x"), InputError);
}

BOOST_AUTO_TEST_CASE(faults_come_one_after_the_other_at_their_times) {
  FaultScript script({read("silent@0.5"), read("well@+0.25"), read("jump@driven+0.125")});
  UsbFault fault = UsbFault::well;
  constexpr double dt = 0.125;                           // exact in binary
  BOOST_TEST(!script.advance(dt, false, false, fault));  // the clock starts when it is opened
  std::vector<int> due;
  for (int tick = 1; tick <= 12; ++tick) {
    // Driven from the ninth tick on, after the fault before.
    if (script.advance(dt, true, tick >= 9, fault)) due.push_back(tick);
  }
  BOOST_TEST(due == (std::vector<int>{4, 6, 10}), boost::test_tools::per_element());
  BOOST_TEST((fault == UsbFault::jump));
}

BOOST_AUTO_TEST_SUITE_END()
