// Register maps: values and words, what a profile may say, and what a line can carry.
#include <netdb.h>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

#include "devices/modbus/actuator.hpp"
#include "devices/modbus/claim_names.hpp"
#include "framework/core/temporary_folder.hpp"
#include "tests/support/nodes.hpp"

BOOST_AUTO_TEST_SUITE(profile_test)

using namespace tactor;
using namespace tactor::modbus;

namespace {

const std::string good = R"(title: a test
line: {baud: 115200, parity: even, unit: 3, turnaround: 1 ms}
registers:
  id:       {address: 1, type: uint16, access: read}
  position: {address: 10, type: int32, access: read, scale: 1 um}
  force:    {address: 20, type: int32, access: write, scale: 1 mN, function: 16}
  mode:     {address: 30, type: uint16, access: write, function: 6}
identify:
  - {register: id, value: 7}
start_up:
  - {write: mode, value: 2}
  - {wait: 1 ms}
axes:
  - {position: position, effort: force, effort_max: 5 N, speed_max: 1 m/s, jump_tolerance: 1 mm}
read_gap: 8
)";

// Everything side by side, so that a plan could join what it must not.
const std::string mixed = R"(line: {baud: 115200, parity: even, turnaround: 1 ms}
registers:
  position: {address: 10, type: int32, access: read, scale: 1 um}
  mode:     {address: 20, type: uint16, access: write, function: 6}
  force:    {address: 21, type: int16, access: write, scale: 1 mN, function: 6}
  speed:    {address: 22, type: int16, access: write, function: 16}
  limit:    {address: 23, type: int16, access: write, function: 16}
  state:    {address: 40, type: uint16, access: read}
identify:
  - {register: state, value: 7}
each_cycle: {mode: 1, speed: 2, limit: 3}
fence: {address: 10, count: 4}
axes:
  - {position: position, effort: force, effort_max: 5 N, speed_max: 1 m/s, jump_tolerance: 1 mm}
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  BOOST_REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

std::string error_of(const std::string& text) {
  try {
    parse_profile(text, "p.yaml");
  } catch (const YamlError& error) {
    return error.what();
  }
  return "";
}

RegisterInfo info_of(RegisterType type, double scale, Order words = Order::high_first,
                     Order bytes = Order::high_first) {
  RegisterInfo info;
  info.type = type;
  info.scale = scale;
  info.words = words;
  info.bytes = bytes;
  return info;
}

}  // namespace

BOOST_AUTO_TEST_CASE(words_and_values_agree_in_every_order) {
  // 0x12345678 = 305419896.
  const auto check = [](Order words, Order bytes, std::uint16_t first, std::uint16_t second) {
    const std::uint16_t given[2] = {first, second};
    const RegisterInfo info = info_of(RegisterType::int32, 1, words, bytes);
    BOOST_TEST(decode(info, given) == 305419896.0);
    std::uint16_t made[2] = {};
    encode(info, 305419896.0, made);
    BOOST_TEST(made[0] == first);
    BOOST_TEST(made[1] == second);
  };
  check(Order::high_first, Order::high_first, 0x1234, 0x5678);
  check(Order::low_first, Order::high_first, 0x5678, 0x1234);
  check(Order::high_first, Order::low_first, 0x3412, 0x7856);
  check(Order::low_first, Order::low_first, 0x7856, 0x3412);
}

