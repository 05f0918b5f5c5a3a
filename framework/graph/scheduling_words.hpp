// The words of graph files for lanes, policies and what happens where real time is not to be had.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "framework/core/scheduling.hpp"

namespace tactor {

/// Each list is in the order of its enumeration.
inline const std::vector<std::string> lane_words{"pool", "thread", "realtime"};
inline const std::vector<std::string> policy_words{"other", "fifo", "round_robin"};
inline const std::vector<std::string> on_missing_privilege_words{"warn", "fail"};
inline const std::vector<std::string> on_stall_words{"stop", "recover"};

inline const std::vector<std::string> flight_words{"auto", "keep", "off"};

inline const std::string& word(Lane value) {
  return lane_words[static_cast<std::size_t>(value)];
}
inline const std::string& word(SchedulingPolicy value) {
  return policy_words[static_cast<std::size_t>(value)];
}
inline const std::string& word(OnMissingPrivilege value) {
  return on_missing_privilege_words[static_cast<std::size_t>(value)];
}
inline const std::string& word(OnStall value) {
  return on_stall_words[static_cast<std::size_t>(value)];
}
inline const std::string& word(FlightChoice value) {
  return flight_words[static_cast<std::size_t>(value)];
}

/// The value that the word at the same place of its list stands for.
template <class E>
E value_of(const std::string& text, const std::vector<std::string>& words) {
  std::size_t i = 0;
  while (words.at(i) != text) ++i;
  return static_cast<E>(i);
}

/// Bounds of the keys that say them.
inline constexpr int lowest_priority = 1;
inline constexpr int highest_priority = 99;
inline constexpr int highest_cpu = 1023;  ///< the system's sets of cores end there
inline constexpr int max_pool_workers = 64;

}  // namespace tactor
