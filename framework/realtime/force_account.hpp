// What became of the force of a device over a whole run, counted at its ticks.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "framework/core/messages.hpp"

namespace tactor {

/// Counts of ticks, by cause.
using TicksByCause = std::array<std::uint64_t, safety_cause_count>;

/// What a safety gate counts.
struct GateAccount {
  std::uint64_t ticks = 0;
  std::uint64_t wanted = 0;    ///< ticks at which the pipeline wanted a wrench other than zero
  std::uint64_t forced = 0;    ///< ticks at which a wrench of the pipeline went out
  std::uint64_t braked = 0;    ///< ticks at which a brake went out
  std::uint64_t no_room = 0;   ///< of `wanted`, those that force_max and torque_max leave nothing of
  TicksByCause present{};      ///< ticks at which a cause was there, whatever was wanted
  TicksByCause withheld{};     ///< of `wanted`, those at which nothing went out, each under the most serious cause
  TicksByCause begun{};        ///< ticks at which a cause came up
  std::uint64_t faults = 0;    ///< times that the gate went into fault
  std::uint64_t engaged = 0;   ///< ticks in state engaged
  std::uint64_t clamped = 0;   ///< ticks whose wanted wrench was beyond force_max or torque_max
  std::uint64_t slewed = 0;    ///< ticks at which the slew limit changed the wrench
  std::uint64_t rejected = 0;  ///< ticks whose wanted wrench was not finite
};

/// What a device counts.
struct ForceAccount {
  GateAccount gate;
  std::int32_t dead_man_button = 0;  ///< 0: there is none
  bool fed = false;                  ///< an edge ends at its input `segment`
  std::uint64_t segments = 0;        ///< seen at a tick
  std::uint64_t refused = 0;         ///< of these: older than one before, or of times that cannot be
  std::uint64_t not_fresh = 0;       ///< of these: made from too old a sample, or too long under way
  /// Hardware: cycles of the line that gave the device an effort other than zero. Absent: there is no line.
  std::optional<std::uint64_t> carried;
};

}  // namespace tactor