BOOST_AUTO_TEST_CASE(each_type_holds_its_range_and_clamps_beyond) {
  std::uint16_t w[2] = {};
  const auto round_trip = [&](RegisterType type, double value, double scale = 1) {
    encode(info_of(type, scale), value, w);
    return decode(info_of(type, scale), w);
  };
  BOOST_TEST(round_trip(RegisterType::int16, -32768) == -32768);
  BOOST_TEST(round_trip(RegisterType::int16, 40000) == 32767);
  BOOST_TEST(round_trip(RegisterType::uint16, -3) == 0);
  BOOST_TEST(round_trip(RegisterType::uint16, 65535) == 65535);
  BOOST_TEST(round_trip(RegisterType::int32, -2147483648.0) == -2147483648.0);
  BOOST_TEST(round_trip(RegisterType::int32, 1e20) == 2147483647.0);
  BOOST_TEST(round_trip(RegisterType::uint32, 4294967295.0) == 4294967295.0);
  BOOST_TEST(round_trip(RegisterType::float32, 0.1) == static_cast<double>(0.1F));
  BOOST_TEST(round_trip(RegisterType::int32, 1.2345, 1e-3) == 1.235, boost::test_tools::tolerance(1e-12));
  BOOST_TEST(round_trip(RegisterType::int32, std::numeric_limits<double>::quiet_NaN()) == 0);
  BOOST_TEST(round_trip(RegisterType::float32, std::numeric_limits<double>::infinity()) ==
             static_cast<double>(std::numeric_limits<float>::max()));
  // A negative scale turns the direction round.
  BOOST_TEST(round_trip(RegisterType::int16, -7, -1) == -7);
  BOOST_TEST(static_cast<std::int16_t>(w[0]) == 7);
}

BOOST_AUTO_TEST_CASE(a_field_leaves_the_other_bits_of_its_word) {
  RegisterInfo high = info_of(RegisterType::uint16, 1), low = high;
  high.low_bit = 8;
  high.bits = low.bits = 8;
  std::uint16_t word = 0;
  encode(high, 9, &word);
  encode(low, 300, &word);
  BOOST_TEST(word == 0x09ff);
  BOOST_TEST(decode(high, &word) == 9);
  BOOST_TEST(decode(low, &word) == 255);
}

BOOST_AUTO_TEST_CASE(a_profile_says_what_it_says) {
  const Profile p = parse_profile(good, "folder/p.yaml");
  BOOST_TEST(p.name == "p");
  BOOST_TEST(p.line.unit == 3);
  BOOST_TEST(p.registers.size() == 4U);
  BOOST_TEST(p.registers[1].scale == 1e-6);
  BOOST_TEST(p.axes.at(0).effort_max == 5);
  BOOST_TEST(p.start_up.size() == 2U);
}

