#include "devices/usb/emulator/usbip.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <sstream>

namespace tactor {

namespace usbip {

namespace {

constexpr std::uint32_t no_packets = 0xffff'ffff;  // of a transfer that is not isochronous; the kernel sends 0 too
constexpr unsigned port_is_free = 4;               // VDEV_ST_NULL of the kernel

std::uint32_t word(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint32_t>(bytes[at]) << 24U | static_cast<std::uint32_t>(bytes[at + 1]) << 16U |
         static_cast<std::uint32_t>(bytes[at + 2]) << 8U | bytes[at + 3];
}

void put(std::vector<std::uint8_t>& bytes, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(value >> (24U - 8U * i));
}

std::vector<std::uint8_t> answer(std::uint32_t command, std::uint32_t seqnum, std::int32_t status) {
  std::vector<std::uint8_t> bytes(header_size);
  put(bytes, 0x00, command);
  put(bytes, 0x04, seqnum);
  put(bytes, 0x14, static_cast<std::uint32_t>(status));
  return bytes;
}

UsbSetup read_setup(std::span<const std::uint8_t> b) {
  const auto pair = [&](std::size_t at) { return static_cast<std::uint16_t>(b[at] | (b[at + 1] << 8U)); };
  return {b[0], b[1], pair(2), pair(4), pair(6)};
}

std::string wrong(const char* what, std::uint32_t found) {
  char text[96];
  std::snprintf(text, sizeof text, "usbip: expected %s, found 0x%x", what, found);
  return text;
}

}  // namespace

std::string read_request(std::span<const std::uint8_t, header_size> header, Request& request) {
  request = {};
  const std::uint32_t command = word(header, 0x00);
  if (command != cmd_submit && command != cmd_unlink) return wrong("a command of 1 or 2", command);
  request.unlink = command == cmd_unlink;
  request.seqnum = word(header, 0x04);
  if (request.unlink) {
    request.unlinked = word(header, 0x14);
    return {};
  }
  const std::uint32_t direction = word(header, 0x0c), endpoint = word(header, 0x10), packets = word(header, 0x20);
  if (direction > 1) return wrong("a direction of 0 or 1", direction);
  if (endpoint > 15) return wrong("an endpoint from 0 to 15", endpoint);
  request.endpoint = static_cast<std::uint8_t>(endpoint | direction << 7U);
  request.length = word(header, 0x18);
  if (request.length > data_max) return wrong("a transfer of at most 0x100000 bytes", request.length);
  if (packets != 0 && packets != no_packets) return wrong("no isochronous packets", packets);
  request.setup = read_setup(header.subspan(0x28, 8));
  return {};
}

std::vector<std::uint8_t> submit_answer(std::uint32_t seqnum, std::int32_t status, std::uint32_t actual,
                                        std::span<const std::uint8_t> data) {
  std::vector<std::uint8_t> bytes = answer(ret_submit, seqnum, status);
  put(bytes, 0x18, actual);
  bytes.insert(bytes.end(), data.begin(), data.end());
  return bytes;
}

std::vector<std::uint8_t> unlink_answer(std::uint32_t seqnum, std::int32_t status) {
  return answer(ret_unlink, seqnum, status);
}

int free_port(const std::string& status) {
  std::istringstream lines(status);
  for (std::string line; std::getline(lines, line);) {
    int port = 0;
    unsigned state = 0;
    if (std::sscanf(line.c_str(), "hs %d %u", &port, &state) == 2 && state == port_is_free) return port;
  }
  return -1;
}

}  // namespace usbip

namespace {

constexpr std::size_t pending_max = 1024;
constexpr double closed_after = 0.5;    // s without a transfer on its way
constexpr double longest_pause = 0.02;  // s; a stopped process has not seen whether there was one
constexpr std::uint8_t kind_endpoint = 5, kind_interrupt = 3;

/// Kinds of the endpoints that descriptors tell of; those of other shape tell of none.
std::array<std::uint8_t, 256> endpoint_kinds(std::span<const std::uint8_t> descriptors) {
  std::array<std::uint8_t, 256> kinds{};
  while (descriptors.size() >= 2 && descriptors[0] >= 2 && descriptors[0] <= descriptors.size()) {
    if (descriptors[1] == kind_endpoint && descriptors[0] >= 7) kinds[descriptors[2]] = descriptors[3] & 3U;
    descriptors = descriptors.subspan(descriptors[0]);
  }
  return kinds;
}

}  // namespace

UsbipServer::UsbipServer(UsbFunction& function) : function_(function), kinds_(endpoint_kinds(function.descriptors())) {}

UsbipServer::~UsbipServer() {
  if (open_) function_.closed();
}

std::string UsbipServer::receive(std::span<const std::uint8_t> bytes) {
  if (broken_) return "usbip: the connection was given up";
  received_.insert(received_.end(), bytes.begin(), bytes.end());
  std::span<const std::uint8_t> left(received_);
  std::string problem;
  while (problem.empty() && left.size() >= usbip::header_size) {
    usbip::Request request;
    problem = usbip::read_request(left.first<usbip::header_size>(), request);
    const std::size_t whole = usbip::header_size + request.data_size();
    if (!problem.empty() || left.size() < whole) break;
    problem = handle(request, left.subspan(usbip::header_size, request.data_size()));
    left = left.subspan(whole);
  }
  received_.erase(received_.begin(), received_.end() - static_cast<std::ptrdiff_t>(left.size()));
  broken_ = !problem.empty();
  return problem;
}

std::string UsbipServer::handle(const usbip::Request& request, std::span<const std::uint8_t> data) {
  if (request.unlink) {
    unlink(request);
  } else if ((request.endpoint & 0x0fU) == 0) {
    control(request, data);
  } else if (kinds_[request.endpoint] == 0) {
    send(usbip::submit_answer(request.seqnum, -EPIPE, 0));
  } else {
    return keep(request, data);
  }
  return {};
}

void UsbipServer::unlink(const usbip::Request& request) {
  const auto found = std::find_if(pending_.begin(), pending_.end(),
                                  [&](const Transfer& t) { return t.request.seqnum == request.unlinked; });
  const bool was_there = found != pending_.end();
  if (was_there) pending_.erase(found);
  send(usbip::unlink_answer(request.seqnum, was_there ? -ECONNRESET : 0));
}

void UsbipServer::control(const usbip::Request& request, std::span<const std::uint8_t> data) {
  std::vector<std::uint8_t> room(data.begin(), data.end());
  room.resize(std::min<std::size_t>(request.setup.length, request.length));
  const auto went = function_.control(request.setup, room);
  const std::size_t n = went ? std::min(*went, room.size()) : 0;
  room.resize(request.in() ? n : 0);
  send(usbip::submit_answer(request.seqnum, went ? 0 : -EPIPE, static_cast<std::uint32_t>(n), room));
}

std::string UsbipServer::keep(const usbip::Request& request, std::span<const std::uint8_t> data) {
  if (pending_.size() >= pending_max) return "usbip: more transfers on their way than a host has";
  if (!open_) function_.opened();
  open_ = true;
  pending_.push_back({request, {data.begin(), data.end()}, kinds_[request.endpoint] == kind_interrupt});
  return {};
}

/// Does a transfer; false where the device is not ready for it.
bool UsbipServer::serve(const Transfer& transfer) {
  const usbip::Request& request = transfer.request;
  if (!request.in()) {
    function_.out(request.endpoint, transfer.data);
    send(usbip::submit_answer(request.seqnum, 0, request.length));
    return true;
  }
  const auto bytes = function_.in(request.endpoint);
  if (!bytes) return false;
  const std::size_t n = std::min<std::size_t>(bytes->size(), request.length);
  const std::int32_t status = bytes->size() > n ? -EOVERFLOW : 0;
  send(usbip::submit_answer(request.seqnum, status, static_cast<std::uint32_t>(n), std::span(*bytes).first(n)));
  return true;
}

void UsbipServer::frame(double dt) {
  if (!open_) return;
  function_.tick(dt);
  idle_ = pending_.empty() ? idle_ + std::min(dt, longest_pause) : 0;
  std::array<bool, 256> had{};  // interrupt endpoints, and those of bulk that were not ready
  // What is sent can be answered in the same frame.
  for (const bool in : {false, true}) {
    std::deque<Transfer> still;
    for (Transfer& transfer : pending_) {
      const std::uint8_t endpoint = transfer.request.endpoint;
      const bool done = transfer.request.in() == in && !had[endpoint] && serve(transfer);
      if (transfer.request.in() == in && (!done || transfer.interrupt)) had[endpoint] = true;
      if (!done) still.push_back(std::move(transfer));
    }
    pending_ = std::move(still);
  }
  if (idle_ < closed_after) return;
  open_ = false;
  idle_ = 0;
  function_.closed();
}

std::vector<std::uint8_t> UsbipServer::take() {
  std::vector<std::uint8_t> bytes;
  bytes.swap(outgoing_);
  return bytes;
}

void UsbipServer::send(const std::vector<std::uint8_t>& bytes) {
  outgoing_.insert(outgoing_.end(), bytes.begin(), bytes.end());
}

}  // namespace tactor
