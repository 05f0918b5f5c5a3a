// UsbPort through unmodified libusb, with the usbfs protocol answered by an emulated device in this process.
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <boost/test/unit_test.hpp>
#include <chrono>
#include <ctime>
#include <functional>
#include <thread>

#include "devices/usb/emulator/interposition.hpp"
#include "devices/usb/usb_port.hpp"

BOOST_AUTO_TEST_SUITE(usb_port_test)

using namespace tactor;

namespace {

std::atomic<time_t> slept{0};  // s, by the clocks of this program

}  // namespace

// In front of the C library's, so that a test can let the machine sleep.
extern "C" int clock_gettime(clockid_t clock, timespec* t) noexcept {
  const auto code = static_cast<int>(syscall(SYS_clock_gettime, clock, t));
  if (code == 0 && clock == CLOCK_BOOTTIME) t->tv_sec += slept;
  return code;
}

namespace {

constexpr const char* path = "/dev/bus/usb/250/002";

/// A device that sends its counter in each report, and keeps what it is sent.
class Counting final : public UsbFunction {
 public:
  std::uint16_t product = 6;
  std::uint8_t in_attributes = 3;
  std::size_t length = 14;
  bool silent = false;
  std::vector<std::vector<std::uint8_t>> sent;
  std::uint8_t counter = 0;
  int closings = 0;