BOOST_AUTO_TEST_CASE(bad_profiles_are_refused_with_their_place) {
  struct Bad {
    const char* from;
    const char* to;
    const char* says;
  };
  const Bad corpus[] = {
      {"address: 10, type: int32", "address: 65535, type: int32",
       "p.yaml:5:23: registers.position.address: expected a whole number from 0 to 65534, found 65535"},
      {"type: int32, access: read", "type: int64, access: read",
       "p.yaml:5:33: registers.position.type: expected one of int16, uint16, int32, uint32, float32, found int64; did "
       "you mean"},
      {"type: int32, access: read", "type: int32, access: reed",
       "p.yaml:5:48: registers.position.access: expected one of read, write, read_write, found reed"},
      {"scale: 1 um", "scale: 0 um",
       "p.yaml:5:61: registers.position.scale: expected what one count is, such as 1 um, found 0 um"},
      {"scale: 1 um", "scale: 1 furlong", "registers.position.scale: expected what one count is"},
      {"function: 16", "function: 6",
       "p.yaml:6:78: registers.force.function: expected 16 or 23 for a value of 32 bits, found 6"},
      {"function: 16", "function: 3", "registers.force.function: expected a function of its access, found 3"},
      {"function: 16", "function: 5", "registers.force.function: expected 3, 4, 6, 16 or 23, found 5"},
      {"register: id, value: 7", "register: ib, value: 7",
       "p.yaml:9:16: identify[0].register: expected one of the registers (id, position, force, mode), found ib; did "
       "you mean \"id\"?"},
      {"register: id, value: 7", "register: id, value: 70000",
       "identify[0].value: expected a value that id (uint16) can hold, found 70000"},
      {"register: id, value: 7", "register: force, value: 7 N",
       "identify[0].register: expected a register that can be read, found force"},
      {"register: id, value: 7", "register: id", "identify[0]: expected either value, or min and max"},
      {"register: id, value: 7", "register: id, min: 5, max: 4", "identify[0]: expected min at or below max"},
      {"identify:\n  - {register: id, value: 7}\n", "", "expected the key identify, found none"},
      {"write: mode, value: 2", "write: mode", "p.yaml:11:5: start_up[0]: expected the key value, found none"},
      {"write: mode, value: 2", "write: position, value: 2 mm",
       "start_up[0].write: expected a register that can be written"},
      {"wait: 1 ms", "wait: 1 h", "start_up[1].wait: expected a time (s)"},
      {"wait: 1 ms", "wait: 1 ms, write: mode", "start_up[1]: expected one of write, wait and expect"},
      {"effort_max: 5 N", "effort_max: 5 m", "p.yaml:14:53: axes[0].effort_max: expected a force (N), found 5 m"},
      {"effort_max: 5 N", "effort_max: 0 N", "axes[0].effort_max: expected a force (N) above 0"},
      {"position: position, effort", "position: id, effort",
       "axes[0].position: expected a register whose scale is in m, found one in 1"},
      {", speed_max: 1 m/s", "", "axes[0]: expected the key speed_max, found none"},
      {"effort: force,", "effort: force, effort_as: magnitude,",
       "p.yaml:14:5: axes[0]: expected effort_as: magnitude and sign together, found only effort_as: magnitude"},
      {"effort: force,", "effort: force, sign: {register: mode, positive: 1, negative: 2, zero: 0},",
       "axes[0]: expected effort_as: magnitude and sign together, found only sign"},
      {"address: 20, type: int32", "address: 20, type: uint32",
       "p.yaml:14:34: axes[0].effort: expected a register that can hold effort_max in both directions, found force "
       "(uint32)"},
      {"baud: 115200", "baud: 115200, bauds: 3", "line.bauds: expected a key"},
      {"parity: even", "parity: 8E1", "line.parity: expected one of none, even, odd, found 8E1"},
      {"unit: 3", "unit: 0", "line.unit: expected a whole number from 1 to 247, found 0"},
      {"title: a test", "titel: a test", "p.yaml:1:1: titel: expected a key"},
      {"title: a test", "title: a test\ntitle: b", "the key \"title\" is there twice"},
      {"address: 30", "address: 21", "registers.mode: expected words of its own, found those of force"},
      {"registers:\n", "registers: 5\nx:\n", "registers: expected a map of names to registers, found 5"},
  };
  for (const Bad& bad : corpus) {
    const std::string error = error_of(replaced(good, bad.from, bad.to));
    BOOST_TEST(error.find(bad.says) != std::string::npos, std::string(bad.to) + " gave: " + error);
    BOOST_TEST(error.starts_with("p.yaml:"), error);
  }
  BOOST_TEST(error_of("").starts_with("p.yaml"));
  BOOST_TEST(error_of("- 1\n").find("expected a map with the keys") != std::string::npos);
  BOOST_CHECK_THROW(read_profile("/does/not/exist.yaml"), YamlError);
}

BOOST_AUTO_TEST_CASE(a_cycle_joins_what_lies_together_and_writes_nothing_else) {
  Profile p = parse_profile(good, "p.yaml");
  const CyclePlan plan = plan_cycle(p);
  BOOST_TEST(plan.each.size() == 2U);
  BOOST_TEST(plan.each[0].function == 16);
  BOOST_TEST(plan.each[0].write_address == 20);
  BOOST_TEST(plan.each[0].write_count == 2);
  BOOST_TEST(plan.each[1].function == 3);
  BOOST_TEST(plan.each[1].read_count == 2);
  // The read of the cycle has two words and that of the identity has one, so the fence has all from one to the other.
  BOOST_TEST(plan.fence.address == 1);
  BOOST_TEST(plan.fence.count == 11);
  p.combined = true;
  p.registers[2].write_function = 23;
  const CyclePlan combined = plan_cycle(p);
  BOOST_TEST(combined.each.size() == 1U);
  BOOST_TEST(combined.each[0].function == 23);
  // Where no file has said so, a cycle that does not fit the function is refused all the same.
  p.combined = false;
  BOOST_CHECK_THROW(plan_cycle(p), InputError);
  p.registers[2].write_function = 16;
  p.fence = Fence{3, 10, 2};
  BOOST_CHECK_THROW(plan_cycle(p), InputError);
}

