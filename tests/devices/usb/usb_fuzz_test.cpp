// Reports that no device means, from a seeded generator, through unmodified libusb into UsbLink: of any size, with any
// bytes, or none. What is believed is what a report says, counters that began anew included, and all else is an error.
// TACTOR_FUZZ_INPUTS=1000000 takes a million reports instead of 20,000.
#include <algorithm>
#include <atomic>
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <boost/test/unit_test.hpp>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <sstream>
#include <thread>

#include "devices/usb/emulator/interposition.hpp"
#include "devices/usb/usb_link.hpp"
#include "framework/core/temporary_folder.hpp"

BOOST_AUTO_TEST_SUITE(usb_fuzz_test)

using namespace tactor;

namespace {

constexpr const char* path = "/dev/bus/usb/250/004";
constexpr std::size_t report_size = 14;
constexpr double degree = std::numbers::pi / 180;
using Dice = boost::random::mt19937;
using Bytes = std::vector<std::uint8_t>;

int roll(Dice& dice, int least, int most) {
  return boost::random::uniform_int_distribution<int>(least, most)(dice);
}

int inputs() {
  const char* text = std::getenv("TACTOR_FUZZ_INPUTS");
  return text == nullptr ? 20'000 : std::max(1'000, std::atoi(text));
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  BOOST_REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

/// A Polhem that sends of itself and has faults to report.
UsbProfile profile() {
  std::ifstream file(TACTOR_SOURCE_DIR "/devices/usb/profiles/polhem.yaml");
  std::stringstream text;
  text << file.rdbuf();
  const std::string flags =
      "faults:\n  - {field: info, bit: 3, meaning: too hot}\n  - {field: info, bit: 15, meaning: jammed}\n";
  return parse_usb_profile(replaced(replaced(replaced(text.str(), "asks_first: true", "asks_first: false"),
                                             "report_timeout: 50 ms", "report_timeout: 10 ms"),
                                    "buttons:", flags + "buttons:"),
                           "noisy.yaml");
}

/// Sends a report for each command, or all the time; which one its owner says. Its owner holds the node's lock.
class Noise final : public UsbFunction {
 public:
  Bytes next = Bytes(report_size, 0);
  bool sends_always = true, silent = false;
  std::vector<Bytes> sent;  ///< after the one that was believed last

  std::vector<std::uint8_t> descriptors() override {
    const EndpointDescription endpoints[] = {{0x81, 3, 64, 1}, {0x01, 3, 64, 1}};
    return make_descriptors(0x1234, 0x0006, 3, endpoints);
  }
  std::optional<std::size_t> control(const UsbSetup& setup, std::span<std::uint8_t> data) override {
    const char* texts[] = {"maker", "noise", "1"};
    return answer_standard_request(setup, data, descriptors(), texts);
  }
  void out(std::uint8_t, std::span<const std::uint8_t>) override { due_ = true; }
  std::optional<Bytes> in(std::uint8_t) override {
    if (silent || (!sends_always && !due_)) return std::nullopt;
    due_ = false;
    sent.push_back(next);
    return next;
  }

 private:
  bool due_ = false;
};

/// Frames of USB as fast as they go.
class Frames {
 public:
  explicit Frames(UsbfsNode& node)
      : thread_([this, &node] {
          while (!stop_) {
            node.frame();
            std::this_thread::sleep_for(std::chrono::microseconds(20));
          }
        }) {}
  ~Frames() {
    stop_ = true;
    thread_.join();
  }

