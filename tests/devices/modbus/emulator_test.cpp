// Clients that treat the emulator badly: it goes on serving the others, and ends when it is asked to.
#include <arpa/inet.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <boost/test/unit_test.hpp>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <thread>

#include "devices/modbus/client.hpp"
#include "devices/modbus/emulator/server.hpp"
#include "framework/core/check.hpp"
#include "framework/core/temporary_folder.hpp"

BOOST_AUTO_TEST_SUITE(emulator_test)

using namespace tactor;
using namespace tactor::modbus;

namespace {

Profile orca() {
  Profile profile = read_profile(TACTOR_SOURCE_DIR "/devices/modbus/profiles/iris_orca.yaml");
  profile.line.response_timeout = Duration{1'000'000'000};
  return profile;
}

/// A socket that is connected to an emulator over TCP.
int connected_to(const Emulator& emulator) {
  const int file = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int small = 4096;
  setsockopt(file, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(parse_endpoint(emulator.address()).port));
  BOOST_REQUIRE(connect(file, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  return file;
}

/// Whether another client is answered.
bool serves(const Emulator& emulator) {
  const Profile profile = orca();
  Client client(parse_endpoint(emulator.address()), profile.line, {3, 342, 3}, 20);
  LinkFailure failure;
  std::uint16_t word = 0;
  return client.connect(failure) &&
         client.transfer({.function = 3, .read_address = 408, .read_count = 1}, nullptr, &word, failure);
}

double processor_seconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_client_that_never_reads_its_answers_holds_nobody_up) {
  Emulator emulator(orca(), {});
  emulator.start();
  const int rude = connected_to(emulator);
  // Sends requests until the emulator has ended the connection, or takes no more of them.
  std::vector<std::uint8_t> requests;
  for (int i = 0; i < 100; ++i) requests.insert(requests.end(), {0, 1, 0, 0, 0, 6, 1, 3, 1, 0x56, 0, 3});
  int refused = 0;
  for (int i = 0; i < 20'000 && refused < 200; ++i) {
    const ssize_t n = send(rude, requests.data(), requests.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n < 0 && errno != EAGAIN) break;
    if (n < 0) {
      ++refused;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  BOOST_TEST(serves(emulator));
  const auto before = std::chrono::steady_clock::now();
  emulator.stop();
  BOOST_TEST((std::chrono::steady_clock::now() - before < std::chrono::seconds(2)));
  close(rude);
}

BOOST_AUTO_TEST_CASE(half_a_request_holds_nobody_up) {
  Emulator emulator(orca(), {});
  emulator.start();
  const int slow = connected_to(emulator);
  for (const std::uint8_t byte : {0, 1, 0, 0, 0, 6, 1, 3}) {
    BOOST_REQUIRE(send(slow, &byte, 1, MSG_NOSIGNAL) == 1);
    BOOST_TEST(serves(emulator));
  }
  // The rest of it comes later, and is answered.
  const std::uint8_t rest[] = {1, 0x98, 0, 1};
  BOOST_REQUIRE(send(slow, rest, sizeof rest, MSG_NOSIGNAL) == sizeof rest);
  std::uint8_t answer[11] = {};
  BOOST_TEST(recv(slow, answer, sizeof answer, MSG_WAITALL) == 11);
  BOOST_TEST(answer[10] == 6);  // the version of the firmware
  close(slow);
}

BOOST_AUTO_TEST_CASE(clients_that_say_nothing_give_way_to_those_that_do) {
  Emulator emulator(orca(), {});
  emulator.start();
  const auto talk = [](int client) {
    const std::uint8_t request[] = {0, 1, 0, 0, 0, 6, 1, 3, 1, 0x98, 0, 1};
    std::uint8_t answer[11] = {};
    return send(client, request, sizeof request, MSG_NOSIGNAL) == sizeof request &&
           recv(client, answer, sizeof answer, MSG_WAITALL) == sizeof answer;
  };
  const int talking = connected_to(emulator);
  BOOST_REQUIRE(talk(talking));
  std::vector<int> silent;
  for (int i = 0; i < 200; ++i) {
    silent.push_back(connected_to(emulator));
    if (i % 20 == 19) BOOST_TEST(serves(emulator));
  }
  // The first of them were let go, and the one that talks was not.
  char byte = 0;
  BOOST_TEST(recv(silent.front(), &byte, 1, 0) <= 0);
  BOOST_TEST((recv(silent.back(), &byte, 1, MSG_DONTWAIT) == -1 && (errno == EAGAIN || errno == EWOULDBLOCK)));
  BOOST_TEST(talk(talking));
  for (const int client : silent) close(client);
  close(talking);
}

BOOST_AUTO_TEST_CASE(an_emulator_out_of_descriptors_waits_and_then_goes_on) {
  Emulator emulator(orca(), {});
  emulator.start();
  std::vector<int> sockets;
  rlimit before{};
  BOOST_REQUIRE(getrlimit(RLIMIT_NOFILE, &before) == 0);
  // Made before there are none left.
  for (int i = 0; i < 4; ++i) sockets.push_back(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const rlimit none{3, before.rlim_max};
  BOOST_REQUIRE(setrlimit(RLIMIT_NOFILE, &none) == 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(parse_endpoint(emulator.address()).port));
  for (const int file : sockets) {
    BOOST_REQUIRE(connect(file, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  }
  const double spent = processor_seconds();
  std::this_thread::sleep_for(std::chrono::seconds(1));
  const double used = processor_seconds() - spent;
  BOOST_REQUIRE(setrlimit(RLIMIT_NOFILE, &before) == 0);
  // It spun without a pause before; the device itself moves 2,000 times in that second.
  BOOST_TEST(used < 0.5);
  BOOST_TEST(serves(emulator));
  for (const int file : sockets) close(file);
}

BOOST_AUTO_TEST_CASE(a_link_never_takes_the_place_of_a_file) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "thesis.tex";
  std::ofstream(file) << "years of work\n";
  BOOST_CHECK_THROW(Emulator(orca(), {.serial = true, .link = file.string()}), InputError);
  BOOST_TEST(std::filesystem::file_size(file) == 14U);
  // A link of an earlier emulator is replaced, and goes with this one.
  const std::filesystem::path link = folder.path() / "motor";
  std::filesystem::create_symlink("/dev/pts/gone", link);
  {
    Emulator emulator(orca(), {.serial = true, .link = link.string()});
    BOOST_TEST(std::filesystem::exists(link));
  }
  BOOST_TEST(!std::filesystem::exists(std::filesystem::symlink_status(link)));
  // What somebody has put there since stays.
  {
    Emulator emulator(orca(), {.serial = true, .link = link.string()});
    std::filesystem::remove(link);
    std::ofstream(link) << "mine\n";
  }
  BOOST_TEST(std::filesystem::is_regular_file(link));
}

BOOST_AUTO_TEST_SUITE_END()