BOOST_AUTO_TEST_CASE(a_register_is_written_by_the_function_that_it_declares) {
  const auto writes = [](const std::string& text) {
    std::string result;
    for (const Transaction& t : plan_cycle(parse_profile(text, "p.yaml")).each) {
      result +=
          std::to_string(t.function) + ":" + std::to_string(t.write_address) + "+" + std::to_string(t.write_count);
      result +=
          t.read_count > 0 ? "/" + std::to_string(t.read_address) + "+" + std::to_string(t.read_count) + " " : " ";
    }
    return result;
  };
  // Neighbours by 6 stay apart, those by 16 are one.
  BOOST_TEST(writes(mixed) == "6:20+1 6:21+1 16:22+2 3:0+0/10+2 ");
  // A combined cycle takes by 23 what is declared so, wherever it stands, and nothing else.
  const std::string combined =
      replaced(mixed, "scale: 1 mN, function: 6", "scale: 1 mN, function: 23") + "cycle: combined\n";
  BOOST_TEST(writes(combined) == "6:20+1 16:22+2 23:21+1/10+2 ");
  const std::string two = replaced(combined, "address: 22, type: int16, access: write, function: 16",
                                   "address: 22, type: int16, access: write, function: 23");
  BOOST_TEST(writes(two) == "6:20+1 16:23+1 23:21+2/10+2 ");
  // Two fields of a word by 6 are one write.
  const std::string fields =
      replaced(replaced(mixed, "address: 20, type: uint16, access: write,",
                        "address: 20, type: uint16, bits: [0, 8], access: write,"),
               "address: 21, type: int16, access: write, scale: 1 mN, function: 6}",
               "address: 19, type: int16, access: write, scale: 1 mN, function: 6}\n"
               "  other:    {address: 20, type: uint16, bits: [8, 8], access: write, function: 6}");
  BOOST_TEST(writes(replaced(fields, "mode: 1,", "mode: 1, other: 4,")) == "6:19+1 6:20+1 16:22+2 3:0+0/10+2 ");
  // The rate is that of these requests: by 6 eight characters each way, by 16 with two words 13 and 8, by 3 8 and 9.
  const Profile p = parse_profile(mixed, "p.yaml");
  const double expected = (4 * 8 + 13 + 8 + 8 + 9) * 11.0 / 115200 + 4 * (2 * 1.75e-3 + 1e-3);
  BOOST_TEST(line_rate(plan_cycle(p), p.line, true).cycle_s == expected, boost::test_tools::tolerance(1e-5));
}

BOOST_AUTO_TEST_CASE(function_23_without_a_combined_cycle_is_refused_with_its_place) {
  const auto says = [](const std::string& text, const std::string& expected) {
    BOOST_TEST(error_of(text).find(expected) != std::string::npos, error_of(text));
  };
  const std::string separate = replaced(mixed, "scale: 1 mN, function: 6", "scale: 1 mN, function: 23");
  says(separate, "p.yaml:5:3: registers.force.function: expected 6 or 16 where the cycle is separate");
  const std::string combined = separate + "cycle: combined\n";
  BOOST_TEST(error_of(combined) == "");
  says(mixed + "cycle: combined\n", "p.yaml:15:8: cycle: expected a register with function: 23 among those");
  says(replaced(combined, "address: 23, type: int16, access: write, function: 16",
                "address: 23, type: int16, access: write, function: 23"),
       "p.yaml:7:3: registers.limit.function: expected 6 or 16 for words apart from those of force, found 23");
  says(replaced(combined,
                "  state: ", "  spare:    {address: 50, type: uint16, access: write, function: 23}\n  state: "),
       "p.yaml:8:3: registers.spare.function: expected 6 or 16 for a register that is not written in each cycle");
  says(replaced(combined, "access: read, scale", "access: read, function: 4, scale"),
       "cycle: expected a position that is read by function 3");
  says(replaced(mixed, "access: read, scale", "access: read, function: 23, scale"),
       "registers.position.function: expected a function of its access, found 23");
}

