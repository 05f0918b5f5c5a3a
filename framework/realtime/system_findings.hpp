// Judges the facts of a machine: what is good for a real-time loop, what is not, what that costs, and the remedy.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "framework/realtime/system_probe.hpp"

namespace tactor {

enum class Grade : std::uint8_t {
  ok,
  degraded,  ///< a loop of 1 kHz runs, and its latency is worse than it could be
  bad,       ///< a loop of 1 kHz will miss deadlines as a rule
};

std::string_view to_string(Grade grade);

/// One fact, judged.
struct Finding {
  std::string id;     ///< for programs: `fifo`, `memory_lock`
  std::string title;  ///< for people, at most 16 characters
  Grade grade = Grade::ok;
  std::string found;   ///< what there is
  std::string cost;    ///< what it costs, or empty
  std::string remedy;  ///< as Refusal::remedy; empty where it is ok
};

/// The findings, always the same ids in the same order.
std::vector<Finding> judge(const SystemFacts& facts);

/// The worst of the grades.
Grade worst(const std::vector<Finding>& findings);

}  // namespace tactor