 private:
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

std::int16_t word(const Bytes& report, std::size_t i) {
  return static_cast<std::int16_t>(report[2 * i] | report[2 * i + 1] << 8);
}

Bytes any_report(Dice& dice) {
  const int kind = roll(dice, 0, 9);
  const auto size = kind > 2 ? report_size : static_cast<std::size_t>(roll(dice, 0, kind == 0 ? 100 : 64));
  Bytes bytes(size);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(roll(dice, 0, 255));
  return bytes;
}

/// Whether a sample is what a report says; the counters were at `zero` in the pose of calibration.
bool says(const Bytes& report, const std::array<std::int16_t, 3>& zero, const LinkSample& sample) {
  if (report.size() != report_size) return false;
  const double step[3] = {-0.01 * degree, -0.018 * degree, -0.018 * degree}, at_zero[3] = {0, 0, 90 * degree};
  for (std::size_t i = 0; i < 3; ++i) {
    // Subtraction of 16 bits goes the shorter way round by itself; half way round both are as short.
    const auto moved = static_cast<std::int16_t>(word(report, i) - zero[i]);
    const double q = step[i] * moved + at_zero[i], other = moved == -32768 ? -step[i] * moved + at_zero[i] : q;
    if (std::abs(sample.q[i] - q) > 1e-9 && std::abs(sample.q[i] - other) > 1e-9) return false;
  }
  const auto info = static_cast<std::uint16_t>(word(report, 6));
  return sample.buttons == (word(report, 3) > 5000 ? 1U : 0U) &&
         sample.faults == ((info >> 3 & 1U) | (info >> 15 & 1U) << 1);
}

}  // namespace

BOOST_AUTO_TEST_CASE(reports_of_any_size_and_content_are_read_right_or_refused) {
  Dice dice(20260105);
  Noise noise;
  const std::array<std::int16_t, 3> zero{32000, -32000, 17};
  for (std::size_t i = 0; i < 3; ++i) {
    noise.next[2 * i] = static_cast<std::uint8_t>(zero[i] & 0xff);
    noise.next[2 * i + 1] = static_cast<std::uint8_t>(zero[i] >> 8 & 0xff);
  }
  UsbfsNode node(path, noise);
  interpose(node);
  const TemporaryFolder folder;
  long good = 0, faulty = 0, wrong_size = 0, too_long = 0, silent = 0;
  {
    const Frames frames(node);
    UsbLink link(profile(), UsbChoice{"", path}, CalibrationStore(folder.path()));
    link.calibrate(Duration{1'000'000});
    LinkFailure failure;
    for (int i = 0; i < 100 && !link.open(failure); ++i) {
      BOOST_TEST_REQUIRE((failure.error == LinkError::timeout), failure.text);
    }
    BOOST_TEST_REQUIRE((failure.error == LinkError::none), failure.text);
    node.locked([&] { noise.sends_always = false; });
    for (int i = 0; i < inputs(); ++i) {
      const Bytes report = any_report(dice);
      const bool answers = roll(dice, 0, 199) > 0;
      node.locked([&] {
        noise.next = report;
        noise.silent = !answers;
      });
      LinkSample sample;
      failure = {};
      if (!link.exchange({}, sample, failure)) {
        const bool size = failure.text.find("bytes, expected 14") != std::string::npos;
        const bool length = failure.text.find("longer than a packet") != std::string::npos;
        const bool timeout = failure.error == LinkError::timeout;
        BOOST_REQUIRE_MESSAGE(size || length || timeout, failure.text);
        BOOST_REQUIRE(timeout || failure.error == LinkError::protocol);
        ++(size ? wrong_size : length ? too_long : silent);
        continue;
      }
      const bool told = node.locked([&] {
        const auto same = [&](const Bytes& sent) { return says(sent, zero, sample); };
        const auto found = std::find_if(noise.sent.begin(), noise.sent.end(), same);
        if (found == noise.sent.end()) return false;
        // What was sent after it, to a command that had timed out, may still come.
        noise.sent.erase(noise.sent.begin(), found + 1);
        return true;
      });
      BOOST_REQUIRE_MESSAGE(told, "report " << i << " gave a sample that no report says");
      BOOST_REQUIRE(failure.text.empty() == (sample.faults == 0));
      BOOST_REQUIRE((failure.text.find("jammed") != std::string::npos) == ((sample.faults & 2U) != 0));
      ++(sample.faults == 0 ? good : faulty);
    }
    link.close();
  }
  withdraw(node);
  for (const long count : {good, faulty, wrong_size, too_long, silent}) BOOST_TEST(count > 0);
}

BOOST_AUTO_TEST_SUITE_END()