BOOST_AUTO_TEST_CASE(words_that_no_register_names_are_read_only_where_the_profile_allows_it) {
  const auto reads = [](const std::string& text) {
    std::vector<std::pair<int, int>> result;
    for (const Transaction& t : plan_cycle(parse_profile(text, "p.yaml")).each) {
      if (t.read_count > 0) result.emplace_back(t.read_address, t.read_count);
    }
    return result;
  };
  const std::string text = replaced(mixed, "address: 40,", "address: 14,") + "status:\n  state: {others: fault}\n";
  using Reads = std::vector<std::pair<int, int>>;
  BOOST_CHECK((reads(text + "read_gap: 1\n") == Reads{{10, 2}, {14, 1}}));
  BOOST_CHECK((reads(replaced(text, "count: 4", "count: 3")) == Reads{{10, 2}, {14, 1}}));
  BOOST_CHECK((reads(text + "read_gap: 2\n") == Reads{{10, 5}}));
  BOOST_TEST(error_of(text + "read_gap: -1\n").find("read_gap: expected a whole number from 0 to 120, found -1") !=
             std::string::npos);
}

BOOST_AUTO_TEST_CASE(no_read_that_is_ever_asked_for_looks_like_the_fence) {
  const auto fence_of = [](const std::string& text) { return plan_cycle(parse_profile(text, "p.yaml")).fence; };
  // Where the identity is read by one word, a fence of one is refused; where by two, one is right.
  const std::string by_two = replaced(good, "{register: id, value: 7}", "{register: position, min: 0 m, max: 1 m}");
  BOOST_TEST(fence_of(by_two).count == 1);
  BOOST_TEST(fence_of(by_two + "fence: {address: 10, count: 1}\n").address == 10);
  const auto refused = [](const InputError& error) {
    return std::string(error.what()).find("found function 3 and count 1, which one of them has") != std::string::npos;
  };
  BOOST_CHECK_EXCEPTION(fence_of(good + "fence: {address: 10, count: 1}\n"), InputError, refused);
  // So it is with a register that a sequence waits for.
  const std::string waits = replaced(by_two, "  - {wait: 1 ms}", "  - {expect: id, value: 7}");
  BOOST_CHECK_EXCEPTION(fence_of(waits + "fence: {address: 10, count: 1}\n"), InputError, refused);
  // Far from all others, no read is left that the device surely answers.
  const std::string far = replaced(good, "address: 10,", "address: 1000,");
  const auto asks = [](const InputError& error) {
    return std::string(error.what())
        .starts_with("p.yaml:1:1: expected the key fence with a fence, a read that no read");
  };
  BOOST_CHECK_EXCEPTION(fence_of(far), InputError, asks);
  BOOST_TEST(fence_of(far + "fence: {address: 1000, count: 3}\n").count == 3);
}

BOOST_AUTO_TEST_CASE(a_watchdog_of_less_than_two_cycles_is_refused_with_the_figure) {
  const TemporaryFolder folder;
  const auto setup = [&](const std::string& time, double link_rate, const std::string& connect = "rtu:/dev/ttyUSB0") {
    const std::filesystem::path file = folder.path() / "p.yaml";
    std::ofstream(file) << replaced(good, "identify:",
                                    "  patience: {address: 40, type: uint16, access: write, scale: 1 ms}\n"
                                    "watchdog: {register: patience, time: " +
                                        time + "}\nidentify:");
    Actuator::Params params;
    params.profile = file;
    params.connect = connect;
    params.link_rate = link_rate;
    return make_setup(params);
  };
  const auto says = [](const std::string& part) {
    return [part](const InputError& error) { return std::string(error.what()).find(part) != std::string::npos; };
  };
  // The line carries 79.2 Hz at most and runs at 95 % of that of itself: two cycles take 26.59 ms.
  BOOST_TEST(setup("27 ms", 0).danger.empty());
  BOOST_CHECK_EXCEPTION(
      setup("26 ms", 0), InputError,
      says("the watchdog of p: expected a time of at least two cycles of the line, 26.59 ms at 75.23 "
           "Hz, found 26 ms, at which the device would let go again and again; set link_rate to 76.92 Hz"));
  BOOST_TEST(setup("26 ms", 77).rate == 77);
  // 25 ms would take 80 Hz.
  BOOST_CHECK_EXCEPTION(setup("25 ms", 79), InputError,
                        says("the line carries at most 79.19 Hz (a cycle takes 12.6 ms at 115200 baud with 11 bits a "
                             "character): set watchdog.time"));
  // What the graph asks for counts too, exactly twice the cycle is right.
  BOOST_CHECK_EXCEPTION(setup("49 ms", 40), InputError, says("50 ms at 40 Hz, found 49 ms"));
  BOOST_TEST(setup("50 ms", 40).rate == 40);
  // Over TCP the two transactions take the device's turnaround of 1 ms each.
  BOOST_TEST(setup("4 ms", 500, "tcp:host:502").rate == 500);
  BOOST_CHECK_EXCEPTION(setup("3 ms", 500, "tcp:host:502"), InputError, says("4 ms at 500 Hz, found 3 ms"));
}

