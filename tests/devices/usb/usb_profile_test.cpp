// Profiles of USB devices: the shipped ones, every kind of error with its place, and spoilt files by the thousand.
#include <boost/random/mersenne_twister.hpp>
#include <boost/random/uniform_int_distribution.hpp>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "devices/hardware/profile_files.hpp"
#include "devices/usb/emulator/emulation.hpp"
#include "devices/usb/profile.hpp"
#include "framework/core/check.hpp"
#include "framework/yaml/diagnostics.hpp"
#include "framework/yaml/file_finder.hpp"

BOOST_AUTO_TEST_SUITE(usb_profile_test)

using namespace tactor;

namespace {

const std::string folder = std::string(TACTOR_SOURCE_DIR) + "/devices/usb/profiles";

std::string polhem_text() {
  std::ifstream in(folder + "/polhem.yaml");
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// The Polhem's text with one part put in the place of another, which must be there.
std::string with(const std::string& from, const std::string& to) {
  std::string text = polhem_text();
  const std::size_t at = text.find(from);
  BOOST_TEST_REQUIRE(at != std::string::npos, from);
  return text.replace(at, from.size(), to);
}

/// What is wrong with a text; empty: nothing.
std::string wrong(const std::string& text) {
  try {
    parse_usb_profile(text, "p.yaml");
  } catch (const YamlError& error) {
    return error.what();
  }
  return {};
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_polhem_is_read_as_its_board_is_published) {
  const UsbProfile p = read_usb_profile(folder + "/polhem.yaml");
  BOOST_TEST(p.name == "polhem");
  BOOST_TEST(p.vendor == 0x1234);
  BOOST_TEST(p.product == 6);
  BOOST_TEST(p.input.size == 14U);
  BOOST_TEST(p.output.size == 14U);
  BOOST_TEST_REQUIRE(p.axes.size() == 3U);
  // 2000 counts a turn, a capstan of 10 mm on drums of 180 mm and 100 mm; 53.8 mN m an ampere.
  const double turn = 2 * std::numbers::pi / 2000;
  for (std::size_t i = 0; i < 3; ++i) {
    const double ratio = 10.0 / (i == 0 ? 180 : 100);
    BOOST_TEST(std::abs(p.input.axes[i].scale + turn * ratio) < 1e-12);
    BOOST_TEST(std::abs(1 / p.output.axes[i].scale + 1e-3 * 53.8e-3 / ratio) < 1e-12);
    BOOST_TEST(p.output.axes[i].limit == 1999);
  }
  const auto kinematics = p.make_kinematics();
  BOOST_TEST(kinematics->axes() == 3);
  Pose X_BD;
  BOOST_TEST(kinematics->forward({0, 0, std::numbers::pi / 2}, X_BD));
  BOOST_TEST(norm(X_BD.p - Vec3{p.emulation.start[0], p.emulation.start[1], p.emulation.start[2]}) < 1e-9);
}

BOOST_AUTO_TEST_CASE(errors_name_their_place_and_what_was_expected) {
  struct Case {
    std::string from, to, place, says;
  };
  const std::vector<Case> cases{
      {"vendor: 0x1234", "vendor: 0x12345", "p.yaml:6:", "0 to 65535"},
      {"vendor: 0x1234", "vendor: four", "p.yaml:6:", "whole number"},
      {"vendor: 0x1234", "vender: 0x1234", "p.yaml:6:", "did you mean \"vendor\""},
      {"transfer: interrupt", "transfer: isochronous", "p.yaml:8:", "bulk"},
      {"rate: 1 kHz", "rate: 1 mm", "p.yaml:9:", "a rate (Hz)"},
      {"rate: 1 kHz", "rate: 1 MHz", "p.yaml:9:", "8000"},
      {"asks_first: true ", "asks_first: yes ", "p.yaml:11:", "true"},
      {"size: 14", "size: 0", "p.yaml:13:", "1 to 512"},
      {"size: 14", "size: 9", "", "within the 9 bytes"},
      {"encoder_b: {at: 2, type: int16}", "encoder_b: {at: 2, type: int24}", "p.yaml:16:", "int16"},
      {"encoder_b: {at: 2, type: int16}", "encoder_b: {at: -2, type: int16}", "p.yaml:16:", "0 to 511"},
      {"encoder_b: {at: 2, type: int16}", "encoder_b: {type: int16}", "p.yaml:16:", "expected at"},
      {"encoder_b: {at: 2, type: int16}", "encoder_b: 2", "p.yaml:16:", "a map"},
      {"position: encoder_b", "position: encoder_x", "", "expected one of the fields"},
      {"position: encoder_b", "position: encoder_a", "", "a field of its own"},
      {"effort: current_b", "effort: current_a", "", "a field of its own"},
      {"step: -0.018 deg", "step: 0 deg", "", "other than 0"},
      {"step: -0.018 deg", "step: -0.018 mm", "", "an angle (rad)"},
      {"effort_step: -538e-6 N m", "effort_step: -538e-6 N", "", "a torque (N m)"},
      {"limit: 1999, speed", "limit: -1, speed", "", "above 0"},
      {"speed_max: 25 rad/s", "speed_max: .inf", "", "a turning rate"},
      {"type: wooden", "type: delta", "", "wooden"},
      {"lengths: [58 mm, 174 mm, 133 mm]", "lengths: [58 mm, 174 mm]", "", "3"},
      {"lengths: [58 mm, 174 mm, 133 mm]", "lengths: [58 mm, 0 mm, 133 mm]", "", "above 0"},
      {"fixed: {command: 0}", "fixed: {comand: 0}", "", "did you mean \"command\""},
      {"fixed: {command: 0}", "fixed: {command: 40000}", "", "32767"},
      {"above: 5000", "bit: 16", "", "0 to 15"},
      {"above: 5000", "bit: 3, above: 5000", "", "one of bit and above"},
      {"- [2 s, 0, 0, -30 mm]", "- [0 s, 0, 0, -30 mm]", "", "a time after the one before"},
      {"- [2 s, 0, 0, -30 mm]", "- [2 s, 0, 0]", "", "[t, x, y, z]"},
      {"mass: 0.6 kg", "mass: 0 kg", "", "0.001"},
      {"title: Polhem 1, open hardware with the WoodenHaptics geometry", "title: {}", "p.yaml:4:", "a text"},
      {"calibration: the base", "kalibration: the base", "", "did you mean \"calibration\""},
  };
  for (const Case& c : cases) {
    const std::string error = wrong(with(c.from, c.to));
    BOOST_TEST_INFO(c.to << " -> " << error);
    BOOST_TEST(error.starts_with(c.place.empty() ? "p.yaml:" : c.place));
    BOOST_TEST_INFO(c.to << " -> " << error);
    BOOST_TEST(error.find(c.says) != std::string::npos);
  }
}

BOOST_AUTO_TEST_CASE(files_that_are_no_profiles_are_refused) {
  for (const char* text : {"", "[]", "a", "{}", "title: a", "usb: 3", "axes: {}", "title: [", "\t", "? a\n: b",
                           "title: a\nusb: {}\nreport: {}\ncommand: {}\nkinematics: {type: linear}\naxes: []\n",
                           "title: a\nkinematics: {type: linear, directions: []}\n",
                           "title: a\nkinematics: {type: linear, directions: [[0, 0, 0]]}\n",
                           "title: a\nkinematics: {type: linear, directions: [[1, 0, 0], [1, 0, 1e-3]]}\n"}) {
    BOOST_TEST(wrong(text).starts_with("p.yaml"), "<" << text << "> " << wrong(text));
  }
  BOOST_CHECK_THROW(read_usb_profile(folder + "/none.yaml"), InputError);
  BOOST_CHECK_THROW(named_file("none", profiles_of("usb")), InputError);
}

BOOST_AUTO_TEST_CASE(a_linear_profile_is_read) {
  const std::string text = R"(title: a slide
usb: {vendor: 0x1d50, product: 0x5678, transfer: bulk, rate: 500 Hz, endpoints: {in: 0x81, out: 0x02}}
report: {size: 5, fields: {x: {at: 0, type: int32}, status: {at: 4, type: uint8}}}
command: {size: 4, fields: {force: {at: 0, type: float32, order: big}}}
kinematics: {type: linear, directions: [[0, 0, 2]]}
axes: [{name: x, position: x, step: 1 um, effort: force, effort_step: 1 N, limit: 8, speed_max: 2 m/s, jump_tolerance: 1 mm}]
faults: [{field: status, bit: 0, meaning: too hot}]
)";
  const UsbProfile p = parse_usb_profile(text, "slide.yaml");
  BOOST_TEST(p.axes[0].effort_max == 8);
  BOOST_TEST(std::abs(p.input.axes[0].scale - 1e-6) < 1e-18);
  const auto kinematics = p.make_kinematics();
  Pose X_BD;
  BOOST_TEST(kinematics->forward({0.1}, X_BD));
  BOOST_TEST(std::abs(X_BD.p.z - 0.1) < 1e-15);
  AxisValues effort;
  kinematics->efforts({0.1}, {{1, 2, 3}, {}}, effort);
  BOOST_TEST(effort[0] == 3);
}

BOOST_AUTO_TEST_CASE(spoilt_profiles_are_refused_or_read_and_nothing_else) {
  boost::random::mt19937_64 random(11);
  const std::string whole = polhem_text();
  boost::random::uniform_int_distribution<std::size_t> place(0, whole.size() - 1), length(1, 40);
  boost::random::uniform_int_distribution<int> kind(0, 3), byte(0, 255);
  int read = 0, refused = 0;
  for (int i = 0; i < 5000; ++i) {
    std::string text = whole;
    const std::size_t at = place(random), n = length(random);
    switch (kind(random)) {
      case 0:
        text[at] = static_cast<char>(byte(random));
        break;
      case 1:
        text.erase(at, n);
        break;
      case 2:
        text.insert(at, whole.substr(place(random), n));
        break;
      default:
        text.resize(at);
    }
    (wrong(text).empty() ? read : refused) += 1;
  }
  BOOST_TEST(read + refused == 5000);
  BOOST_TEST(refused > 1000);
}

BOOST_AUTO_TEST_CASE(an_emulation_goes_through_its_text_and_back) {
  Emulation e;
  e.path = "/dev/x y";
  e.name = "a device";
  e.serial = "s-1";
  e.geometry = "linear";
  e.numbers = {0, 0, 1};
  e.input.size = 4;
  e.output.size = 2;
  e.input.fields = {{"x", 0, FieldType::i32, ByteOrder::big}};
  e.output.fields = {{"f", 0, FieldType::i16, ByteOrder::little}};
  e.input.axes = {{0, 1e-6, 0.1}};
  e.input.buttons = {{0, -1, 5000, ""}};
  e.output.axes = {{0, -250, 1000}};
  e.hand.times = {0, 1};
  e.hand.points = {{0, 0, 0.01}, {0, 0, 1.0 / 3}};
  FaultOrder order;
  BOOST_TEST(parse_fault_order("unplug@driven+0.3s", order) == "");
  e.faults.push_back(order);
  Emulation back;
  BOOST_TEST(read_emulation(to_text(e), back) == "");
  BOOST_TEST(to_text(back) == to_text(e));
  BOOST_TEST(back.hand.points[1].z == 1.0 / 3);
  BOOST_REQUIRE(back.input.buttons.size() == 1U);
  BOOST_TEST(back.input.buttons[0].above == 5000);
  BOOST_TEST(read_emulation("kind report\nnonsense 3\n", back) == "line 2: nonsense 3");
  BOOST_TEST(read_emulation("", back) == "no path");
}

BOOST_AUTO_TEST_CASE(orders_of_faults_are_read_strictly) {
  FaultOrder order;
  BOOST_TEST(parse_fault_order("jump@1.5", order) == "");
  BOOST_TEST((order.when == FaultOrder::When::time));
  BOOST_TEST(parse_fault_order("replug@+0.5", order) == "");
  BOOST_TEST((order.when == FaultOrder::When::after));
  for (const char* text : {"", "jump", "jmp@1", "jump@", "jump@x", "jump@-1", "jump@driven1", "jump@nan", "jump@1e9"}) {
    BOOST_TEST_INFO(text);
    BOOST_TEST(!parse_fault_order(text, order).empty());
  }
}

BOOST_AUTO_TEST_CASE(faults_come_one_after_another) {
  FaultScript script(
      {{UsbFault::unplug, FaultOrder::When::driven, 0.01}, {UsbFault::replug, FaultOrder::When::after, 0.005}});
  UsbFault fault{};
  int frames = 0;
  while (frames < 50) {
    BOOST_TEST(!script.advance(1e-3, true, false, fault));  // not driven yet
    ++frames;
  }
  frames = 0;
  while (!script.advance(1e-3, true, true, fault)) ++frames;
  BOOST_TEST((fault == UsbFault::unplug));
  BOOST_TEST(std::abs(frames - 10) <= 1);
  frames = 0;
  while (!script.advance(1e-3, false, false, fault)) ++frames;
  BOOST_TEST((fault == UsbFault::replug));
  BOOST_TEST(std::abs(frames - 4) <= 1);
  for (int i = 0; i < 100; ++i) BOOST_TEST(!script.advance(1, true, true, fault));
}

BOOST_AUTO_TEST_SUITE_END()
