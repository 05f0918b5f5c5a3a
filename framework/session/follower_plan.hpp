// The plan of a reference that follows a live run.
#pragma once

#include <string>
#include <vector>

#include "framework/graph/plan.hpp"

namespace tactor {

class Registry;

/// The plan that follows a run, and the outputs of the run that it needs.
struct FollowerPlan {
  /// An output of a device of the run, and the node of the plan that is fed with it.
  struct Fed {
    std::string output;
    std::string node;
  };
  Plan plan;
  std::vector<Fed> fed;
  std::string reference;     ///< the output of the plan that is the truth
  std::string judged;        ///< the output of the run that is compared with it
  double handle_mass = 0.1;  ///< kg, as the sink that compares has it
};

/// The reference run of `tested`, with its devices replaced by feeds of the states that they showed (of the `truth`, if
/// a device has it). So it computes physics for every sample of the device, and drives no hardware. If several sinks
/// compare a force with a reference, the first one counts. Throws InputError if there is none, or if physics has
/// sources other than the devices.
FollowerPlan plan_follower(const Plan& tested, Registry& registry);

}  // namespace tactor
