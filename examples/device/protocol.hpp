// What goes over the line: one datagram each way a cycle, numbers as this processor has them.
#pragma once

#include <array>
#include <cstdint>

namespace example_nodes {

struct Command {
  std::uint32_t number = 0;  // of the cycle; the answer repeats it
  std::uint32_t padding = 0;
  std::array<double, 3> force;  // N, along x, y, z
};

struct Answer {
  std::uint32_t number = 0;
  std::uint32_t faults = 0;        // 0: the machine is well
  std::array<double, 3> position;  // m
};

}  // namespace example_nodes
