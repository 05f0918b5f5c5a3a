// What went wrong in a run, as its flight file tells it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "framework/realtime/flight_log.hpp"

namespace tactor {

/// What was found, the gravest first: of two findings the graver one is the fault.
enum class FlightFault : std::uint8_t {
  crashed,        ///< a signal ended the process
  killed,         ///< the process ended without a word
  stalled,        ///< a step did not come back
  failed,         ///< the run ended with a failure, mostly because a node threw
  line_failed,    ///< the line to a device gave no good sample
  device_failed,  ///< a device could not be read or written
  not_finite,     ///< a node sent NaN or infinity
  too_fast,       ///< the handle was faster than allowed
  late_result,    ///< no fresh force came in time
  expired,        ///< the device let go of a command that was not renewed in time
  long_step,      ///< a step in a loop took longer than its period
  late_wake,      ///< a loop woke late
  outside,        ///< the handle left the workspace
  other_cut,      ///< the gate kept the force out for another reason
  energy,         ///< the motors gave more than is allowed, or the bound held them back
  limited,        ///< more force was wanted than the gate lets through
};
/// The name of a fault, as tables and files spell it.
std::string_view name_of(FlightFault fault);

struct FlightFinding {
  FlightFault fault = FlightFault::other_cut;
  std::string node;  ///< whose fault it is; empty: the process
  Time time;         ///< when it began, since the start of the run
  std::string words;
  bool ended_run = false;  ///< the run ended with it
  bool cut_force = false;  ///< the gate kept the force out because of it
  double size_s = 0;       ///< of a late wake-up or a long step: how late, how long
};

/// What is found in the log: the fault first, then the others by their time. `is_running`: the process lives. Empty:
/// nothing went wrong. The fault is what ended the run, else what cut the force, else the gravest; of several late
/// wake-ups the latest, of others the first.
///
/// A cause stands in place of what followed from it: a line that fell silent, not the reading that failed; a step that
/// did not come back, not the force that came too late.
std::vector<FlightFinding> find_faults(const FlightLog& log, bool is_running);

}  // namespace tactor
