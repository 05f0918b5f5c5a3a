// `machine PORT COMMAND...`: a machine in software, which answers while the command runs. A hand presses it down and lifts
// it.
#include <arpa/inet.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "protocol.hpp"

namespace {

/// 0.2 kg on each axis; a hand of 300 N/m and 8 N s/m leads it.
struct Machine {
  std::array<double, 3> position{0, 0, 0.012}, velocity{};
  double time = 0;

  void advance(double until, const std::array<double, 3>& force) {
    constexpr double h = 1e-4, mass = 0.2, stiffness = 300, damping = 8;
    for (; time < until; time += h) {
      const std::array<double, 3> hand{0, 0, 0.002 + 0.010 * std::cos(6.283 * time)};
      for (std::size_t i = 0; i < 3; ++i) {
        velocity[i] += h * (force[i] + stiffness * (hand[i] - position[i]) - damping * velocity[i]) / mass;
        position[i] += h * velocity[i];
      }
    }
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: %s PORT COMMAND...\n", argv[0]);
    return 2;
  }
  const int line = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_port = htons(static_cast<std::uint16_t>(std::atoi(argv[1])));
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const timeval patience{0, 50'000};
  if (bind(line, reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0 ||
      setsockopt(line, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience) != 0) {
    std::perror(argv[0]);
    return 1;
  }
  const pid_t command = fork();
  if (command == 0) {
    execvp(argv[2], argv + 2);
    std::perror(argv[2]);
    _exit(127);
  }
  Machine machine;
  std::array<double, 3> force{};
  const auto began = std::chrono::steady_clock::now();
  int status = 0;
  while (waitpid(command, &status, WNOHANG) == 0) {
    example_nodes::Command sent;
    sockaddr_in from{};
    socklen_t length = sizeof from;
    const ssize_t bytes = recvfrom(line, &sent, sizeof sent, 0, reinterpret_cast<sockaddr*>(&from), &length);
    const bool came = bytes == static_cast<ssize_t>(sizeof sent);
    const double now = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    machine.advance(now, force);
    force = came ? sent.force : std::array<double, 3>{};  // without commands it gives no force
    if (!came) continue;
    const example_nodes::Answer answer{.number = sent.number, .faults = 0, .position = machine.position};
    static_cast<void>(sendto(line, &answer, sizeof answer, 0, reinterpret_cast<const sockaddr*>(&from), length));
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}