  std::vector<std::uint8_t> descriptors() override {
    const std::vector<EndpointDescription> endpoints{{0x81, in_attributes}, {0x01, 3}};
    return make_descriptors(0x1234, product, 3, endpoints);
  }
  std::optional<std::size_t> control(const UsbSetup& setup, std::span<std::uint8_t> data) override {
    static constexpr const char* texts[] = {"maker", "thing", "serial-1"};
    if (setup.type == 0xc0 && setup.request == 5) {  // of its maker: tells its counter
      data[0] = counter;
      return 1;
    }
    return answer_standard_request(setup, data, descriptors(), texts);
  }
  void out(std::uint8_t, std::span<const std::uint8_t> data) override { sent.emplace_back(data.begin(), data.end()); }
  std::optional<std::vector<std::uint8_t>> in(std::uint8_t) override {
    if (silent) return std::nullopt;
    return std::vector<std::uint8_t>(length, ++counter);
  }
  void closed() override { ++closings; }
};

/// Keeps what it was told.
class Keeping final : public UsbListener {
 public:
  std::vector<std::vector<std::uint8_t>> reports;
  void received(std::span<const std::uint8_t> bytes) override { reports.emplace_back(bytes.begin(), bytes.end()); }
};

struct Setting {
  Counting device;
  UsbfsNode node{path, device};
  UsbBus bus;
  std::string why;
  Setting() { interpose(node); }
  ~Setting() { withdraw(node); }
  std::unique_ptr<UsbPort> open() { return bus.open({0x1234, 6, "", path}, why); }
};

/// Moves frames on and lets transfers end until `done`; the worst result.
UsbResult pump(Setting& setting, UsbPort& port, const std::function<bool()>& done, int most = 1000) {
  UsbResult worst = UsbResult::ok;
  for (int i = 0; i < most && !done(); ++i) {
    setting.node.frame();
    const UsbResult result = port.wait(Duration{100'000});
    if (result != UsbResult::ok) worst = result;
  }
  return worst;
}

}  // namespace

BOOST_FIXTURE_TEST_CASE(a_device_tells_who_it_is, Setting) {
  const auto port = open();
  BOOST_TEST_REQUIRE(port != nullptr, why);
  BOOST_TEST(port->info().vendor == 0x1234);
  BOOST_TEST(port->info().product == 6);
  BOOST_TEST(port->info().name == "thing");
  BOOST_TEST(port->info().serial == "serial-1");
}

BOOST_FIXTURE_TEST_CASE(reports_come_in_order_and_what_is_sent_arrives, Setting) {
  Keeping keeping;
  auto port = open();
  BOOST_TEST_REQUIRE(port != nullptr, why);
  BOOST_TEST(port->start({}, keeping) == "");
  const std::vector<std::uint8_t> message{1, 2, 3};
  BOOST_TEST(port->send(message));
  BOOST_TEST(!port->send(message));  // the first is on its way
  BOOST_TEST((pump(*this, *port, [&] { return keeping.reports.size() >= 10; }) == UsbResult::ok));
  BOOST_TEST_REQUIRE(keeping.reports.size() >= 10);
  for (std::size_t i = 0; i < keeping.reports.size(); ++i) {
    BOOST_TEST(keeping.reports[i].size() == 14);
    BOOST_TEST(keeping.reports[i][0] == i + 1);
  }
  BOOST_TEST_REQUIRE(device.sent.size() == 1);
  BOOST_TEST(device.sent[0] == message);
  port.reset();
  BOOST_TEST(device.closings == 1);
}

BOOST_FIXTURE_TEST_CASE(a_request_is_answered_or_stalls, Setting) {
  const auto port = open();
  BOOST_TEST_REQUIRE(port != nullptr, why);
  device.counter = 42;
  std::uint8_t byte[1] = {0};
  BOOST_TEST((port->control(0xc0, 5, 0, 0, byte, Duration{500'000'000}) == UsbResult::ok));
  BOOST_TEST(byte[0] == 42);
  BOOST_TEST((port->control(0xc0, 99, 0, 0, byte, Duration{500'000'000}) == UsbResult::stalled));
}

BOOST_FIXTURE_TEST_CASE(short_and_empty_reports_come_as_they_are, Setting) {
  Keeping keeping;
  const auto port = open();
  BOOST_TEST_REQUIRE(port != nullptr, why);
  BOOST_TEST(port->start({}, keeping) == "");
  device.length = 5;
  pump(*this, *port, [&] { return keeping.reports.size() >= 2; });
  device.length = 0;
  pump(*this, *port, [&] { return keeping.reports.size() >= 4; });
  BOOST_TEST_REQUIRE(keeping.reports.size() >= 4);
  BOOST_TEST(keeping.reports.front().size() == 5);
  BOOST_TEST(keeping.reports.back().empty());
}

BOOST_FIXTURE_TEST_CASE(a_report_beyond_a_packet_is_an_overflow_and_reading_goes_on, Setting) {
  Keeping keeping;
  const auto port = open();
  BOOST_TEST_REQUIRE(port != nullptr, why);
  BOOST_TEST(port->start({}, keeping) == "");
  device.length = 65;
  UsbResult result = UsbResult::ok;
  for (int i = 0; i < 1000 && result == UsbResult::ok; ++i) {
    node.frame();
    result = port->wait(Duration{100'000});
  }
  BOOST_TEST((result == UsbResult::overflow));
  device.length = 14;
  pump(*this, *port, [&] { return keeping.reports.size() >= 3; });
  BOOST_TEST(keeping.reports.size() >= 3);
}

BOOST_FIXTURE_TEST_CASE(a_silent_device_keeps_nobody_waiting_and_can_be_closed, Setting) {
  Keeping keeping;
  device.silent = true;
  auto port = open();
  BOOST_TEST_REQUIRE(port != nullptr, why);
  BOOST_TEST(port->start({}, keeping) == "");
  BOOST_TEST((pump(
                  *this, *port, [] { return false; }, 20) == UsbResult::ok));
  BOOST_TEST(keeping.reports.empty());
  port.reset();  // with two transfers on their way, which are called back and waited for
  BOOST_TEST(device.closings == 1);
}

BOOST_FIXTURE_TEST_CASE(a_pulled_cable_is_seen_and_the_device_is_found_again, Setting) {
  Keeping keeping;
  auto port = open();
  BOOST_TEST_REQUIRE(port != nullptr, why);
  const std::string identity = port->identity();
  BOOST_TEST(port->start({}, keeping) == "");
  pump(*this, *port, [&] { return keeping.reports.size() >= 3; });
  node.unplug();
  UsbResult result = UsbResult::ok;
  for (int i = 0; i < 1000 && result != UsbResult::disconnected; ++i) result = port->wait(Duration{100'000});
  BOOST_TEST((result == UsbResult::disconnected));
  port.reset();
  BOOST_TEST(open() == nullptr);
  BOOST_TEST(why.find(path) != std::string::npos);
  node.plug();
  port = open();
  BOOST_TEST_REQUIRE(port != nullptr, why);
  BOOST_TEST(port->identity() != identity);
  const std::size_t before = keeping.reports.size();
  BOOST_TEST(port->start({}, keeping) == "");
  pump(*this, *port, [&] { return keeping.reports.size() >= before + 3; });
  BOOST_TEST(keeping.reports.size() >= before + 3);
}

BOOST_FIXTURE_TEST_CASE(the_identity_stays_while_the_device_keeps_its_power, Setting) {
  std::string first = open()->identity();
  BOOST_TEST(open()->identity() == first);
  BOOST_TEST(!first.empty());
}

BOOST_FIXTURE_TEST_CASE(the_identity_changes_where_the_machine_has_slept, Setting) {
  const std::string first = open()->identity();
  slept = 1;
  BOOST_TEST(open()->identity() != first);
  slept = 0;
  BOOST_TEST(open()->identity() == first);
}

BOOST_FIXTURE_TEST_CASE(another_device_under_the_same_numbers_is_found_out_by_its_endpoints, Setting) {
  Keeping keeping;
  device.in_attributes = 2;
  const auto port = open();
  BOOST_TEST_REQUIRE(port != nullptr, why);
  const std::string failure = port->start({}, keeping);
  BOOST_TEST(failure.find("no interrupt endpoint to the host") != std::string::npos, failure);
}

BOOST_FIXTURE_TEST_CASE(another_device_at_the_same_file_is_refused, Setting) {
  device.product = 7;
  BOOST_TEST(open() == nullptr);
  BOOST_TEST(why.find("1234:0007, not 1234:0006") != std::string::npos, why);
}

BOOST_FIXTURE_TEST_CASE(another_serial_number_is_refused, Setting) {
  BOOST_TEST(bus.open({0x1234, 6, "serial-2", path}, why) == nullptr);
  BOOST_TEST(why.find("serial-1") != std::string::npos, why);
  BOOST_TEST(bus.open({0x1234, 6, "serial-1", path}, why) != nullptr);
}

BOOST_FIXTURE_TEST_CASE(a_device_that_is_not_there_is_named, Setting) {
  BOOST_TEST(bus.open({0xfffe, 0xfffd, "", ""}, why) == nullptr);
  BOOST_TEST(why.find("fffe:fffd") != std::string::npos, why);
}

BOOST_AUTO_TEST_SUITE_END()
