// The bytes of usbip, from the tables of the kernel's Documentation/usb/usbip_protocol, and a server that is told
// nonsense.
#include <boost/test/unit_test.hpp>
#include <cerrno>
#include <random>

#include "devices/usb/emulator/usbip.hpp"

BOOST_AUTO_TEST_SUITE(usbip_test)

using namespace tactor;

namespace {

using Bytes = std::vector<std::uint8_t>;

/// A number as the protocol has it, big end first.
Bytes big(std::uint32_t value) {
  return {static_cast<std::uint8_t>(value >> 24U), static_cast<std::uint8_t>(value >> 16U),
          static_cast<std::uint8_t>(value >> 8U), static_cast<std::uint8_t>(value)};
}

std::uint32_t number(const Bytes& bytes, std::size_t at) {
  return static_cast<std::uint32_t>(bytes.at(at) * 0x1000000U + bytes.at(at + 1) * 0x10000U +
                                    bytes.at(at + 2) * 0x100U + bytes.at(at + 3));
}

/// A header of these numbers in their order, and eight bytes of setup.
Bytes header(const std::vector<std::uint32_t>& numbers, const Bytes& setup = Bytes(8)) {
  Bytes bytes;
  for (const std::uint32_t value : numbers) {
    const Bytes four = big(value);
    bytes.insert(bytes.end(), four.begin(), four.end());
  }
  bytes.insert(bytes.end(), setup.begin(), setup.end());
  return bytes;
}

Bytes submit(std::uint32_t seqnum, std::uint32_t in, std::uint32_t endpoint, std::uint32_t length,
             const Bytes& setup = Bytes(8)) {
  return header({1, seqnum, 0x10002, in, endpoint, 0, length, 0, 0xffffffff, 1}, setup);
}

Bytes unlink(std::uint32_t seqnum, std::uint32_t unlinked) {
  return header({2, seqnum, 0x10002, 0, 0, unlinked, 0, 0, 0, 0});
}

std::string read(const Bytes& bytes, usbip::Request& request) {
  return usbip::read_request(std::span<const std::uint8_t, 48>(bytes.data(), 48), request);
}

/// Counts what it is told; its IN endpoint 1 (interrupt) and 2 (bulk) send as many reports as there are in `ready`.
struct Function final : UsbFunction {
  std::vector<std::uint8_t> descriptors() override {
    const EndpointDescription endpoints[] = {{0x81, 3}, {0x01, 3}, {0x82, 2}};
    return make_descriptors(0x1234, 6, 3, endpoints);
  }
  std::optional<std::size_t> control(const UsbSetup& setup, std::span<std::uint8_t> data) override {
    const char* texts[] = {"a", "bc"};
    const Bytes all = descriptors();
    if (setup.request == 0x55) {
      controlled.assign(data.begin(), data.end());
      return data.size();
    }
    return answer_standard_request(setup, data, all, texts);
  }
  void out(std::uint8_t endpoint, std::span<const std::uint8_t> data) override {
    BOOST_TEST(endpoint == 1);
    sent.emplace_back(data.begin(), data.end());
  }
  std::optional<Bytes> in(std::uint8_t) override {
    if (ready == 0) return std::nullopt;
    --ready;
    return report;
  }
  void tick(double dt) override { time += dt; }
  void opened() override { ++times_opened; }
  void closed() override { ++times_closed; }

  int ready = 0, times_opened = 0, times_closed = 0;
  double time = 0;
  Bytes report{1, 2, 3, 4}, controlled;
  std::vector<Bytes> sent;
};

struct Served {
  Function function;
  UsbipServer server{function};
};

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_kernel_s_table_of_a_submit_is_what_is_read) {
  // GET_DESCRIPTOR of the device, as the kernel asks first: 64 bytes of endpoint 0.
  const Bytes bytes{0, 0, 0, 1,  0, 0, 0x0d, 5, 0, 1, 0, 2, 0, 0, 0, 1, 0,    0, 0, 0, 0, 0, 2,  0,
                    0, 0, 0, 64, 0, 0, 0,    0, 0, 0, 0, 0, 0, 0, 0, 0, 0x80, 6, 0, 1, 0, 0, 64, 0};
  usbip::Request request;
  BOOST_TEST(read(bytes, request) == "");
  BOOST_TEST(!request.unlink);
  BOOST_TEST(request.seqnum == 0xd05U);
  BOOST_TEST(request.endpoint == 0x80);
  BOOST_TEST(request.in());
  BOOST_TEST(request.length == 64U);
  BOOST_TEST(request.data_size() == 0U);
  BOOST_TEST(request.setup.type == 0x80);
  BOOST_TEST(request.setup.request == 6);
  BOOST_TEST(request.setup.value == 0x100);
  BOOST_TEST(request.setup.index == 0);
  BOOST_TEST(request.setup.length == 64);
}

