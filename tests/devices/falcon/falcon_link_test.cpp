// FalconLink and what can go wrong on the way, through unmodified libusb and an emulated Falcon.
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <fstream>
#include <memory>

#include "devices/falcon/delta_arm.hpp"
#include "devices/falcon/falcon_link.hpp"
#include "devices/falcon/protocol.hpp"
#include "devices/usb/emulator/emulator.hpp"
#include "devices/usb/emulator/interposition.hpp"
#include "framework/core/check.hpp"
#include "framework/core/temporary_folder.hpp"

BOOST_AUTO_TEST_SUITE(falcon_link_test)

using namespace tactor;

namespace {

constexpr const char* path = "/dev/bus/usb/250/004";

struct Setting {
  Emulation emulation;
  std::unique_ptr<UsbEmulator> emulator;
  std::unique_ptr<FalconLink> link;
  LinkFailure failure;
  LinkSample sample;

  Setting() {
    emulation.kind = "falcon";
    emulation.path = path;
    emulation.vendor = falcon::vendor;
    emulation.product = falcon::product;
    emulation.name = "Falcon";
    emulation.serial = "test";
    emulation.bulk = true;
    emulation.geometry = "delta";
    emulation.start = {0, 0, 0.120};
    // A hand that homes it as soon as it is opened, and stays outside.
    emulation.hand.hold = 0;
    emulation.hand.approach = 0.2;
    emulation.hand.times = {0, 1000};
    emulation.hand.points = {{0, 0, 0.155}, {0, 0, 0.155}};
  }
  ~Setting() { unmake(); }
  void unmake() {
    link.reset();
    if (emulator != nullptr) withdraw(emulator->node());
    emulator.reset();
  }
  void make(std::size_t firmware = 5000) {
    unmake();
    emulator = std::make_unique<UsbEmulator>(emulation);
    interpose(emulator->node());
    emulator->run();
    std::vector<std::uint8_t> image(firmware);
    for (std::size_t i = 0; i < image.size(); ++i) image[i] = static_cast<std::uint8_t>(i * 7);
    link = std::make_unique<FalconLink>(image, UsbChoice{"", path});
  }
  /// Opens, as often as a runner would: homing may need its time on a busy machine.
  void open() {
    for (int i = 0; i < 20; ++i) {
      if (link->open(failure)) return;
    }
    BOOST_FAIL(failure.text);
  }
  bool exchange(double torque) { return link->exchange({{torque, torque, torque}}, sample, failure); }
  /// Cycles until the emulated motors hold that torque, or one fails.
  bool reaches(double torque) {
    for (int i = 0; i < 2000; ++i) {
      if (std::abs(effort() - torque) < 2e-4) return true;
      exchange(torque);
    }
    return false;
  }
  double effort() {
    return emulator->node().locked([this] { return emulator->device().effort()[0]; });
  }
  double largest() {
    return emulator->node().locked([this] { return emulator->device().largest_effort(); });
  }
  /// A cycle that succeeds although the machine may be late.
  void exchange_well() {
    for (int i = 0; i < 50; ++i) {
      if (exchange(0)) return;
    }
    BOOST_FAIL(failure.text);
  }
};

}  // namespace

BOOST_FIXTURE_TEST_CASE(firmware_is_loaded_and_the_handle_homed_before_anything_is_pushed, Setting) {
  make();
  open();
  BOOST_TEST(largest() == 0);
  exchange_well();
  const auto p = DeltaArm().forward({sample.q[0], sample.q[1], sample.q[2]});
  BOOST_TEST_REQUIRE(p.has_value());
  // Within the steps of the encoders, the handle is where the emulated hand has it.
  const Vec3 there = emulator->node().locked([this] { return emulator->device().arm().p_BD(); });
  BOOST_TEST(norm(*p - there) < 5e-3);
}

BOOST_FIXTURE_TEST_CASE(a_stalled_endpoint_fails_a_cycle_and_is_set_free, Setting) {
  make();
  open();
  exchange_well();
  emulator->begin(UsbFault::stall);
  bool told = false;
  for (int i = 0; i < 100 && !told; ++i) told = !exchange(0) && failure.text.find("stalled") != std::string::npos;
  BOOST_TEST(told);
  BOOST_TEST((failure.error == LinkError::protocol), failure.text);
  BOOST_TEST(!failure.reopen);
  exchange_well();
}

BOOST_FIXTURE_TEST_CASE(without_firmware_it_says_so_and_nothing_moves, Setting) {
  make(0);
  BOOST_TEST(!link->open(failure));
  BOOST_TEST((failure.error == LinkError::identity), failure.text);
  BOOST_TEST(failure.text.find("it has no firmware") == 0U, failure.text);
  BOOST_TEST(failure.asks_user);
  BOOST_TEST(largest() == 0);
}

