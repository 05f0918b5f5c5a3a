// Devices that come and go on a bus of umockdev, found by unmodified libusb through udev and sysfs.
#include <umockdev.h>

#include <boost/test/unit_test.hpp>
#include <chrono>
#include <functional>
#include <thread>

#include "devices/usb/emulator/emulator.hpp"
#include "devices/usb/emulator/interposition.hpp"
#include "devices/usb/usb_port.hpp"

using namespace tactor;

namespace {

constexpr const char* node_path = "/dev/bus/usb/001/002";

/// A bus of its own, on which udev tells of devices; run under umockdev-wrapper.
class Bus {
 public:
  Bus() : testbed_(umockdev_testbed_new()) {}
  ~Bus() { g_object_unref(testbed_); }
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  void plug(UsbFunction& function) {
    const auto bytes = function.descriptors();
    std::string hex;
    for (const std::uint8_t byte : bytes) {
      char text[3];
      std::snprintf(text, sizeof text, "%02X", byte);
      hex += text;
    }
    const std::string description =
        "P: /devices/pci0000:00/0000:00:01.0/usb1/1-1\n"
        "N: bus/usb/001/002\n"
        "E: DEVNAME=/dev/bus/usb/001/002\n"
        "E: DEVTYPE=usb_device\n"
        "E: BUSNUM=001\n"
        "E: DEVNUM=002\n"
        "E: SUBSYSTEM=usb\n"
        "A: busnum=1\\n\n"
        "A: devnum=2\\n\n"
        "A: speed=12\\n\n"
        "A: bConfigurationValue=1\\n\n"
        "H: descriptors=" +
        hex + "\n";
    GError* error = nullptr;
    const bool added = umockdev_testbed_add_from_string(testbed_, description.c_str(), &error) != 0;
    BOOST_TEST_REQUIRE(added, (error != nullptr ? error->message : ""));
    umockdev_testbed_uevent(testbed_, syspath, "add");
  }
  void unplug() {
    umockdev_testbed_uevent(testbed_, syspath, "remove");
    umockdev_testbed_remove_device(testbed_, syspath);
  }

 private:
  static constexpr const char* syspath = "/sys/devices/pci0000:00/0000:00:01.0/usb1/1-1";
  UMockdevTestbed* testbed_;
};

bool eventually(const std::function<bool()>& condition) {
  for (int i = 0; i < 20'000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

Emulation slide() {
  Emulation e;
  e.path = node_path;
  e.vendor = 0x1234;
  e.product = 6;
  e.name = "slide";
  e.serial = "hotplug";
  e.geometry = "linear";
  e.numbers = {0, 0, 1};
  e.input.size = 4;
  e.output.size = 2;
  e.input.fields = {{"x", 0, FieldType::i32, ByteOrder::little}};
  e.output.fields = {{"f", 0, FieldType::i16, ByteOrder::little}};
  e.input.axes = {{0, 1e-6, 0}};
  e.output.axes = {{0, 250, 1000}};
  return e;
}

const UsbNumbers ours[] = {{0x1234, 6}}, others[] = {{0x1234, 7}, {6, 0x1234}};

class Keeping final : public UsbListener {
 public:
  int reports = 0;
  void received(std::span<const std::uint8_t>) override { ++reports; }
};

}  // namespace

BOOST_AUTO_TEST_CASE(a_device_is_found_when_it_comes_lost_when_it_goes_and_found_again) {
  Bus bus;
  UsbBus usb;
  std::string why;
  const UsbSelector selector{0x1234, 6, "", ""};
  BOOST_TEST(usb.open(selector, why) == nullptr);
  BOOST_TEST(why.find("1234:0006") != std::string::npos, why);

  UsbEmulator emulator(slide());
  interpose(emulator.node());
  emulator.run();
  std::string identity;
  for (int round = 0; round < 3; ++round) {
    BOOST_TEST_CONTEXT("plugged in " << round + 1 << " times") {
      bus.plug(emulator.device());
      if (round > 0) emulator.begin(UsbFault::replug);
      std::unique_ptr<UsbPort> port;
      BOOST_TEST_REQUIRE(eventually([&] { return (port = usb.open(selector, why)) != nullptr; }), why);
      BOOST_TEST(port->info().path == "1-1");
      BOOST_TEST(port->info().name == "slide");
      BOOST_TEST(port->identity() != identity);
      identity = port->identity();
      port.reset();
      const auto found = usb.devices(ours);
      BOOST_TEST_REQUIRE(found.size() == 1U);
      BOOST_TEST(found[0].name == "slide");
      // One of another kind is not opened.
      const int opened = emulator.node().openings();
      BOOST_TEST(usb.devices(others).empty());
      BOOST_TEST(emulator.node().openings() == opened);
      port = usb.open(selector, why);
      BOOST_TEST_REQUIRE(port != nullptr, why);
      Keeping keeping;
      BOOST_TEST_REQUIRE(port->start({}, keeping) == "");
      BOOST_TEST(eventually([&] {
        port->wait(Duration{1'000'000});
        return keeping.reports > 5;
      }));
      emulator.begin(UsbFault::unplug);
      bus.unplug();
      BOOST_TEST(eventually([&] { return port->wait(Duration{1'000'000}) == UsbResult::disconnected; }));
      port.reset();
      BOOST_TEST(eventually([&] { return usb.devices(ours).empty(); }));
      BOOST_TEST(usb.open(selector, why) == nullptr);
    }
  }
  withdraw(emulator.node());
}
