// UsbLink and everything that can go wrong on the way, through unmodified libusb and an emulated Polhem.
#include <atomic>
#include <boost/test/unit_test.hpp>
#include <chrono>
#include <cmath>
#include <memory>
#include <thread>

#include "devices/usb/emulator/emulator.hpp"
#include "devices/usb/emulator/interposition.hpp"
#include "devices/usb/usb_link.hpp"
#include "framework/core/check.hpp"
#include "framework/core/temporary_folder.hpp"

BOOST_AUTO_TEST_SUITE(usb_link_test)

using namespace tactor;

namespace {

constexpr const char* path = "/dev/bus/usb/250/003";

UsbProfile polhem() {
  UsbProfile profile = read_usb_profile(std::string(TACTOR_SOURCE_DIR) + "/devices/usb/profiles/polhem.yaml");
  profile.report_timeout = Duration{1'000'000'000};  // a machine with much else to do is late
  return profile;
}

Emulation emulation_of(const UsbProfile& profile) {
  Emulation e;
  e.path = path;
  e.vendor = profile.vendor;
  e.product = profile.product;
  e.name = "Polhem";
  e.serial = "test";
  e.asks_first = profile.asks_first;
  e.input = profile.input;
  e.output = profile.output;
  e.geometry = profile.kinematics;
  e.numbers = profile.numbers;
  e.start = {-0.007, 0, 0.132};
  e.hand.hold = 1e6;  // it stays there
  return e;
}

/// An emulated device and a line to it.
struct Setting {
  UsbProfile profile = polhem();
  Emulation emulation = emulation_of(profile);
  TemporaryFolder folder;
  CalibrationStore store{folder.path()};
  std::unique_ptr<UsbEmulator> emulator;
  std::unique_ptr<UsbLink> link;
  LinkFailure failure;
  LinkSample sample;

  Setting() { make(); }
  ~Setting() { unmake(); }
  void unmake() {
    link.reset();
    if (emulator != nullptr) withdraw(emulator->node());
    emulator.reset();
  }
  void make() {
    unmake();
    emulator = std::make_unique<UsbEmulator>(emulation);
    interpose(emulator->node());
    emulator->run();
    link = std::make_unique<UsbLink>(profile, UsbChoice{"", path}, store);
  }
  void calibrate() { link->calibrate(Duration{20'000'000}); }
  void open() {
    calibrate();
    BOOST_TEST_REQUIRE(link->open(failure), failure.text);
  }
  bool exchange(double a = 0, double b = 0, double c = 0) { return link->exchange({{a, b, c}}, sample, failure); }
  /// Cycles until one fails, which it must.
  void until_it_fails(double effort = 0) {
    for (int i = 0; i < 100; ++i) {
      if (!exchange(effort)) return;
    }
    BOOST_FAIL("no cycle has failed");
  }
  void wait_for_effort(double a) {
    for (int i = 0; i < 2000; ++i) {
      if (std::abs(effort() - a) < 1e-3) return;
      BOOST_TEST_REQUIRE(exchange(a), failure.text);
    }
    BOOST_FAIL("the effort does not arrive");
  }
  /// Pushes axis a away from its start.
  void push_away() {
    for (int i = 0; i < 5000; ++i) {
      BOOST_TEST_REQUIRE(exchange(1.0), failure.text);
      if (sample.q[0] > 0.03) return;
    }
    BOOST_FAIL("the handle does not move");
  }
  /// Lets the pushed handle move between two cycles, of which the second must show where it is then.
  void demand_a_sample_of_now_after_a_pause() {
    wait_for_effort(1.0);
    BOOST_TEST_REQUIRE(exchange(1.0), failure.text);
    const double before = sample.q[0];
    for (int i = 0; i < 20'000 && angle() < before + 0.1; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const double there = angle();
    BOOST_TEST_REQUIRE(there > before + 0.1);
    BOOST_TEST_REQUIRE(exchange(1.0), failure.text);
    BOOST_TEST(sample.q[0] > there - 0.02);
  }
  double angle() {
    return emulator->node().locked([this] { return emulator->device().arm().q()[0]; });
  }
  double effort() {
    return emulator->node().locked([this] { return emulator->device().effort()[0]; });
  }
};

}  // namespace

BOOST_FIXTURE_TEST_CASE(without_a_calibration_the_line_does_not_open_and_says_what_to_do, Setting) {
  BOOST_TEST(!link->open(failure));
  BOOST_TEST((failure.error == LinkError::identity));
  BOOST_TEST(failure.text.find("tactor device calibrate") != std::string::npos, failure.text);
  BOOST_TEST(failure.text.find(profile.calibration) != std::string::npos, failure.text);
  BOOST_TEST(failure.asks_user);
  calibrate();
  BOOST_TEST(link->open(failure), failure.text);
}

BOOST_FIXTURE_TEST_CASE(a_calibrated_device_shows_the_pose_it_is_in, Setting) {
  open();
  BOOST_TEST_REQUIRE(exchange(), failure.text);
  BOOST_TEST(std::abs(sample.q[0]) < 1e-3);
  BOOST_TEST(std::abs(sample.q[1]) < 1e-3);
  BOOST_TEST(std::abs(sample.q[2] - std::acos(-1.0) / 2) < 1e-3);
  BOOST_TEST(sample.faults == 0U);
}

BOOST_FIXTURE_TEST_CASE(efforts_arrive_as_they_are_commanded_and_zero_at_the_end, Setting) {
  open();
  wait_for_effort(0.2);
  link->close();
  BOOST_TEST(effort() == 0);
  // No motor got more than its board may be sent: 1999 mA.
  BOOST_TEST_REQUIRE(link->open(failure), failure.text);
  for (int i = 0; i < 20; ++i) BOOST_TEST_REQUIRE(exchange(1e6, -1e6, std::nan("")), failure.text);
  link->close();
  const double largest = emulator->node().locked([this] { return emulator->device().largest_effort(); });
  BOOST_TEST(largest <= 1999 * 968.4e-6 * (1 + 1e-9));
}

BOOST_FIXTURE_TEST_CASE(a_push_moves_the_handle_the_way_of_its_sign, Setting) {
  open();
  BOOST_TEST_REQUIRE(exchange(), failure.text);
  const double before = sample.q[0];
  for (int i = 0; i < 300; ++i) BOOST_TEST_REQUIRE(exchange(0.1), failure.text);
  BOOST_TEST(sample.q[0] > before + 0.005);
}

BOOST_FIXTURE_TEST_CASE(a_report_that_lay_in_the_device_since_it_was_closed_is_no_sample, Setting) {
  open();
  push_away();
  link->close();
  // The hand has put it back to its start; the board still holds the report that it made before.
  BOOST_TEST_REQUIRE(link->open(failure), failure.text);
  BOOST_TEST_REQUIRE(exchange(), failure.text);
  BOOST_TEST(std::abs(sample.q[0]) < 1e-3);
  push_away();
  link->close();
  calibrate();  // throws where it seems to have moved
  BOOST_TEST_REQUIRE(link->open(failure), failure.text);
  BOOST_TEST_REQUIRE(exchange(), failure.text);
  BOOST_TEST(std::abs(sample.q[0]) < 1e-3);
}

BOOST_FIXTURE_TEST_CASE(a_report_that_waited_for_a_late_cycle_is_no_sample, Setting) {
  open();
  demand_a_sample_of_now_after_a_pause();
}

BOOST_FIXTURE_TEST_CASE(what_a_device_sent_on_its_own_between_two_cycles_is_no_sample, Setting) {
  profile.asks_first = emulation.asks_first = false;
  profile.rate = 100;
  make();
  open();
  // Two reports are taken by the transfers meanwhile, and the firmware holds a third.
  demand_a_sample_of_now_after_a_pause();
}

BOOST_FIXTURE_TEST_CASE(a_silent_device_is_a_timeout, Setting) {
  profile.report_timeout = Duration{20'000'000};
  make();
  open();
  emulator->begin(UsbFault::silent);
  until_it_fails();
  BOOST_TEST((failure.error == LinkError::timeout), failure.text);
}

BOOST_FIXTURE_TEST_CASE(short_long_and_empty_reports_are_no_reports, Setting) {
  open();
  for (const UsbFault fault : {UsbFault::short_report, UsbFault::long_report, UsbFault::empty_report}) {
    emulator->begin(fault);
    until_it_fails();
    BOOST_TEST((failure.error == LinkError::protocol), failure.text);
    BOOST_TEST(failure.text.find("expected 14") != std::string::npos, failure.text);
    emulator->begin(UsbFault::well);
    for (int i = 0; i < 20 && !exchange(); ++i) {
    }
    BOOST_TEST(exchange(), failure.text);
  }
}

BOOST_FIXTURE_TEST_CASE(a_stalled_endpoint_fails_a_cycle_and_is_set_free, Setting) {
  open();
  for (int i = 0; i < 3; ++i) {
    emulator->begin(UsbFault::stall);
    until_it_fails();
    BOOST_TEST((failure.error == LinkError::protocol), failure.text);
    BOOST_TEST(failure.text.find("stalled") != std::string::npos, failure.text);
    BOOST_TEST(!failure.reopen);
    for (int cycle = 0; cycle < 20; ++cycle) BOOST_TEST_REQUIRE(exchange(), failure.text);
  }
}

BOOST_FIXTURE_TEST_CASE(a_board_that_only_answers_does_so_in_every_frame, Setting) {
  profile.rate = 1;  // no cycle of this test is late, whatever else the machine does
  make();
  open();
  emulator->halt_frames();
  // Frames in step with the line: the next one comes when a command waits for it.
  std::atomic<bool> done{false};
  std::atomic<int> frames{0};
  std::thread bus([&] {
    while (!done) {
      for (int i = 0; i < 5000 && !done && !emulator->node().is_sending(); ++i) {
        std::this_thread::sleep_for(std::chrono::microseconds(100));
      }
      emulator->frame();
      ++frames;
    }
  });
  constexpr int cycles = 100, first_ones = 4;
  int answered = 0;
  while (answered < cycles && exchange()) ++answered;
  const int taken = frames;
  done = true;
  bus.join();
  BOOST_TEST_REQUIRE(answered == cycles, failure.text);
  BOOST_TEST(taken <= cycles + first_ones);
}

BOOST_FIXTURE_TEST_CASE(a_pulled_cable_ends_the_line_and_forgets_the_zero, Setting) {
  open();
  wait_for_effort(0.2);
  emulator->begin(UsbFault::unplug);
  until_it_fails(0.2);
  BOOST_TEST((failure.error == LinkError::reset), failure.text);
  BOOST_TEST(failure.reopen);
  link->close();
  BOOST_TEST(!link->open(failure));
  BOOST_TEST((failure.error == LinkError::disconnected), failure.text);
  emulator->begin(UsbFault::replug);
  // It is there again, with a zero of its own that nobody knows.
  BOOST_TEST(!link->open(failure));
  BOOST_TEST((failure.error == LinkError::identity), failure.text);
  BOOST_TEST(failure.text.find("calibrate") != std::string::npos, failure.text);
  calibrate();
  BOOST_TEST_REQUIRE(link->open(failure), failure.text);
  BOOST_TEST_REQUIRE(exchange(), failure.text);
  BOOST_TEST(std::abs(sample.q[0]) < 1e-3);
  BOOST_TEST(effort() == 0);
}

BOOST_FIXTURE_TEST_CASE(a_device_without_calibration_goes_on_after_it_was_plugged_in_again, Setting) {
  profile.calibration.clear();
  make();
  BOOST_TEST_REQUIRE(link->open(failure), failure.text);
  emulator->begin(UsbFault::unplug);
  until_it_fails();
  link->close();
  emulator->begin(UsbFault::replug);
  BOOST_TEST_REQUIRE(link->open(failure), failure.text);
  BOOST_TEST(exchange(), failure.text);
}

BOOST_FIXTURE_TEST_CASE(another_device_under_the_same_numbers_gets_nothing, Setting) {
  calibrate();
  emulation.bulk = true;  // other endpoints
  make();
  BOOST_TEST(!link->open(failure));
  BOOST_TEST((failure.error == LinkError::identity), failure.text);
  BOOST_TEST(failure.text.find("another device") != std::string::npos, failure.text);
  emulation.bulk = false;
  make();
  emulator->begin(UsbFault::short_report);  // reports of another length
  BOOST_TEST(!link->open(failure));
  BOOST_TEST((failure.error == LinkError::identity), failure.text);
  BOOST_TEST(failure.text.find("another device") != std::string::npos, failure.text);
  const double largest = emulator->node().locked([this] { return emulator->device().largest_effort(); });
  BOOST_TEST(largest == 0);
}

BOOST_FIXTURE_TEST_CASE(a_device_that_calls_itself_otherwise_is_refused, Setting) {
  profile.product_text = "Polhem 2";
  make();
  BOOST_TEST(!link->open(failure));
  BOOST_TEST(failure.text.find("\"Polhem\", not \"Polhem 2\"") != std::string::npos, failure.text);
}

BOOST_FIXTURE_TEST_CASE(a_status_bit_is_told_in_words, Setting) {
  Flag flag;
  flag.field = 6;  // info
  flag.bit = 3;
  flag.meaning = "a motor that is too hot";
  profile.input.faults = {flag};
  emulation.input.faults = {flag};
  make();
  open();
  emulator->begin(UsbFault::status);
  for (int i = 0; i < 100 && sample.faults == 0; ++i) BOOST_TEST_REQUIRE(exchange(), failure.text);
  BOOST_TEST(sample.faults == 1U);
  BOOST_TEST(failure.text == "the device reports a motor that is too hot");
}

BOOST_FIXTURE_TEST_CASE(a_handle_that_moves_is_not_calibrated, Setting) {
  emulation.hand.hold = 0;
  emulation.hand.approach = 0.2;
  emulation.hand.times = {0, 0.2, 0.4};
  emulation.hand.points = {{0, 0, 0}, {0.05, 0, 0.05}, {0, 0, 0}};
  make();
  BOOST_CHECK_EXCEPTION(link->calibrate(Duration{500'000'000}), InputError, [](const InputError& error) {
    return std::string(error.what()).find("the handle was moved") != std::string::npos;
  });
  BOOST_TEST(!link->open(failure));
}

BOOST_AUTO_TEST_CASE(a_record_counts_for_one_device_and_where_it_is_whole) {
  const TemporaryFolder folder;
  const CalibrationStore store(folder.path() / "tactor");
  BOOST_TEST(!store.find("a", 3).has_value());
  store.keep("a", {1, -2.5, 3});
  BOOST_TEST((store.find("a", 3) == std::vector<double>{1, -2.5, 3}));
  BOOST_TEST(!store.find("b", 3).has_value());
  BOOST_TEST(!store.find("a", 2).has_value());
  std::filesystem::copy_file(store.file("a"), store.file("b"));
  BOOST_TEST(!store.find("b", 3).has_value());  // of another device
  std::filesystem::permissions(store.file("a"), std::filesystem::perms::all);
  BOOST_CHECK_THROW(static_cast<void>(store.find("a", 3)), RunError);  // somebody else may have written it
  store.keep("a", {1, 2, 3});
  std::filesystem::resize_file(store.file("a"), std::filesystem::file_size(store.file("a")) - 3);
  BOOST_TEST(!store.find("a", 3).has_value());  // cut off
  store.keep("a", {1, 2, 3});
  store.forget("a");
  BOOST_TEST(!store.find("a", 3).has_value());
}

BOOST_AUTO_TEST_SUITE_END()