BOOST_FIXTURE_TEST_CASE(a_device_that_was_not_homed_does_not_open, Setting) {
  emulation.hand.hold = 1e6;  // nobody moves it
  make();
  BOOST_TEST(!link->open(failure));
  BOOST_TEST(failure.text.find("not homed") != std::string::npos, failure.text);
  BOOST_TEST(largest() == 0);
}

BOOST_FIXTURE_TEST_CASE(torques_arrive_within_the_limit_and_zero_at_the_end, Setting) {
  make();
  open();
  BOOST_TEST(reaches(0.05));
  for (int i = 0; i < 20; ++i) exchange(1e9);
  for (int i = 0; i < 20; ++i) exchange(std::nan(""));
  BOOST_TEST(largest() <= falcon::word_max / 1e4 + 1e-9);
  BOOST_TEST(reaches(0.05));
  link->close();
  BOOST_TEST(effort() == 0);
}

BOOST_FIXTURE_TEST_CASE(an_encoder_that_loses_its_zero_ends_the_force_at_once, Setting) {
  make();
  open();
  BOOST_TEST(reaches(0.05));
  emulator->begin(UsbFault::unhomed);
  bool failed = false;
  for (int i = 0; i < 200 && !failed; ++i) failed = !exchange(0.05) && failure.error == LinkError::protocol;
  BOOST_TEST(failed);
  BOOST_TEST(failure.reopen);
  BOOST_TEST(failure.text.find("lost their zero") != std::string::npos, failure.text);
  link->close();
  BOOST_TEST(effort() == 0);
  BOOST_TEST(!link->open(failure));
  BOOST_TEST(failure.text.find("not homed") != std::string::npos, failure.text);
  BOOST_TEST(effort() == 0);
}

BOOST_FIXTURE_TEST_CASE(a_pulled_cable_is_seen_and_after_it_firmware_and_homing_come_anew, Setting) {
  make();
  open();
  emulator->begin(UsbFault::unplug);
  bool failed = false;
  for (int i = 0; i < 200 && !failed; ++i) failed = !exchange(0.05) && failure.error == LinkError::reset;
  BOOST_TEST(failed, failure.text);
  link->close();
  BOOST_TEST(!link->open(failure));
  BOOST_TEST((failure.error == LinkError::disconnected), failure.text);
  emulator->begin(UsbFault::replug);
  open();
  exchange_well();
  BOOST_TEST(effort() == 0);
}

BOOST_FIXTURE_TEST_CASE(silence_and_garbage_fail_and_leave_no_position_behind, Setting) {
  make();
  open();
  for (const UsbFault fault : {UsbFault::silent, UsbFault::garbage, UsbFault::short_report, UsbFault::empty_report}) {
    emulator->begin(fault);
    bool failed = false;
    for (int i = 0; i < 200 && !failed; ++i) {
      failed = !exchange(0);
      if (!failed) {
        for (std::size_t a = 0; a < 3; ++a) BOOST_TEST(std::isfinite(sample.q[a]));
      }
    }
    BOOST_TEST(failed);
    BOOST_TEST((failure.error == LinkError::timeout || failure.error == LinkError::protocol), failure.text);
    emulator->begin(UsbFault::well);
    exchange_well();
  }
}

BOOST_FIXTURE_TEST_CASE(another_device_under_the_same_numbers_is_refused, Setting) {
  emulation.kind = "report";  // it has interrupt endpoints and no serial chip
  emulation.bulk = false;
  emulation.input.size = emulation.output.size = 16;
  make();
  BOOST_TEST(!link->open(failure));
  BOOST_TEST((failure.error == LinkError::identity), failure.text);
  BOOST_TEST(failure.text.find("another device") != std::string::npos, failure.text);
}

BOOST_AUTO_TEST_CASE(a_file_that_can_be_no_firmware_is_refused_by_name) {
  const TemporaryFolder folder;
  const auto refused = [&](std::size_t size, const char* says) {
    const std::filesystem::path file = folder.path() / "image.bin";
    std::ofstream(file, std::ios::binary) << std::string(size, 'x');
    BOOST_CHECK_EXCEPTION(read_falcon_firmware(file), InputError, [&](const InputError& error) {
      const std::string text = error.what();
      return text.find(file.string()) != std::string::npos && text.find(says) != std::string::npos;
    });
  };
  refused(0, "found 0");
  refused(1023, "found 1023");
  refused(2'000'000, "found more");
  BOOST_CHECK_THROW(read_falcon_firmware(folder.path() / "none.bin"), InputError);
  const std::filesystem::path good = folder.path() / "good.bin";
  std::ofstream(good, std::ios::binary) << std::string(4000, 'x');
  BOOST_TEST(read_falcon_firmware(good).size() == 4000U);
}

BOOST_AUTO_TEST_SUITE_END()
