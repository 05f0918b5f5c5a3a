// Why no force of the pipeline reached a device in a whole run, decided by what its gate, its line and the nodes before
// it have counted.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "framework/engine/plan_nodes.hpp"
#include "framework/engine/run_statistics.hpp"
#include "framework/realtime/force_account.hpp"

namespace tactor {

/// What kept a force from a device, or that none was asked for.
enum class NoForceReason : std::uint8_t {
  never_ticked,
  device_not_ready,  ///< it never showed a position
  read_failed,
  write_failed,
  dead_man,           ///< its button was not held
  outside_workspace,  ///< its handle was beyond the end of its workspace
  not_fed,            ///< no edge ends at its input
  results_refused,    ///< a node before it could use nothing that came
  no_result,          ///< a node before it sent nothing
  segments_refused,   ///< the device could use none of the forces that came
  segments_not_fresh,
  not_permitted,  ///< the run ended before it let devices engage
  no_room,        ///< its largest force is zero
  not_finite,
  overspeed,
  time_reversed,
  stale,
  mixed,  ///< several causes, of which none explains all
  line,   ///< the gate let forces through, and the line carried none
  no_contact,
  not_asked,  ///< the pipeline wanted zero
};

/// `dead_man`, `results_refused`, ...
std::string_view name_of(NoForceReason reason);

/// That no force of the pipeline reached a device.
struct NoForce {
  std::string device;
  NoForceReason reason = NoForceReason::not_asked;
  std::uint64_t count = 0, of = 0;  ///< ticks, or messages that were refused
  std::string text;                 ///< `button 1 was never held`

  /// False where nothing stood in the way: the pipeline asked for no force.
  [[nodiscard]] bool was_withheld() const {
    return reason != NoForceReason::no_contact && reason != NoForceReason::not_asked;
  }
};

/// Of each device of the plan to which no force came. `edges`: what each carried; `touched`: false where the run knows
/// that nothing was in contact.
std::vector<NoForce> devices_without_force(const PlanNodes& nodes, const std::vector<EdgeStatistics>& edges,
                                           const std::vector<std::uint64_t>& steps, bool touched);

}  // namespace tactor