BOOST_AUTO_TEST_CASE(a_watchdog_has_at_least_a_count_of_its_register) {
  const std::string text = replaced(good, "identify:",
                                    "  patience: {address: 40, type: uint16, access: write, scale: 1 ms}\n"
                                    "watchdog: {register: patience, time: 1.4 ms}\nidentify:");
  // As the device counts it.
  BOOST_TEST(parse_profile(text, "p.yaml").watchdog.value().time.ns == 1'000'000);
  BOOST_TEST(error_of(replaced(text, "1.4 ms", "0.4 ms"))
                 .find("watchdog.time: expected a time of at least a count of its register, found 0.4 ms") !=
             std::string::npos);
}

BOOST_AUTO_TEST_CASE(a_device_without_a_watchdog_is_told_as_a_danger) {
  int without = 0;
  for (const auto& entry : std::filesystem::directory_iterator(TACTOR_SOURCE_DIR "/devices/modbus/profiles")) {
    Actuator::Params params;
    params.profile = entry.path();
    params.connect = "rtu:/dev/ttyUSB0";
    const Setup setup = make_setup(params);
    BOOST_TEST(setup.danger.empty() == setup.profile.watchdog.has_value());
    if (setup.danger.empty()) continue;
    ++without;
    BOOST_TEST(setup.danger.starts_with(entry.path().stem().string() + ": its profile names no watchdog"));
    // Both ways to it: the check of the parameters, and the node.
    std::vector<std::string> of_check, of_node;
    const NodeInfo info = Actuator::declare();
    const std::vector<ParamValue> values =
        test::param_values(info, {{"profile", entry.path().string()}, {"connect", std::string("rtu:/dev/ttyUSB0")}});
    const Scene scene;
    NodeContext context;
    context.scene = &scene;
    context.notes = &of_check;
    info.check(values, context);
    context.notes = &of_node;
    static_cast<void>(info.create(values, context));
    BOOST_TEST(of_check == std::vector<std::string>{setup.danger});
    BOOST_TEST(of_node == of_check);
  }
  BOOST_TEST(without == 2);
}

BOOST_AUTO_TEST_CASE(the_rate_of_a_line_is_that_of_its_characters) {
  const Profile p = parse_profile(good, "p.yaml");
  // 8E1 is 11 bits a character, 95.49 us at 115200. Function 16 with two words: 13 out, 8 back; function 3 with two
  // words: 8 out, 9 back. Twice 1.75 ms of silence and 1 ms of turnaround each.
  const double expected = (13 + 8 + 8 + 9) * 11.0 / 115200 + 2 * (2 * 1.75e-3 + 1e-3);
  const LineRate rate = line_rate(plan_cycle(p), p.line, true);
  BOOST_TEST(rate.cycle_s == expected, boost::test_tools::tolerance(1e-5));
  BOOST_TEST(rate.rate == 1 / expected, boost::test_tools::tolerance(1e-5));
  // Up to 19200 baud the silence is 3.5 characters.
  LineSettings slow = p.line;
  slow.baud = 9600;
  const double of_slow = (13 + 8 + 8 + 9 + 4 * 3.5) * 11.0 / 9600 + 2e-3;
  BOOST_TEST(line_rate(plan_cycle(p), slow, true).cycle_s == of_slow, boost::test_tools::tolerance(1e-5));
  // The published metric for function 23 with 8 words read at 115200 baud, 8E1, is about 7.8 ms a cycle.
  LineSettings quick = p.line;
  quick.turnaround = {};
  const double cycle = seconds_of({.function = 23, .read_count = 8, .write_count = 8}, quick, true);
  BOOST_TEST(cycle == 50 * 11.0 / 115200 + 3.5e-3, boost::test_tools::tolerance(1e-5));
}

