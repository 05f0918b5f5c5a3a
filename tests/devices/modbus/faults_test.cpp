// A line to an emulated actuator on which everything goes wrong, over TCP and over a serial line.
#include <sys/socket.h>
#include <unistd.h>

#include <boost/test/data/test_case.hpp>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <thread>

#include "devices/modbus/emulator/server.hpp"
#include "devices/modbus/modbus_link.hpp"

BOOST_AUTO_TEST_SUITE(faults_test)

using namespace tactor;
using namespace tactor::modbus;

// Named, because the cases over data are templates and capture it.
namespace line_tests {

Profile orca() {
  Profile profile = read_profile(TACTOR_SOURCE_DIR "/devices/modbus/profiles/iris_orca.yaml");
  // A machine with much else to do answers late; what is asked here is what comes after a time-out, not when.
  profile.line.response_timeout = Duration{300'000'000};
  // So may its commands be: the motor must not let go because of that.
  profile.watchdog->time = Duration{2'000'000'000};
  profile.emulated.swing = 0.002;
  return profile;
}

/// An emulator and the line to it.
struct Rig {
  Emulator emulator;
  ModbusLink link;
  LinkFailure failure;
  LinkSample sample;

  Rig(bool serial, const Profile& emulated, const Profile& expected, std::vector<Fault> faults = {})
      : emulator(emulated, {.serial = serial, .line_delay = false, .faults = std::move(faults)}),
        link(expected, parse_endpoint(emulator.address())) {
    emulator.start();
  }
  explicit Rig(bool serial) : Rig(serial, orca(), orca()) {}

  bool open() {
    failure = {};
    return link.open(failure);
  }
  bool cycle(double effort = 0) {
    failure = {};
    sample = {};
    return link.exchange({{effort}}, sample, failure);
  }
  /// Cycles until one fails, as it must sooner or later.
  bool fails(double effort = 0) {
    for (int i = 0; i < 5000; ++i) {
      if (!cycle(effort)) return true;
    }
    return false;
  }
  /// Cycles, opening where needed, until one is good.
  bool recovers() {
    for (int i = 0; i < 2000; ++i) {
      // An exception comes at once, and goes on for a while.
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      if (failure.reopen) {
        link.close();
        if (!open()) continue;
      }
      if (cycle()) return true;
    }
    return false;
  }
  template <class Condition>
  bool eventually(const Condition& condition) {
    for (int i = 0; i < 20'000; ++i) {
      if (condition()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  }
};

Fault fault(const std::string& text) {
  return parse_fault(text);
}

const std::vector<bool> both{false, true};

/// What a register holds, by a client of its own.
int word_of(const Emulator& emulator, const Profile& profile, int address) {
  Client client(parse_endpoint(emulator.address()), profile.line, plan_cycle(profile).fence, 20);
  LinkFailure failure;
  std::uint16_t word = 0;
  const Transaction read{.function = 3, .read_address = address, .read_count = 1};
  for (int i = 0; i < 20; ++i) {
    if (client.connect(failure) && client.transfer(read, nullptr, &word, failure)) return word;
  }
  BOOST_FAIL(failure.text);
  return word;
}

}  // namespace line_tests

using namespace line_tests;

BOOST_DATA_TEST_CASE(a_command_reaches_the_device_and_its_position_comes_back, both, serial) {
  Rig rig(serial);
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  BOOST_TEST(rig.cycle(5), rig.failure.text);
  BOOST_TEST(std::abs(rig.sample.q[0] - 0.05) < 0.02);
  BOOST_TEST(rig.eventually([&] { return rig.cycle(5) && rig.emulator.state().force == 5.0; }));
  // 5 N against a spring of 250 N/m move it by 20 mm from where the hand holds it.
  BOOST_TEST(rig.eventually([&] { return rig.cycle(5) && rig.sample.q[0] > 0.06; }));
  rig.link.close();
  BOOST_TEST(rig.eventually([&] { return rig.emulator.state().commanded == 0.0; }));
  BOOST_TEST(rig.emulator.state().force == 0.0);
}

BOOST_DATA_TEST_CASE(a_silent_peer_times_out_and_is_taken_up_again, both, serial) {
  Rig rig(serial);
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  rig.emulator.inject(fault("silent:1"));
  BOOST_TEST(rig.fails());
  BOOST_CHECK(rig.failure.error == LinkError::timeout);
  BOOST_TEST(rig.failure.text.find("no whole answer within 300 ms") != std::string::npos, rig.failure.text);
  BOOST_TEST(rig.recovers());
  BOOST_TEST(rig.link.client().fences() > 0U);
}

BOOST_DATA_TEST_CASE(a_slow_peer_never_counts_as_answering, both, serial) {
  Rig rig(serial);
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  rig.emulator.inject(fault("slow:0.7"));
  BOOST_TEST(rig.fails());
  for (int i = 0; i < 3; ++i) BOOST_TEST(!rig.cycle());
}

BOOST_DATA_TEST_CASE(an_answer_that_drips_in_does_not_prolong_the_time_out, both, serial) {
  Rig rig(serial);
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  rig.emulator.inject(fault("dribble:0.1"));
  BOOST_TEST(rig.fails());
  // Each byte comes well within the time-out, all of them do not.
  BOOST_CHECK(rig.failure.error == LinkError::timeout);
}

BOOST_DATA_TEST_CASE(a_late_answer_is_never_taken_for_the_next_one, both, serial) {
  Rig rig(serial);
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  BOOST_TEST(rig.cycle());
  BOOST_TEST(rig.sample.q[0] < 0.08);
  // Longer than the time-out and than the wait after it, so that the answer comes when the line seems clear again.
  rig.emulator.inject(fault("late:1.3"));
  BOOST_TEST(rig.fails());
  BOOST_CHECK(rig.failure.error == LinkError::timeout);
  // The answer that is under way has the old position. From here on the device shows another.
  rig.emulator.inject(fault("jump:0.5"));
  BOOST_TEST(rig.recovers());
  BOOST_TEST(rig.sample.q[0] > 0.5);
  for (int i = 0; i < 20; ++i) {
    if (rig.cycle()) BOOST_TEST(rig.sample.q[0] > 0.5);
  }
}

BOOST_DATA_TEST_CASE(a_wrong_check_sum_is_no_answer, both, serial) {
  Rig rig(serial);
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  rig.emulator.inject(fault("crc:1"));
  BOOST_TEST(rig.fails());
  BOOST_CHECK(rig.failure.error == (serial ? LinkError::crc : LinkError::protocol));
  BOOST_TEST(rig.recovers());
}

BOOST_DATA_TEST_CASE(the_answer_of_another_slave_is_no_answer, both, serial) {
  Rig rig(serial);
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  rig.emulator.inject(fault("slave:1"));
  BOOST_TEST(rig.fails());
  BOOST_CHECK(rig.failure.error == LinkError::protocol);
  BOOST_TEST(rig.failure.text.find("expected an answer with unit 1, found 2") != std::string::npos, rig.failure.text);
  BOOST_TEST(rig.recovers());
}

BOOST_DATA_TEST_CASE(an_answer_that_states_a_wrong_length_is_no_answer, both, serial) {
  Rig rig(serial);
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  rig.emulator.inject(fault("length:1"));
  BOOST_TEST(rig.fails());
  BOOST_CHECK(rig.failure.error == LinkError::protocol);
  BOOST_TEST(rig.failure.text.find(serial ? "count of bytes" : "length in its header") != std::string::npos,
             rig.failure.text);
  BOOST_TEST(rig.recovers());
}

BOOST_DATA_TEST_CASE(an_exception_is_told_with_its_number, both, serial) {
  Rig rig(serial);
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  rig.emulator.inject(fault("exception:1"));
  BOOST_TEST(rig.fails());
  BOOST_CHECK(rig.failure.error == LinkError::exception);
  BOOST_TEST(rig.failure.text.find("exception 4") != std::string::npos, rig.failure.text);
  BOOST_TEST(!rig.failure.reopen);
  BOOST_TEST(rig.recovers());
}

BOOST_AUTO_TEST_CASE(an_exception_is_no_answer_to_the_fence_of_a_serial_line) {
  Rig rig(true);
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  rig.emulator.inject(fault("exception"));
  BOOST_TEST(rig.fails());
  BOOST_CHECK(rig.failure.error == LinkError::exception);
  rig.link.close();
  // The exceptions go on. Each could be that of an older request, so that none says that the line is clear.
  for (int i = 0; i < 3; ++i) {
    BOOST_TEST(!rig.open());
    BOOST_TEST(rig.failure.text.find("the device refuses the fence") != std::string::npos, rig.failure.text);
    BOOST_TEST(rig.failure.text.find("exception 4") != std::string::npos, rig.failure.text);
  }
}

BOOST_AUTO_TEST_CASE(a_connection_that_is_reset_is_opened_anew) {
  Rig rig(false);
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  rig.emulator.inject(fault("reset"));
  BOOST_TEST(rig.fails());
  BOOST_CHECK(rig.failure.error == LinkError::reset);
  BOOST_TEST(rig.failure.reopen);
  BOOST_TEST(rig.recovers());
  BOOST_TEST(rig.emulator.connections() >= 2U);
}

BOOST_DATA_TEST_CASE(another_device_behind_the_address_is_not_written_to, both, serial) {
  Profile other = orca();
  for (auto& [index, value] : other.emulated.initial) value = 0;
  Rig rig(serial, other, orca());
  BOOST_TEST(!rig.open());
  BOOST_CHECK(rig.failure.error == LinkError::identity);
  BOOST_TEST(rig.failure.text.find("expected major_version at 408 from 1 to 99, found 0") != std::string::npos,
             rig.failure.text);
  BOOST_TEST(rig.emulator.answers() > 0U);
  BOOST_TEST(rig.emulator.writes() == 0U);
}

BOOST_AUTO_TEST_CASE(an_address_that_no_register_has_is_an_exception) {
  Profile profile = orca();
  const auto answers = [&](const Transaction& t) {
    Emulator emulator(profile, {});
    emulator.start();
    Client client(parse_endpoint(emulator.address()), profile.line, plan_cycle(profile).fence, 200);
    LinkFailure failure;
    std::uint16_t words[125] = {};
    BOOST_TEST_REQUIRE(client.connect(failure), failure.text);
    if (client.transfer(t, words, words, failure)) return true;
    BOOST_TEST(failure.text.find("exception 2") != std::string::npos, failure.text);
    return false;
  };
  // 344, behind the position, is a word of the fence; 345 is nobody's.
  BOOST_TEST(answers({.function = 3, .read_address = 342, .read_count = 3}));
  BOOST_TEST(!answers({.function = 3, .read_address = 342, .read_count = 4}));
  BOOST_TEST(!answers({.function = 4, .read_address = 409, .read_count = 1}));
  BOOST_TEST(answers({.function = 16, .write_address = 28, .write_count = 2}));
  BOOST_TEST(!answers({.function = 16, .write_address = 28, .write_count = 3}));
  BOOST_TEST(!answers({.function = 6, .write_address = 344, .write_count = 1}));
  BOOST_TEST(!answers({.function = 23, .read_address = 345, .read_count = 1, .write_address = 28, .write_count = 2}));
  // From 344 to the force at 348 there are four words, from the mode at 317 to the position 24.
  profile.read_gap = 4;
  BOOST_TEST(answers({.function = 3, .read_address = 342, .read_count = 8}));
  BOOST_TEST(!answers({.function = 3, .read_address = 341, .read_count = 2}));
  BOOST_TEST(!answers({.function = 16, .write_address = 344, .write_count = 1}));
}

BOOST_AUTO_TEST_CASE(a_device_that_lacks_the_register_of_its_identity_is_another) {
  Profile other = orca();
  for (RegisterInfo& info : other.registers) {
    if (info.address > 300) info.address -= 300;
  }
  other.fence = Fence{3, 42, 3};
  Rig rig(false, other, orca());
  BOOST_TEST(!rig.open());
  BOOST_CHECK(rig.failure.error == LinkError::identity);
  BOOST_TEST(rig.emulator.writes() == 0U);
}

BOOST_AUTO_TEST_CASE(nobody_at_the_address_is_told) {
  std::string address;
  {
    Emulator gone(orca(), {});
    address = gone.address();
  }
  ModbusLink link(orca(), parse_endpoint(address));
  LinkFailure failure;
  BOOST_TEST(!link.open(failure));
  BOOST_CHECK(failure.error == LinkError::disconnected);
  ModbusLink serial(orca(), parse_endpoint("rtu:/dev/does-not-exist"));
  BOOST_TEST(!serial.open(failure));
  BOOST_CHECK(failure.error == LinkError::disconnected);
  BOOST_TEST(failure.text.find("No such file") != std::string::npos, failure.text);
}

BOOST_DATA_TEST_CASE(a_fault_bit_of_the_device_is_told_in_words, both, serial) {
  Rig rig(serial);
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  BOOST_TEST(rig.cycle());
  BOOST_TEST(rig.sample.faults == 0U);
  rig.emulator.inject(fault("status:6"));
  BOOST_TEST(rig.eventually([&] { return rig.cycle() && rig.sample.faults == 1U << 6; }));
  BOOST_TEST(rig.failure.text == "the device reports: bit 6 of errors");
}

BOOST_AUTO_TEST_CASE(another_master_that_puts_the_motor_to_sleep_is_a_fault) {
  Rig rig(false);
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  for (int i = 0; i < 100; ++i) BOOST_REQUIRE(rig.cycle(5) && rig.sample.faults == 0U);
  const Profile profile = orca();
  // From another machine, which no lock of this one keeps away.
  Client other(parse_endpoint(rig.emulator.address()), profile.line, plan_cycle(profile).fence, 20);
  const std::uint16_t asleep = 1;
  LinkFailure failure;
  BOOST_TEST_REQUIRE(other.connect(failure), failure.text);
  BOOST_TEST(other.transfer({.function = 6, .write_address = 3, .write_count = 1}, &asleep, nullptr, failure),
             failure.text);
  BOOST_TEST(rig.eventually([&] { return rig.cycle(5) && rig.sample.faults != 0; }));
  BOOST_TEST(rig.failure.text.find("mode_now has become 1, but the start-up left it at 2: another master") !=
                 std::string::npos,
             rig.failure.text);
}

BOOST_DATA_TEST_CASE(bytes_that_nobody_asked_for_are_a_fault_of_the_line, both, serial) {
  int pair[2];
  BOOST_REQUIRE(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) == 0);
  const Profile profile = orca();
  Client client(parse_endpoint(serial ? "rtu:/dev/null" : "tcp:127.0.0.1:1"), profile.line, {3, 342, 3}, 20);
  client.attach(pair[0]);
  // The end of an answer to somebody else.
  BOOST_REQUIRE(send(pair[1], "\x01\x02", 2, MSG_NOSIGNAL) == 2);
  LinkFailure failure;
  std::uint16_t word = 0;
  BOOST_TEST(!client.transfer({.function = 3, .read_address = 10, .read_count = 1}, nullptr, &word, failure));
  BOOST_CHECK(failure.error == LinkError::protocol);
  BOOST_TEST(failure.text.find("2 bytes came without a request: another master") == 0U, failure.text);
  close(pair[1]);
}

BOOST_DATA_TEST_CASE(a_line_that_falls_dead_leaves_no_force_beyond_the_watchdog, both, serial) {
  Rig rig(serial);
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  BOOST_TEST(rig.eventually([&] { return rig.cycle(5) && rig.emulator.state().force == 5.0; }));
  // Nobody commands any more, and nobody shuts it down.
  BOOST_TEST(rig.eventually([&] { return rig.emulator.state().expired; }));
  BOOST_TEST(rig.emulator.state().force == 0.0);
  BOOST_TEST(rig.emulator.state().commanded == 5.0);
  // It stays so until it is started anew, and says why.
  BOOST_TEST(rig.eventually([&] { return rig.cycle(5) && rig.sample.faults != 0; }));
  BOOST_TEST(rig.failure.text.find("no command came within its time-out") != std::string::npos, rig.failure.text);
  BOOST_TEST(rig.emulator.state().force == 0.0);
  rig.link.close();
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  BOOST_TEST(rig.eventually([&] { return rig.cycle(3) && rig.emulator.state().force == 3.0; }));
}

BOOST_AUTO_TEST_CASE(a_garbled_answer_to_the_last_zero_does_not_keep_the_device_from_being_shut_down) {
  Rig rig(true);
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  BOOST_TEST(rig.cycle(5), rig.failure.text);
  rig.emulator.inject(fault("reset"));
  rig.link.close();
  BOOST_TEST(rig.emulator.fault_answers() == 1U);
  BOOST_TEST(rig.emulator.state().commanded == 0.0);
  BOOST_TEST(word_of(rig.emulator, orca(), 317) == 1);  // asleep
}

BOOST_DATA_TEST_CASE(a_fault_that_was_cleared_by_the_start_up_is_not_believed_after_it, both, serial) {
  Rig rig(serial);
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  rig.emulator.inject(fault("status:6"));
  BOOST_TEST(rig.eventually([&] { return rig.cycle() && rig.sample.faults != 0; }));
  rig.link.close();
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  BOOST_TEST(rig.cycle(), rig.failure.text);
  BOOST_TEST(rig.sample.faults == 0U);
}

BOOST_AUTO_TEST_CASE(a_gripper_without_a_force_is_told_to_stand_still) {
  Profile profile = read_profile(TACTOR_SOURCE_DIR "/devices/modbus/profiles/robotiq_2f.yaml");
  profile.line.response_timeout = Duration{300'000'000};
  Rig rig(false, profile, profile);
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  BOOST_TEST(word_of(rig.emulator, profile, 1000) == 1 << 8);
  BOOST_TEST(rig.cycle(30), rig.failure.text);
  BOOST_TEST(word_of(rig.emulator, profile, 1000) == 9 << 8);
  BOOST_TEST(rig.cycle(0), rig.failure.text);
  BOOST_TEST(word_of(rig.emulator, profile, 1000) == 1 << 8);
}

BOOST_AUTO_TEST_CASE(a_gripper_that_is_not_asked_for_a_second_says_so_and_keeps_its_force) {
  Profile profile = read_profile(TACTOR_SOURCE_DIR "/devices/modbus/profiles/robotiq_2f.yaml");
  profile.line.response_timeout = Duration{300'000'000};
  Rig rig(false, profile, profile);
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  BOOST_TEST(rig.eventually([&] { return rig.cycle(30) && rig.emulator.state().force > 29; }));
  BOOST_TEST(rig.sample.faults == 0U);
  // By the device's own clock, from a time after the last request.
  const Time last = rig.emulator.state().time;
  BOOST_TEST(rig.eventually([&] { return rig.emulator.state().time - last > Duration{1'001'000'000}; }));
  BOOST_TEST(rig.emulator.state().force > 29);
  BOOST_TEST(rig.cycle(30), rig.failure.text);
  BOOST_TEST(rig.sample.faults == 1U << 11);
  BOOST_TEST(rig.failure.text.find("no communication for 1 s") != std::string::npos, rig.failure.text);
  rig.link.close();
  BOOST_TEST_REQUIRE(rig.open(), rig.failure.text);
  BOOST_TEST(rig.cycle(30), rig.failure.text);
  BOOST_TEST(rig.sample.faults == 0U);
}

BOOST_AUTO_TEST_CASE(the_other_profiles_run_against_their_emulators) {
  for (const std::string name : {"robotiq_2f", "oriental_az"}) {
    for (const bool serial : both) {
      Profile profile = read_profile(std::string(TACTOR_SOURCE_DIR "/devices/modbus/profiles/") + name + ".yaml");
      profile.line.response_timeout = Duration{300'000'000};
      Rig rig(serial, profile, profile);
      BOOST_TEST_REQUIRE(rig.open(), name + ": " + rig.failure.text);
      for (const double effort : {12.0, -12.0}) {
        const double scale = profile.registers[profile.axes[0].effort].scale;
        BOOST_TEST(rig.eventually([&] {
          return rig.cycle(effort) && std::abs(rig.emulator.state().force - effort) <= 0.51 * scale;
        }),
                   name);
      }
      BOOST_TEST(rig.sample.q[0] > 0);
      rig.link.close();
    }
  }
}

BOOST_AUTO_TEST_SUITE_END()
