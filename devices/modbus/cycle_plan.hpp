// The transactions that a profile's cycle takes, and how many cycles a second a line can carry.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "devices/modbus/profile.hpp"

namespace tactor::modbus {

/// One request and its answer.
struct Transaction {
  int function = 3;  ///< 3, 4, 6, 16 or 23
  int read_address = 0, read_count = 0;
  int write_address = 0, write_count = 0;
};

/// What a cycle does: first what it writes, then what it reads. Reads join registers that are up to the profile's
/// read_gap apart. Each write goes by the function that its register declares; those by 16 or by 23 join neighbours
/// alone, so that no word is written that the profile does not name. A combined cycle writes its one block by 23 with
/// the first read by 3.
struct CyclePlan {
  std::vector<Transaction> each;    ///< in every cycle
  std::vector<Transaction> seldom;  ///< one of them, in turn, in every `seldom_every`-th cycle
  int seldom_every = 1;
  Fence fence;
  int longest_answer =
      9;  ///< characters on a serial line, of all answers to this plan, to the fence and to single registers
};

/// The fence is a read that no other one looks like, by function and count, be it in the cycle, of `identify` or of a
/// sequence: an answer to any of them may be under way when a line is opened anew. Throws YamlError, with the place in
/// the profile, where the profile names one that is not such, or names none and none is found among the registers that
/// can be read; it must name one then. Throws it too where what is declared as function 23 and the cycle do not agree,
/// which a profile that was read from a file never does.
CyclePlan plan_cycle(const Profile& profile);

/// Seconds that a transaction takes on a serial line: all characters of both frames, the turnaround of the device, and
/// the silence after each frame. Over TCP the turnaround alone.
double seconds_of(const Transaction& transaction, const LineSettings& line, bool serial);

/// The shortest time between two cycles: the longest one that the plan has, in s, and the rate that is reachable, Hz:
/// its inverse, and at most the rate_max of the device.
struct LineRate {
  double cycle_s = 0;
  double rate = 0;
};
LineRate line_rate(const CyclePlan& plan, const LineSettings& line, bool serial);

}  // namespace tactor::modbus