BOOST_AUTO_TEST_CASE(a_graph_that_asks_for_more_than_the_line_carries_is_refused_with_the_figure) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "p.yaml";
  std::ofstream(file) << good;
  Actuator::Params params;
  params.profile = file;
  params.connect = "rtu:/dev/ttyUSB0";
  const double limit = make_setup(params).line.rate;
  BOOST_TEST(make_setup(params).rate == 0.95 * limit);
  params.link_rate = limit * 0.999;
  BOOST_TEST(make_setup(params).rate == params.link_rate);
  params.link_rate = limit * 1.001;
  const auto says = [](const InputError& e) {
    const std::string text = e.what();
    return text.find("at most 79.") != std::string::npos && text.find("115200 baud") != std::string::npos;
  };
  BOOST_CHECK_EXCEPTION(make_setup(params), InputError, says);
  params.connect = "tcp:host:1502";
  BOOST_TEST(make_setup(params).rate == params.link_rate);
  for (const char* text : {"", "tcp:", "tcp:host", "tcp:host:0", "tcp:host:70000", "tcp:host:x", "rtu:", "udp:a:1"}) {
    BOOST_CHECK_THROW(parse_endpoint(text), InputError);
  }
}

BOOST_AUTO_TEST_CASE(the_profiles_that_come_with_tactor_are_good) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(TACTOR_SOURCE_DIR "/devices/modbus/profiles")) {
    const Profile p = read_profile(entry.path());
    BOOST_TEST(!p.identify.empty());
    BOOST_TEST(line_rate(plan_cycle(p), p.line, true).rate > 20);
    ++count;
  }
  BOOST_TEST(count == 3);
}

BOOST_AUTO_TEST_CASE(an_address_is_the_same_whatever_name_it_goes_by) {
  const auto names = [](const std::string& connect) { return claim_names(parse_endpoint(connect)); };
  const std::vector<std::string> here = names("tcp:127.0.0.1:502");
  BOOST_TEST_REQUIRE(here.size() == 1U);
  for (const char* same : {"tcp:127.1.2.3:502", "tcp:0.0.0.0:502", "tcp:::1:502", "tcp:::ffff:127.0.0.1:502"}) {
    BOOST_TEST(names(same) == here, same);
  }
  // A root without /etc/hosts does not know its own name.
  addrinfo* known = nullptr;
  if (getaddrinfo("localhost", nullptr, nullptr, &known) == 0) {
    BOOST_TEST(names("tcp:localhost:502") == here);
    freeaddrinfo(known);
  }
  BOOST_TEST(names("tcp:127.0.0.1:503") != here);
  BOOST_TEST(names("tcp:192.0.2.7:502") != here);
  BOOST_TEST(names("tcp:192.0.2.7:502") == names("tcp:::ffff:192.0.2.7:502"));
  // A port and a link to it.
  const tactor::TemporaryFolder folder;
  std::filesystem::create_symlink("/dev/null", folder.path() / "port");
  BOOST_TEST(names("rtu:/dev/null") == names("rtu:" + (folder.path() / "port").string()));
  BOOST_TEST(names("rtu:/dev/null").size() == 1U);
  BOOST_TEST(names("rtu:/dev/null") != names("rtu:/dev/zero"));
  BOOST_TEST(names("rtu:/dev/none").empty());
}

BOOST_AUTO_TEST_SUITE_END()