BOOST_AUTO_TEST_CASE(data_follows_what_goes_out_alone) {
  usbip::Request request;
  BOOST_TEST(read(submit(7, 0, 1, 14), request) == "");
  BOOST_TEST(request.endpoint == 1);
  BOOST_TEST(request.data_size() == 14U);
  BOOST_TEST(read(submit(7, 1, 15, 14), request) == "");
  BOOST_TEST(request.endpoint == 0x8f);
  BOOST_TEST(request.data_size() == 0U);
  BOOST_TEST(read(unlink(9, 0x01020304), request) == "");
  BOOST_TEST(request.unlink);
  BOOST_TEST(request.seqnum == 9U);
  BOOST_TEST(request.unlinked == 0x01020304U);
  BOOST_TEST(request.data_size() == 0U);
}

BOOST_AUTO_TEST_CASE(answers_are_laid_out_as_in_the_kernel_s_tables) {
  const Bytes data{0xaa, 0xbb};
  const Bytes answer = usbip::submit_answer(0xd05, -EOVERFLOW, 2, data);
  BOOST_REQUIRE(answer.size() == 50U);
  const Bytes expected = header({3, 0xd05, 0, 0, 0, static_cast<std::uint32_t>(-75), 2, 0, 0, 0}) + data;
  BOOST_TEST(answer == expected, boost::test_tools::per_element());
  const Bytes undone = usbip::unlink_answer(0xd06, -ECONNRESET);
  const Bytes as_told = header({4, 0xd06, 0, 0, 0, static_cast<std::uint32_t>(-104), 0, 0, 0, 0});
  BOOST_TEST(undone == as_told, boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(headers_that_cannot_be_are_told_apart) {
  usbip::Request request;
  for (const std::uint32_t command : {0U, 3U, 4U, 0x01000000U, 0xffffffffU}) {
    BOOST_TEST(read(header({command, 1, 2, 0, 0, 0, 0, 0, 0, 0}), request).find("a command") != std::string::npos);
  }
  BOOST_TEST(read(submit(1, 2, 1, 4), request).find("a direction") != std::string::npos);
  BOOST_TEST(read(submit(1, 1, 16, 4), request).find("an endpoint") != std::string::npos);
  BOOST_TEST(read(submit(1, 1, 1, 0x100001), request).find("0x100001") != std::string::npos);
  BOOST_TEST(read(submit(1, 0, 1, 0xffffffff), request).find("bytes") != std::string::npos);
  BOOST_TEST(read(header({1, 1, 2, 1, 1, 0, 4, 0, 8, 1}), request).find("isochronous") != std::string::npos);
  BOOST_TEST(read(header({1, 1, 2, 1, 1, 0, 4, 0, 0, 1}), request) == "");
}

BOOST_AUTO_TEST_CASE(a_free_port_is_found_in_the_kernel_s_status) {
  const std::string heading = "hub port sta spd dev      sockfd local_busid\n";
  BOOST_TEST(usbip::free_port(heading + "hs  0000 006 002 00010002 000003 1-2\nhs  0001 004 000 00000000 000000 0-0\n"
                                        "ss  0008 004 000 00000000 000000 0-0\n") == 1);
  BOOST_TEST(
      usbip::free_port(heading + "hs  0000 005 002 00010002 000003 1-2\nss  0008 004 000 00000000 000000 0-0\n") == -1);
  BOOST_TEST(usbip::free_port("") == -1);
}

BOOST_FIXTURE_TEST_CASE(a_control_transfer_is_answered_at_once_whatever_pieces_it_comes_in, Served) {
  const Bytes bytes = submit(5, 1, 0, 8, {0x80, 6, 0, 1, 0, 0, 64, 0});
  for (const std::uint8_t byte : bytes) BOOST_TEST(server.receive({&byte, 1}) == "");
  const Bytes answer = server.take();
  // The room is the smaller of the two lengths.
  BOOST_REQUIRE(answer.size() == 56U);
  BOOST_TEST(number(answer, 0x00) == 3U);
  BOOST_TEST(number(answer, 0x04) == 5U);
  BOOST_TEST(number(answer, 0x14) == 0U);
  BOOST_TEST(number(answer, 0x18) == 8U);
  BOOST_TEST(answer[48] == 18);
  BOOST_TEST(answer[49] == 1);
  BOOST_TEST(function.times_opened == 0);
  // Data that goes out with it.
  BOOST_TEST(server.receive(submit(6, 0, 0, 3, {0x40, 0x55, 0, 0, 0, 0, 3, 0}) + Bytes{7, 8, 9}) == "");
  BOOST_TEST(function.controlled == (Bytes{7, 8, 9}), boost::test_tools::per_element());
  const Bytes taken = server.take();
  BOOST_REQUIRE(taken.size() == 48U);
  BOOST_TEST(number(taken, 0x18) == 3U);
  // What it does not know it refuses.
  BOOST_TEST(server.receive(submit(7, 1, 0, 8, {0xc0, 0x77, 0, 0, 0, 0, 8, 0})) == "");
  BOOST_TEST(static_cast<std::int32_t>(number(server.take(), 0x14)) == -EPIPE);
}

BOOST_FIXTURE_TEST_CASE(an_interrupt_endpoint_has_one_transfer_a_frame_and_a_bulk_one_all_that_go, Served) {
  BOOST_TEST(server.receive(submit(1, 1, 1, 4) + submit(2, 1, 1, 4) + submit(3, 1, 2, 4) + submit(4, 1, 2, 4)) == "");
  BOOST_TEST(function.times_opened == 1);
  BOOST_TEST(server.take().empty());
  function.ready = 100;
  server.frame();
  const Bytes first = server.take();
  BOOST_REQUIRE(first.size() == 3U * 52);
  BOOST_TEST(number(first, 0x04) == 1U);
  BOOST_TEST(number(first, 52 + 0x04) == 3U);
  BOOST_TEST(number(first, 104 + 0x04) == 4U);
  server.frame();
  const Bytes second = server.take();
  BOOST_REQUIRE(second.size() == 52U);
  BOOST_TEST(number(second, 0x04) == 2U);
  BOOST_TEST(Bytes(second.begin() + 48, second.end()) == function.report, boost::test_tools::per_element());
}

BOOST_FIXTURE_TEST_CASE(what_is_sent_is_handed_over_and_answered_without_data, Served) {
  BOOST_TEST(server.receive(submit(1, 0, 1, 2) + Bytes{5, 6} + submit(2, 0, 1, 1) + Bytes{7}) == "");
  server.frame();
  const Bytes answer = server.take();
  BOOST_REQUIRE(answer.size() == 48U);
  BOOST_TEST(number(answer, 0x18) == 2U);
  server.frame();
  BOOST_REQUIRE(function.sent.size() == 2U);
  BOOST_TEST(function.sent[0] == (Bytes{5, 6}), boost::test_tools::per_element());
  BOOST_TEST(function.sent[1] == (Bytes{7}), boost::test_tools::per_element());
}

BOOST_FIXTURE_TEST_CASE(a_report_that_is_too_long_is_cut_to_the_room_that_the_kernel_has, Served) {
  function.ready = 1;
  BOOST_TEST(server.receive(submit(1, 1, 1, 3)) == "");
  server.frame();
  const Bytes answer = server.take();
  BOOST_REQUIRE(answer.size() == 51U);
  BOOST_TEST(static_cast<std::int32_t>(number(answer, 0x14)) == -EOVERFLOW);
  BOOST_TEST(number(answer, 0x18) == 3U);
}

BOOST_FIXTURE_TEST_CASE(a_transfer_is_called_back_once, Served) {
  BOOST_TEST(server.receive(submit(1, 1, 1, 4) + unlink(2, 1) + unlink(3, 1)) == "");
  const Bytes answer = server.take();
  BOOST_REQUIRE(answer.size() == 96U);
  BOOST_TEST(number(answer, 0) == 4U);
  BOOST_TEST(number(answer, 4) == 2U);
  BOOST_TEST(static_cast<std::int32_t>(number(answer, 0x14)) == -ECONNRESET);
  BOOST_TEST(number(answer, 48 + 4) == 3U);
  BOOST_TEST(number(answer, 48 + 0x14) == 0U);
  function.ready = 1;
  server.frame();
  BOOST_TEST(server.take().empty());
}

BOOST_FIXTURE_TEST_CASE(an_endpoint_that_the_device_lacks_is_refused, Served) {
  BOOST_TEST(server.receive(submit(1, 1, 7, 4) + submit(2, 0, 2, 1) + Bytes{1}) == "");
  const Bytes answer = server.take();
  BOOST_REQUIRE(answer.size() == 96U);
  BOOST_TEST(static_cast<std::int32_t>(number(answer, 0x14)) == -EPIPE);
  BOOST_TEST(static_cast<std::int32_t>(number(answer, 48 + 0x14)) == -EPIPE);
  BOOST_TEST(function.times_opened == 0);
}

BOOST_FIXTURE_TEST_CASE(the_device_is_open_while_transfers_are_on_their_way, Served) {
  server.frame();
  BOOST_TEST(function.time == 0);
  BOOST_TEST(server.receive(submit(1, 1, 1, 4)) == "");
  for (int i = 0; i < 2000; ++i) server.frame();
  BOOST_TEST(function.time == 2.0, boost::test_tools::tolerance(1e-9));
  BOOST_TEST(server.is_open());
  BOOST_TEST(server.receive(unlink(2, 1)) == "");
  for (int i = 0; i < 490; ++i) server.frame();
  BOOST_TEST(server.is_open());
  for (int i = 0; i < 20; ++i) server.frame();
  BOOST_TEST(!server.is_open());
  BOOST_TEST(function.times_closed == 1);
  BOOST_TEST(server.receive(submit(3, 1, 1, 4)) == "");
  BOOST_TEST(function.times_opened == 2);
}

BOOST_FIXTURE_TEST_CASE(after_nonsense_nothing_more_is_taken, Served) {
  BOOST_TEST(server.receive(header({9, 1, 2, 0, 0, 0, 0, 0, 0, 0}) + submit(1, 1, 1, 4)) != "");
  BOOST_TEST(server.receive(submit(2, 1, 1, 4)) != "");
  BOOST_TEST(function.times_opened == 0);
}

BOOST_FIXTURE_TEST_CASE(transfers_without_end_are_not_kept, Served) {
  std::string problem;
  int taken = 0;
  for (; taken < 5000 && problem.empty(); ++taken) problem = server.receive(submit(1, 1, 1, 4));
  BOOST_TEST(problem.find("transfers") != std::string::npos);
  BOOST_TEST(taken == 1025);
}

BOOST_AUTO_TEST_CASE(random_bytes_and_headers_with_a_wrong_number_end_or_are_answered) {
  std::minstd_rand random(3);
  int refused = 0, answered = 0;
  for (int round = 0; round < 2000; ++round) {
    Served served;
    Bytes bytes(random() % 200);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    // Every other one is a submit with one byte changed.
    if (round % 2 == 0) {
      bytes = submit(1, random() % 2, random() % 3, random() % 64) + bytes;
      bytes[random() % 48] = static_cast<std::uint8_t>(random());
    }
    refused += served.server.receive(bytes).empty() ? 0 : 1;
    served.function.ready = 5;
    served.server.frame();
    const Bytes answers = served.server.take();
    if (answers.empty()) continue;
    ++answered;
    const std::uint32_t command = number(answers, 0);
    BOOST_TEST((command == 3 || command == 4));
  }
  BOOST_TEST(refused > 500);
  BOOST_TEST(answered > 100);
}

BOOST_AUTO_TEST_SUITE_END()
