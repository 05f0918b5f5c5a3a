#include "udp_link.hpp"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "devices/hardware/device_descriptors.hpp"

namespace example_nodes {

std::string UdpLink::name() const {
  return "arm at port " + std::to_string(port_);
}

bool UdpLink::open(tactor::LinkFailure& failure) {
  {
    // No child of this program may keep the line to the machine.
    const tactor::NoFork until_kept;
    socket_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    tactor::keep_from_children(socket_);
  }
  sockaddr_in machine{};
  machine.sin_family = AF_INET;
  machine.sin_port = htons(static_cast<std::uint16_t>(port_));
  machine.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const timeval patience{0, 20'000};
  if (socket_ < 0 || setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience) != 0 ||
      connect(socket_, reinterpret_cast<const sockaddr*>(&machine), sizeof machine) != 0) {
    failure = {tactor::LinkError::disconnected, std::strerror(errno), true};
    close();
    return false;
  }
  // Nothing but zero is sent before the machine has answered.
  tactor::LinkSample ignored;
  if (exchange({}, ignored, failure)) return true;
  close();
  return false;
}

bool UdpLink::exchange(const tactor::LinkCommand& command, tactor::LinkSample& sample, tactor::LinkFailure& failure) {
  Command sent;
  sent.number = ++number_;
  std::copy_n(command.effort.begin(), 3, sent.force.begin());
  if (send(socket_, &sent, sizeof sent, 0) != sizeof sent) {
    failure = {tactor::LinkError::reset, std::strerror(errno), true};
    return false;
  }
  Answer answer;
  do {  // what came late is an answer to an earlier cycle
    const ssize_t bytes = recv(socket_, &answer, sizeof answer, 0);
    if (bytes < 0) {
      const bool late = errno == EAGAIN || errno == EWOULDBLOCK;
      failure = {late ? tactor::LinkError::timeout : tactor::LinkError::reset,
                 late ? "no answer in 20 ms" : std::strerror(errno), !late};
      return false;
    }
    if (bytes != sizeof answer) {
      failure = {tactor::LinkError::protocol, "an answer of " + std::to_string(bytes) + " bytes", false};
      return false;
    }
  } while (answer.number != number_);
  std::copy_n(answer.position.begin(), 3, sample.q.begin());
  sample.faults = answer.faults;
  if (answer.faults != 0) failure = {tactor::LinkError::device_fault, "the machine reports a fault", false};
  return true;
}

void UdpLink::close() {
  if (socket_ < 0) return;
  const Command zero{.number = ++number_, .force = {}};
  static_cast<void>(send(socket_, &zero, sizeof zero, 0));
  tactor::close_kept(socket_);
  socket_ = -1;
}

}  // namespace example_nodes
